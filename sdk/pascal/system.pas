// SPDX-License-Identifier: MIT
//
// system.pas - what Free Pascal's compiler needs to know before the first line of a module, and no more.
//
// The compiler takes this unit in place of its run-time library's, because a TG Motion module is linked
// to nothing, has no heap and calls no operating system. What would need one of them is not here, so it
// is an error at compile time: strings, dynamic arrays, GetMem and New, files, classes, exceptions. What is
// here costs nothing that is not used: the linker drops the rest.
//
// Compiled with -Us, by sdk/mk/pascal.mk. Names and numbers marked "compiler" are fixed by Free Pascal 3.2;
// it looks them up.
{$J-}
unit system;

interface

type
  Integer = LongInt; // in every mode of the compiler
  Cardinal = LongWord;
  DWord = LongWord;
  Real = Double;
  ValReal = Double; // what Sqrt and the like compute in; the compiler keeps Single for Single
  AnsiChar = Char;
  Int8 = ShortInt;
  Int16 = SmallInt;
  Int32 = LongInt;
  UInt8 = Byte;
  UInt16 = Word;
  UInt32 = LongWord;
  UInt64 = QWord;
{$ifdef CPU64}
  SizeInt = Int64;
  SizeUInt = QWord;
{$else}
  SizeInt = LongInt;
  SizeUInt = LongWord;
{$endif}
  PtrInt = SizeInt;
  PtrUInt = SizeUInt;
  NativeInt = SizeInt;
  NativeUInt = SizeUInt;

  PPointer = ^Pointer;
  PBoolean = ^Boolean;
  PByte = ^Byte;
  PShortInt = ^ShortInt;
  PWord = ^Word;
  PSmallInt = ^SmallInt;
  PInteger = ^LongInt;
  PLongInt = ^LongInt;
  PLongWord = ^LongWord;
  PCardinal = ^LongWord;
  PDWord = ^LongWord;
  PInt32 = ^LongInt;
  PUInt32 = ^LongWord;
  PInt64 = ^Int64;
  PQWord = ^QWord;
  PUInt64 = ^QWord;
  PSizeUInt = ^SizeUInt;
  PPtrUInt = ^PtrUInt;
  PSingle = ^Single;
  PDouble = ^Double;
  PReal = ^Double;
  PChar = ^Char;
  PAnsiChar = ^Char;
  PWideChar = ^WideChar; // text of TG Motion: UTF-16, ends with #0; a literal fits where one is wanted
  PPWideChar = ^PWideChar;

  // Compiler: it reads these definitions even when no code uses them.
  HRESULT = LongInt;
  TTypeKind = (tkUnknown);
  TGuid = packed record
    D1: LongWord;
    D2, D3: Word;
    D4: array[0..7] of Byte;
  end;
  jmp_buf = packed record
    Registers: array[0..15] of Pointer;
  end;
  PJmp_buf = ^jmp_buf;
  TExceptAddr = record
    Buf: PJmp_buf;
    Next: Pointer;
    FrameType: LongInt;
  end;

const
  MaxInt = $7FFFFFFF;
  Pi = Double(3.14159265358979323846);

{ Compiled in place; the numbers are the compiler's. }
function Abs(x: LongInt): LongInt; [internproc: 101];
function Abs(x: Int64): Int64; [internproc: 101];
function Abs(x: ValReal): ValReal; [internproc: 127];
function Sqr(x: LongInt): LongInt; [internproc: 100];
function Sqr(x: Int64): Int64; [internproc: 100];
function Sqr(x: ValReal): ValReal; [internproc: 128];
function Sqrt(x: ValReal): ValReal; [internproc: 129];
function Trunc(x: ValReal): Int64; [internproc: 120]; // towards 0
function Round(x: ValReal): Int64; [internproc: 121]; // to the nearest, halves to even
function Odd(x: LongInt): Boolean; [internproc: 102];
function Odd(x: LongWord): Boolean; [internproc: 102];
function Odd(x: Int64): Boolean; [internproc: 102];
function Odd(x: QWord): Boolean; [internproc: 102];
function Chr(x: Byte): Char; [internproc: 7];
function Lo(x: Word): Byte; [internproc: 1];
function Lo(x: SmallInt): Byte; [internproc: 1];
function Lo(x: LongWord): Word; [internproc: 3];
function Lo(x: LongInt): Word; [internproc: 3];
function Lo(x: QWord): LongWord; [internproc: 106];
function Lo(x: Int64): LongWord; [internproc: 106];
function Hi(x: Word): Byte; [internproc: 2];
function Hi(x: SmallInt): Byte; [internproc: 2];
function Hi(x: LongWord): Word; [internproc: 4];
function Hi(x: LongInt): Word; [internproc: 4];
function Hi(x: QWord): LongWord; [internproc: 107];
function Hi(x: Int64): LongWord; [internproc: 107];

{ Whole part, towards 0, and the rest. }
function Int(x: Double): Double; inline;
function Frac(x: Double): Double; inline;

{ Memory. Size in bytes; Move allows the two places to overlap. }
procedure FillChar(var place; size: SizeInt; value: Byte);
procedure Move(const from; var place; size: SizeInt);
function CompareByte(const a, b; size: SizeInt): SizeInt; // 0 when equal, else the sign of the first difference

{ Compiler: called where it compiles nothing in place. }
function fpc_trunc_real(x: ValReal): Int64; compilerproc;
function fpc_round_real(x: ValReal): Int64; compilerproc;
function fpc_sqrt_real(x: ValReal): ValReal; compilerproc;

{$codealign constmin=16} // they are operands of andps and andpd
const
  // Compiler: all bits of a Single and of a Double except the sign, as wide as a register.
  FPC_ABSMASK_SINGLE: array[0..1] of QWord = ($7FFFFFFF7FFFFFFF, $7FFFFFFF7FFFFFFF); public name 'FPC_ABSMASK_SINGLE';
  FPC_ABSMASK_DOUBLE: array[0..1] of QWord = ($7FFFFFFFFFFFFFFF, $7FFFFFFFFFFFFFFF); public name 'FPC_ABSMASK_DOUBLE';
{$codealign constmin=0}

implementation

const
  WHOLE_FROM = Double(4503599627370496.0); // 2^52: from here every Double is a whole number

function Int(x: Double): Double; inline;
begin
  if (x < WHOLE_FROM) and (x > -WHOLE_FROM) then
    Int := Trunc(x)
  else
    Int := x;
end;

function Frac(x: Double): Double; inline;
begin
  Frac := x - Int(x);
end;

procedure FillChar(var place; size: SizeInt; value: Byte);
var
  at: PByte;
begin
  at := @place;
  while size > 0 do
  begin
    at^ := value;
    inc(at);
    dec(size);
  end;
end;

procedure Move(const from; var place; size: SizeInt);
var
  source, target: PByte;
begin
  source := @from;
  target := @place;
  if PtrUInt(target) <= PtrUInt(source) then
    while size > 0 do
    begin
      target^ := source^;
      inc(source);
      inc(target);
      dec(size);
    end
  else
    while size > 0 do
    begin
      dec(size);
      target[size] := source[size];
    end;
end;

function CompareByte(const a, b; size: SizeInt): SizeInt;
var
  one, other: PByte;
begin
  one := @a;
  other := @b;
  CompareByte := 0;
  while size > 0 do
  begin
    if one^ <> other^ then
    begin
      CompareByte := SizeInt(one^) - other^;
      size := 0;
    end
    else
    begin
      inc(one);
      inc(other);
      dec(size);
    end;
  end;
end;

{$ifdef CPUX86_64}
{$asmmode intel}
function fpc_trunc_real(x: ValReal): Int64; compilerproc; assembler; nostackframe;
asm
  cvttsd2si rax, xmm0
end;

function fpc_round_real(x: ValReal): Int64; compilerproc; assembler; nostackframe;
asm
  cvtsd2si rax, xmm0
end;

function fpc_sqrt_real(x: ValReal): ValReal; compilerproc; assembler; nostackframe;
asm
  sqrtsd xmm0, xmm0
end;
{$endif}

end.
