// SPDX-License-Identifier: MIT
//
// shuttle.pas - a small machine to start from: one carriage on one servo, one I/O unit.
//
// It waits for the bus, enables the servo, looks for the home switch, and then moves the carriage
// back and forth with a trapezoidal speed profile that it computes itself, set-point by set-point,
// in Program_04. Input 0 of the I/O unit is mirrored to its output 0. What a screen wants to show
// lies in TGM_Data as ShuttleStatus.
//
// Every function keeps the order the manual asks for: read inputs, compute, write outputs.
// The same machine in C: the C template. A module in Pascal is a unit; README.md says why.
unit shuttle;

interface

uses
{$if defined(TGM_MEMORY_905)}
  tgm_gen5_905,
{$elseif defined(TGM_MEMORY_906)}
  tgm_gen5_906,
{$else}
  tgm_gen4,
{$endif}
  tgm_sdk;

// The six functions that TG Motion calls: exactly these names, letter case included.
function Program_Ini(pData: PPLC_DATA): LongInt; cdecl; public name 'Program_Ini';
function Program_01(pData: PPLC_DATA): LongInt; cdecl; public name 'Program_01';
function Program_02(pData: PPLC_DATA): LongInt; cdecl; public name 'Program_02';
function Program_03(pData: PPLC_DATA): LongInt; cdecl; public name 'Program_03';
function Program_04(pData: PPLC_DATA): LongInt; cdecl; public name 'Program_04';
function Program_05(pData: PPLC_DATA): LongInt; cdecl; public name 'Program_05';

implementation

const
  SHUTTLE_VERSION = 100; // 1.00
  LINE_SIZE = 80;

  // The machine, in revolutions of the motor and seconds. Double(...): README.md says why.
  HOMING_SPEED = Double(1.0); // rev/s, towards the home switch
  TRAVEL_SPEED = Double(8.0); // rev/s
  ACCELERATION = Double(40.0); // rev/s2
  STROKE_FROM = Double(1.0); // rev from the home switch
  STROKE_TO = Double(6.0);
  FAULT_PAUSE = Double(1.0); // s between a drive fault and the attempt to reset it
  HOME_SWITCH = $04; // bit of SERVO.DigitalIn; CiA 402 object 0x60FD, bit 2

type
  State = (WAIT_FOR_BUS, ENABLE, HOMING, HOMING_STOP, MOVING, FAULT);

  // At offset 0 of TGM_Data, for visualisation. Written by Program_04 only.
  ShuttleStatus = record
    version: LongWord;
    state: LongWord;
    strokes: LongWord; // ends reached since homing
    faults: LongWord; // drive faults seen
    position: Double; // rev from the home switch; 0 before homing
    speed: Double; // commanded, rev/s
  end;
  PShuttleStatus = ^ShuttleStatus;
{$if SizeOf(ShuttleStatus) <> 32}
  {$error the screen reads it by offset}
{$endif}

  // A point that moves to a target and never exceeds the speed and acceleration given.
  Profile = record
    position: Double; // inc
    speed: Double; // inc/s
  end;

  // What the machine sees in this cycle.
  Inputs = record
    busReady, enabled, fault, homeSwitch: Boolean;
    position: Double; // inc
    bits: LongInt;
  end;

// Nothing here has a value before Program_Ini gave it one: TG Motion does not initialise globals.
var
  plc: record
    system: PSYSTEM;
    servo: PSERVO;
    dio: PDIO;
    status: PShuttleStatus;
    cycle: Double; // s
    rev: Double; // inc per revolution
    state: State;
    pause: Double;
    home: Double; // inc
    target: Double;
    profile: Profile;
    strokes: LongWord;
    faults: LongWord;
    told: LongWord; // state last reported by Program_01
    line: array[0..LINE_SIZE - 1] of WideChar;
  end;

// What differs between the generations of TG Motion: names, the words of an I/O unit, the console.
{$ifdef TGM_GENERATION_4}
function SystemOf(pData: PPLC_DATA): PSYSTEM; inline;
begin
  SystemOf := pData^.PSystem_Memory;
end;

procedure FindMemories(pData: PPLC_DATA);
begin
  plc.system := pData^.PSystem_Memory;
  plc.servo := pData^.PServo_Memory;
  plc.dio := pData^.PDio_Memory;
  plc.status := pData^.PData_Memory;
end;

function InputBits: LongInt; inline; // the first octet
begin
  InputBits := plc.dio^.In0;
end;

procedure OutputBits(bits: LongInt); inline;
begin
  plc.dio^.Out0 := bits;
end;

procedure Say(pData: PPLC_DATA; text: PWideChar);
begin
  pData^.functions.pRtWprintf_String(text);
end;
{$else}
function SystemOf(pData: PPLC_DATA): PSYSTEM; inline;
begin
  SystemOf := pData^.pSystem_Memory;
end;

procedure FindMemories(pData: PPLC_DATA);
begin
  plc.system := pData^.pSystem_Memory;
  plc.servo := pData^.pServo_Memory;
  plc.dio := pData^.pDio_Memory;
  plc.status := pData^.pData_Memory;
end;

function InputBits: LongInt; inline; // the first 32 inputs
begin
  InputBits := LongInt(plc.dio^.&In[0]);
end;

procedure OutputBits(bits: LongInt); inline;
begin
  plc.dio^.&Out[0] := LongWord(bits);
end;

procedure Say(pData: PPLC_DATA; text: PWideChar);
begin
  pData^.functions.pRtWprintf_String_Severity(ODS_ID_PLC, text);
end;
{$endif}

// One step of a trapezoidal profile: the fastest speed from which it can still stop at the target.
procedure ProfileStep(var p: Profile; target, topSpeed, acceleration, cycle: Double);
var
  distance, step, wanted: Double;
begin
  distance := target - p.position;
  step := acceleration * cycle; // largest change of speed in one cycle
  wanted := step * (Sqrt(0.25 + 2.0 * Abs(distance) / (step * cycle)) - 0.5);

  if wanted > topSpeed then
    wanted := topSpeed;
  if distance < 0 then
    wanted := -wanted;
  if wanted > p.speed + step then
    wanted := p.speed + step;
  if wanted < p.speed - step then
    wanted := p.speed - step;
  p.speed := wanted;
  p.position := p.position + wanted * cycle;
end;

function StateName(state: LongWord): PWideChar;
begin
  case state of
    Ord(WAIT_FOR_BUS): StateName := 'waiting for EtherCAT';
    Ord(ENABLE): StateName := 'enabling the servo';
    Ord(HOMING): StateName := 'looking for the home switch';
    Ord(HOMING_STOP): StateName := 'home switch found';
    Ord(MOVING): StateName := 'moving';
  else
    StateName := 'drive fault';
  end;
end;

// "shuttle: moving": begins a line of the console in plc.line.
procedure LineBegin(out text: tgm_text; beginning: PWideChar);
begin
  tgm_text_init(text, plc.line, LINE_SIZE);
  tgm_text_utf16(text, beginning);
end;

procedure LineSay(pData: PPLC_DATA; var text: tgm_text);
begin
  tgm_text_utf16(text, #10);
  Say(pData, plc.line);
end;

// What this machine needs beyond the checks that the manual advises (tgm_check_start).
function MachineIsThere(pData: PPLC_DATA): Boolean;
var
  system: PSYSTEM;
  text: tgm_text;
begin
  system := SystemOf(pData);
  MachineIsThere := (system^.Main.Number_Servos >= 1) and (system^.Main.Number_Dios >= 1) and
    (system^.Header.Mem_Size_Data >= SizeOf(ShuttleStatus));
  if not MachineIsThere then
  begin
    LineBegin(text, 'shuttle: not started: one servo and one I/O unit are needed');
    LineSay(pData, text);
  end;
end;

function Program_Ini(pData: PPLC_DATA): LongInt; cdecl;
var
  text: tgm_text;
begin
  if tgm_check_start(pData) = 0 then
    Exit(0);
  if not MachineIsThere(pData) then
    Exit(0);

  FillChar(plc, SizeOf(plc), 0);
  FindMemories(pData);
  plc.cycle := plc.system^.Main.Servo_SetCycleTime * Double(1e-6);
  plc.rev := plc.servo^.Resolution;
  plc.state := WAIT_FOR_BUS;
  plc.told := $FFFFFFFF;
  plc.status^.version := SHUTTLE_VERSION;

  LineBegin(text, 'shuttle ');
  tgm_text_unsigned(text, SHUTTLE_VERSION div 100, 0, ' ');
  tgm_text_utf16(text, '.');
  tgm_text_unsigned(text, SHUTTLE_VERSION mod 100, 2, '0');
  tgm_text_utf16(text, ' started, cycle ');
  tgm_text_unsigned(text, plc.system^.Main.Servo_SetCycleTime, 0, ' ');
  tgm_text_utf16(text, ' us');
  LineSay(pData, text);
  Program_Ini := 1;
end;

// Lowest priority: tell the console what the machine is doing.
function Program_01(pData: PPLC_DATA): LongInt; cdecl;
var
  state: LongWord;
  text: tgm_text;
begin
  state := plc.status^.state;
  if state <> plc.told then
  begin
    plc.told := state;
    LineBegin(text, 'shuttle: ');
    tgm_text_utf16(text, StateName(state));
    LineSay(pData, text);
  end;
  Program_01 := 1;
end;

function Program_02(pData: PPLC_DATA): LongInt; cdecl;
begin
  Program_02 := 1;
end;

function Program_03(pData: PPLC_DATA): LongInt; cdecl;
begin
  Program_03 := 1;
end;

procedure ReadInputs(out now: Inputs);
begin
  now.busReady := (plc.servo^.EtherCATState = ETHERCAT_STATE_OP) and (plc.dio^.EtherCATState = ETHERCAT_STATE_OP);
  now.enabled := plc.servo^.Status = SERVO_READY_ENABLE;
  now.fault := plc.servo^.Status = SERVO_FAULT;
  now.homeSwitch := plc.servo^.DigitalIn and HOME_SWITCH <> 0;
  now.position := plc.servo^.Position;
  now.bits := InputBits;
end;

// While the servo is not enabled, the set-point follows the carriage, so that enabling never jumps.
procedure Follow(const now: Inputs);
begin
  plc.profile.position := now.position;
  plc.profile.speed := 0;
end;

procedure HomeStep(const now: Inputs);
var
  top, acceleration: Double;
begin
  top := HOMING_SPEED * plc.rev;
  acceleration := shuttle.ACCELERATION * plc.rev;

  if (plc.state = HOMING) and now.homeSwitch then
  begin
    plc.home := now.position;
    plc.target := plc.home + STROKE_TO * plc.rev;
    plc.state := HOMING_STOP;
  end;
  if plc.state = HOMING then // a target that is always one revolution ahead
  begin
    ProfileStep(plc.profile, plc.profile.position - plc.rev, top, acceleration, plc.cycle);
    Exit;
  end;
  ProfileStep(plc.profile, plc.home + STROKE_FROM * plc.rev, top, acceleration, plc.cycle);
  if plc.profile.position - plc.home >= Double(0.999) * STROKE_FROM * plc.rev then
    plc.state := MOVING;
end;

procedure MoveStep;
var
  nearEnd, farEnd, left: Double;
begin
  nearEnd := plc.home + STROKE_FROM * plc.rev;
  farEnd := plc.home + STROKE_TO * plc.rev;
  left := plc.target - plc.profile.position;

  if (left < 1.0) and (left > -1.0) then // within one increment: turn round
  begin
    Inc(plc.strokes);
    if plc.target = farEnd then
      plc.target := nearEnd
    else
      plc.target := farEnd;
  end;
  ProfileStep(plc.profile, plc.target, TRAVEL_SPEED * plc.rev, ACCELERATION * plc.rev, plc.cycle);
end;

procedure Compute(const now: Inputs);
begin
  if not now.busReady then
    plc.state := WAIT_FOR_BUS
  else if now.fault and (plc.state <> FAULT) then
  begin
    plc.state := FAULT;
    plc.pause := FAULT_PAUSE;
    Inc(plc.faults);
  end;

  case plc.state of
    WAIT_FOR_BUS:
    begin
      Follow(now);
      if now.busReady then
        plc.state := ENABLE;
    end;
    ENABLE:
    begin
      Follow(now);
      if now.enabled then
        plc.state := HOMING;
    end;
    HOMING, HOMING_STOP: HomeStep(now);
    MOVING: MoveStep;
    FAULT:
    begin
      Follow(now);
      plc.pause := plc.pause - plc.cycle;
      if (plc.pause <= Double(-0.1)) and not now.fault then
        plc.state := ENABLE;
    end;
  end;
end;

procedure WriteOutputs(const now: Inputs);
begin
  if plc.state in [ENABLE, HOMING, HOMING_STOP, MOVING] then
    plc.servo^.Mode := SERVO_MODE_POSITION
  else
    plc.servo^.Mode := SERVO_MODE_OFF;
  if (plc.state = FAULT) and (plc.pause <= 0) then
    plc.servo^.Control := SERVO_RESET_FAULT_BIT0
  else
    plc.servo^.Control := 0;
  plc.servo^.WritePosition := plc.profile.position;
  OutputBits(now.bits and 1);

  plc.status^.state := Ord(plc.state);
  plc.status^.strokes := plc.strokes;
  plc.status^.faults := plc.faults;
  if plc.state in [MOVING, HOMING_STOP] then
    plc.status^.position := (now.position - plc.home) / plc.rev
  else
    plc.status^.position := 0;
  plc.status^.speed := plc.profile.speed / plc.rev;
end;

// Once in every Cycle_Time, never interrupted: the machine itself.
function Program_04(pData: PPLC_DATA): LongInt; cdecl;
var
  now: Inputs;
begin
  ReadInputs(now);
  Compute(now);
  WriteOutputs(now);
  Program_04 := 1;
end;

function Program_05(pData: PPLC_DATA): LongInt; cdecl;
begin
  Program_05 := 1;
end;

end.
