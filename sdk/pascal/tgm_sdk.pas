// SPDX-License-Identifier: MIT
//
// tgm_sdk.pas - the SDK's support library for Pascal: start-up checks, text, motion helpers.
//
// They are the functions of sdk/include/tgm/start.h, text.h and motion.h, under the same names; those headers
// state contracts, units and behaviour, this unit says in a line what each one is for. Nothing needs to be set in the
// Makefile, and what is not called is not in the module.
//
// Text of a module in Pascal is UTF-16 (PWideChar): TG Motion takes Pascal on a PC only.
{$mode objfpc}
{$packrecords C}
unit tgm_sdk;

interface

// ---- Start ----------------------------------------------------------------------------------------------

const
  TGM_START_OK = 0;
  TGM_START_NO_DATA = 1; // pData is nil
  TGM_START_STRUCT_SIZE = 2; // structSize is not the size of the PLC_DATA this was compiled for
  TGM_START_NO_FUNCTION = 3; // a function pointer is nil
  TGM_START_NO_SYSTEM_MEMORY = 4; // no pointer to TGM_System
  TGM_START_COMPATIBILITY = 5; // HEADER.Compatibility_Id is not ID_COMPATIBILITY
  TGM_START_MEMORY = 6; // generation 5: HEADER.CompatibilityMem_Id is not ID_MEMORY_COMPATIBILITY

// Everything the manual advises for the beginning of Program_Ini: 1, or 0, and Program_Ini has to return 0; ids that
// differ are printed. The layout is that of the Makefile's TGM_GENERATION and TGM_MEMORY_ID.
{$if defined(TGM_MEMORY_905)}
function tgm_check_start(pData: Pointer): LongInt; cdecl; external name 'tgm_check_start_5_905';
function tgm_start_reason(pData: Pointer): LongInt; cdecl; external name 'tgm_start_reason_5_905';
{$elseif defined(TGM_MEMORY_906)}
function tgm_check_start(pData: Pointer): LongInt; cdecl; external name 'tgm_check_start_5_906';
function tgm_start_reason(pData: Pointer): LongInt; cdecl; external name 'tgm_start_reason_5_906';
{$else}
function tgm_check_start(pData: Pointer): LongInt; cdecl; external name 'tgm_check_start_4';
function tgm_start_reason(pData: Pointer): LongInt; cdecl; external name 'tgm_start_reason_4';
{$endif}

// ---- Text -----------------------------------------------------------------------------------------------

type
  // All members may be read, none written, between init and the last append.
  tgm_text = record
    buffer: PWideChar; // the text, ends with #0
    capacity: SizeUInt; // units of the buffer, the final #0 included
    length: SizeUInt; // units of the text, the final #0 not included
    truncated: LongInt; // 1: something did not fit
  end;

// Begins an empty text in a buffer of capacity WideChars. Every append function returns 1 when all fitted, else 0.
procedure tgm_text_init(var t: tgm_text; buffer: PWideChar; capacity: SizeUInt); cdecl; external name 'tgm_text16_init';
function tgm_text_utf16(var t: tgm_text; text: PWideChar): LongInt; cdecl; external name 'tgm_text16_utf16';
// At most max units, for a register of fixed size such as MAIN.PLC_Name.
function tgm_text_utf16_max(var t: tgm_text; text: PWideChar; max: SizeUInt): LongInt; cdecl; external name 'tgm_text16_utf16_max';
function tgm_text_character(var t: tgm_text; codePoint: LongWord): LongInt; cdecl; external name 'tgm_text16_character';
// width: least number of characters, filled from the left with pad, ' ' or '0'.
function tgm_text_signed(var t: tgm_text; value: Int64; width: LongWord; pad: AnsiChar): LongInt; cdecl; external name 'tgm_text16_signed';
function tgm_text_unsigned(var t: tgm_text; value: QWord; width: LongWord; pad: AnsiChar): LongInt; cdecl; external name 'tgm_text16_unsigned';
function tgm_text_hex(var t: tgm_text; value: QWord; width: LongWord; pad: AnsiChar): LongInt; cdecl; external name 'tgm_text16_hex';
function tgm_text_fixed(var t: tgm_text; value: Double; decimals, width: LongWord; pad: AnsiChar): LongInt; cdecl; external name 'tgm_text16_fixed';
// Appends ' ' until the text is column units long.
function tgm_text_column(var t: tgm_text; column: SizeUInt): LongInt; cdecl; external name 'tgm_text16_column';

// ---- Motion helpers -------------------------------------------------------------------------------------
// Times are microseconds: elapsedUs is the time since the previous call. A level is 0 or another number.

const
  TGM_EDGE_FALLING = -1;
  TGM_EDGE_NONE = 0;
  TGM_EDGE_RISING = 1;
  TGM_DIO4_BITS = 128; // 16 words of 8 bits
  TGM_DIO5_BITS = 512; // 16 words of 32 bits

type
  tgm_edge = record
    level: LongInt; // at the last call
  end;
  tgm_tick = record
    last: LongWord;
  end;
  tgm_debounce = record
    level: LongInt; // the accepted level
    differs: LongInt; // the input was different from it at the last call
    elapsed_us: QWord; // for how long
    hold_us: QWord; // how long it must be; may be written
  end;
  tgm_ton = record
    preset_us: QWord; // may be written
    elapsed_us: QWord;
    input: LongInt; // at the last call
    output: LongInt;
  end;
  tgm_tof = tgm_ton;
  tgm_tp = tgm_ton;
  tgm_ramp = record
    value: Double; // may be written: jumps there
    up: Double; // largest growth, unit per second; may be written
    down: Double; // largest decline, unit per second, as a positive number; may be written
  end;
  tgm_move = record
    position: Double; // unit; the set-point of this cycle
    speed: Double; // unit/s, with sign, at the end of this cycle
    target: Double; // unit; after a stop, where it came to rest
    speed_limit: Double; // unit/s, > 0
    acceleration: Double; // unit/s2, > 0
    deceleration: Double; // unit/s2, > 0
    cycle: Double; // s
    stopping: LongInt; // 1 from tgm_move_stop to the rest
  end;

// Edge detector: the step returns TGM_EDGE_...
procedure tgm_edge_init(var e: tgm_edge; level: LongInt); cdecl; external name 'tgm_edge_init';
function tgm_edge_step(var e: tgm_edge; level: LongInt): LongInt; cdecl; external name 'tgm_edge_step';
// Counts since the last call, right across the wrap of the counter.
procedure tgm_tick_init(var t: tgm_tick; now: LongWord); cdecl; external name 'tgm_tick_init';
function tgm_tick_elapsed(var t: tgm_tick; now: LongWord): LongWord; cdecl; external name 'tgm_tick_elapsed';
// The input once it has kept its level for holdUs.
procedure tgm_debounce_init(var d: tgm_debounce; level: LongInt; holdUs: QWord); cdecl; external name 'tgm_debounce_init';
function tgm_debounce_step(var d: tgm_debounce; input: LongInt; elapsedUs: LongWord): LongInt; cdecl; external name 'tgm_debounce_step';
// On-delay, off-delay and pulse of IEC 61131-3.
procedure tgm_ton_init(var t: tgm_ton; presetUs: QWord); cdecl; external name 'tgm_ton_init';
function tgm_ton_step(var t: tgm_ton; input: LongInt; elapsedUs: LongWord): LongInt; cdecl; external name 'tgm_ton_step';
procedure tgm_tof_init(var t: tgm_tof; presetUs: QWord); cdecl; external name 'tgm_tof_init';
function tgm_tof_step(var t: tgm_tof; input: LongInt; elapsedUs: LongWord): LongInt; cdecl; external name 'tgm_tof_step';
procedure tgm_tp_init(var t: tgm_tp; presetUs: QWord); cdecl; external name 'tgm_tp_init';
function tgm_tp_step(var t: tgm_tp; input: LongInt; elapsedUs: LongWord): LongInt; cdecl; external name 'tgm_tp_step';
// A value that follows another no faster than given.
procedure tgm_ramp_init(var r: tgm_ramp; value, up, down: Double); cdecl; external name 'tgm_ramp_init';
function tgm_ramp_step(var r: tgm_ramp; target: Double; elapsedUs: LongWord): Double; cdecl; external name 'tgm_ramp_step';
// A set-point that moves to a target with limited speed, acceleration and deceleration.
procedure tgm_move_init(var m: tgm_move; position: Double; cycleUs: LongWord); cdecl; external name 'tgm_move_init';
function tgm_move_set(var m: tgm_move; position: Double): LongInt; cdecl; external name 'tgm_move_set';
function tgm_move_limits(var m: tgm_move; speedLimit, acceleration, deceleration: Double): LongInt; cdecl; external name 'tgm_move_limits';
function tgm_move_to(var m: tgm_move; target: Double): LongInt; cdecl; external name 'tgm_move_to';
procedure tgm_move_stop(var m: tgm_move); cdecl; external name 'tgm_move_stop';
function tgm_move_step(var m: tgm_move): Double; cdecl; external name 'tgm_move_step';
function tgm_move_done(constref m: tgm_move): LongInt; cdecl; external name 'tgm_move_done';
// Bits of I/O units: tgm_dio4_get(@dio^.In0, 9), tgm_dio5_set(@dio^.&Out[0], 33, 1). Bit 0 is the first one.
function tgm_dio4_get(words: PLongInt; bit: LongWord): LongInt; cdecl; external name 'tgm_dio4_get';
procedure tgm_dio4_set(words: PLongInt; bit: LongWord; level: LongInt); cdecl; external name 'tgm_dio4_set';
function tgm_dio5_get(words: PLongWord; bit: LongWord): LongInt; cdecl; external name 'tgm_dio5_get';
procedure tgm_dio5_set(words: PLongWord; bit: LongWord; level: LongInt); cdecl; external name 'tgm_dio5_set';

implementation

end.
