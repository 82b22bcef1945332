// SPDX-License-Identifier: MIT
//
// tgm_math.pas - mathematical functions of a module: Sin, Power, ArcTan2 and their kind, without a run-time library.
//
// To use them: MATH := yes in the module's Makefile, before the include of pascal.mk, and
//
//     uses tgm_gen4, tgm_math;
//
// They are the functions of sdk/include/tgm/math.h, which states accuracy (less than 1 unit in the last place),
// behaviour for bad arguments (NaN or an infinity; nothing traps) and cost; the names are those of Pascal's units
// System and Math where these have one. Angles are in radians. Abs, Sqr, Sqrt, Trunc, Round, Int and Frac need
// neither this unit nor the library.
unit tgm_math;

interface

const
  DEGREES = Double(57.295779513082320877); // x * DEGREES: x radians in degrees

function Sin(x: Double): Double; cdecl; external name 'sin';
function Cos(x: Double): Double; cdecl; external name 'cos';
function Tan(x: Double): Double; cdecl; external name 'tan';
function ArcSin(x: Double): Double; cdecl; external name 'asin';
function ArcCos(x: Double): Double; cdecl; external name 'acos';
function ArcTan(x: Double): Double; cdecl; external name 'atan';
function ArcTan2(y, x: Double): Double; cdecl; external name 'atan2'; // angle of the point (x, y) in [-pi, pi]
procedure SinCos(x: Double; out sine, cosine: Double); cdecl; external name 'sincos';
function Sinh(x: Double): Double; cdecl; external name 'sinh';
function Cosh(x: Double): Double; cdecl; external name 'cosh';
function Tanh(x: Double): Double; cdecl; external name 'tanh';
function Exp(x: Double): Double; cdecl; external name 'exp';
function ExpM1(x: Double): Double; cdecl; external name 'expm1'; // Exp(x) - 1, accurate near 0
function Ln(x: Double): Double; cdecl; external name 'log';
function LnXP1(x: Double): Double; cdecl; external name 'log1p'; // Ln(1 + x), accurate near 0
function Log2(x: Double): Double; cdecl; external name 'log2';
function Log10(x: Double): Double; cdecl; external name 'log10';
function Power(x, y: Double): Double; cdecl; external name 'pow';
function Cbrt(x: Double): Double; cdecl; external name 'cbrt';
function Hypot(x, y: Double): Double; cdecl; external name 'hypot';
function Floor(x: Double): Double; cdecl; external name 'floor';
function Ceil(x: Double): Double; cdecl; external name 'ceil';
function RoundAway(x: Double): Double; cdecl; external name 'round'; // to the nearest, halves away from 0
function FMod(x, y: Double): Double; cdecl; external name 'fmod';
function Remainder(x, y: Double): Double; cdecl; external name 'remainder';
function Min(x, y: Double): Double; cdecl; external name 'fmin';
function Max(x, y: Double): Double; cdecl; external name 'fmax';
function CopySign(size, sign: Double): Double; cdecl; external name 'copysign';

implementation

end.
