// SPDX-License-Identifier: MIT
//
// objpas.pas - what a module must not use, each with the reason that its author gets to read.
//
// The compiler loads this unit before every other in the modes objfpc (the SDK's own) and delphi. A name
// here hides the compiler's built-in one. Its use is a warning "Symbol ... is deprecated: module: ..." that
// sdk/mk/fpc.sh turns into an error; what has no name to hide is refused by the compiler itself, because
// system.pas lacks the run-time library's part of it.
unit objpas;

interface

type
  Extended = Double deprecated 'module: 80 bits exist on one target only; use Double';
  CExtended = Double deprecated 'module: 80 bits exist on one target only; use Double';
  Comp = Int64 deprecated 'module: it is computed in 80 bits; use Int64 or Double';
  Currency = Int64 deprecated 'module: it is computed in 80 bits; use Int64 or Double';
  AnsiString = PChar deprecated 'module: a string needs a heap, a module has none; use PWideChar or array of WideChar';
  UnicodeString = PWideChar deprecated 'module: a string needs a heap, a module has none; use PWideChar or array of WideChar';
  WideString = PWideChar deprecated 'module: a string needs a heap, a module has none; use PWideChar or array of WideChar';
  ShortString = PChar deprecated 'module: strings need a run-time library; use PWideChar or array of WideChar';
  Variant = Pointer deprecated 'module: a variant needs a heap and an operating system, a module has neither';
  OleVariant = Pointer deprecated 'module: a variant needs a heap and an operating system, a module has neither';
  Text = Pointer deprecated 'module: files belong to an operating system, a module calls none';
  TypedFile = Pointer deprecated 'module: files belong to an operating system, a module calls none';

procedure GetMem(var p; size: SizeUInt); deprecated 'module: there is no heap; declare a variable of the size you need';
function GetMem(size: SizeUInt): Pointer; deprecated 'module: there is no heap; declare a variable of the size you need';
function AllocMem(size: SizeUInt): Pointer; deprecated 'module: there is no heap; declare a variable of the size you need';
function ReallocMem(var p; size: SizeUInt): Pointer; deprecated 'module: there is no heap; declare a variable of the size you need';
procedure FreeMem(var p); deprecated 'module: there is no heap; declare a variable of the size you need';
procedure FreeMem(var p; size: SizeUInt); deprecated 'module: there is no heap; declare a variable of the size you need';
procedure New(var p); deprecated 'module: there is no heap; declare a variable and take its address';
procedure Dispose(var p); deprecated 'module: there is no heap; declare a variable and take its address';
procedure SetLength(var a; length: SizeInt); deprecated 'module: there is no heap; declare an array of fixed length';
procedure Halt(code: LongInt = 0); deprecated 'module: it cannot end the process; return 0 from Program_Ini';

implementation

procedure GetMem(var p; size: SizeUInt);
begin
end;

function GetMem(size: SizeUInt): Pointer;
begin
  GetMem := nil;
end;

function AllocMem(size: SizeUInt): Pointer;
begin
  AllocMem := nil;
end;

function ReallocMem(var p; size: SizeUInt): Pointer;
begin
  ReallocMem := nil;
end;

procedure FreeMem(var p);
begin
end;

procedure FreeMem(var p; size: SizeUInt);
begin
end;

procedure New(var p);
begin
end;

procedure Dispose(var p);
begin
end;

procedure SetLength(var a; length: SizeInt);
begin
end;

procedure Halt(code: LongInt);
begin
end;

end.
