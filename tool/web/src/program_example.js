/**
 * The example program on the first page: an oven with a start button, a ramp and a trip, controlled by a CONT_C.
 */

import { toBase64 } from "tool/engine.js";
import { choose } from "tool/plant.js";
import { translate } from "tool/program.js";
import { remake } from "tool/remake.js";
import { store } from "tool/store.js";

const FILE = "oven.scl";
const PLANT = "HEATER";
/** The events of the run: time in seconds, input, value. @type {[number, string, boolean | number][]} */
const EVENTS = [
  [10, "start", true],
  [12, "start", false],
  [420, "setpoint", 120],
];
const STOP = 700;

const SOURCE = `FUNCTION_BLOCK "Oven"
{ S7_Optimized_Access := 'TRUE' }
VERSION : 1.0
// Heats to the setpoint by a ramp, holds it, and trips above the limit
   VAR_INPUT
      start : Bool;
      stop : Bool;
      setpoint : Real := 80.0;   // unit: degC, min 0, max 200
      temperature : Real := 20.0;   // unit: degC
      rate { S7_SetPoint := 'True'} : Real := 20.0;   // K/min
      tripAt { S7_SetPoint := 'True'} : Real := 150.0;   // unit: degC
   END_VAR

   VAR_OUTPUT
      power : Real;   // unit: %
      ramp : Real;   // unit: degC
      on : Bool;
      inBand : Bool;
      tripped : Bool;
   END_VAR

   VAR
      controller {InstructionName := 'CONT_C'; LibVersion := '1.1'} : CONT_C;
      hot {InstructionName := 'TON_TIME'; LibVersion := '1.0'} : TON_TIME;
      band {InstructionName := 'TON_TIME'; LibVersion := '1.0'} : TON_TIME;
   END_VAR

   VAR_TEMP
      increment : Real;
   END_VAR

   VAR CONSTANT
      CYCLE : Time := T#1s;
   END_VAR

BEGIN
   // Above the limit for 3 s: a fault until the next start below it
   #hot(IN := #temperature > #tripAt, PT := T#3s);
   IF #hot.Q THEN
      #tripped := TRUE;
   ELSIF #start AND #temperature < #tripAt THEN
      #tripped := FALSE;
   END_IF;
   #on := (#start OR #on) AND NOT #stop AND NOT #tripped;

   // The ramp begins where the oven is
   #increment := #rate * DINT_TO_REAL(TIME_TO_DINT(#CYCLE)) / 60000.0;
   IF #on THEN
      #ramp := LIMIT(MN := #ramp - #increment, IN := #setpoint, MX := #ramp + #increment);
   ELSE
      #ramp := #temperature;
   END_IF;

   #controller(MAN_ON := NOT #on,
               MAN := 0.0,
               SP_INT := #ramp,
               PV_IN := #temperature,
               GAIN := 0.7,
               TI := T#130s,
               CYCLE := #CYCLE,
               LMN => #power);
   #band(IN := #on AND ABS(#temperature - #setpoint) < 2.0, PT := T#10s, Q => #inBand);
END_FUNCTION_BLOCK
`;

/** Opens the program with its plant and runs it with the events. */
export async function openExample() {
  const program = { files: [{ file: FILE, content: toBase64(new TextEncoder().encode(SOURCE)) }] };
  const loop = await translate(/** @type {import("./messages").Program} */ (program));
  if (!loop) return;
  await choose(PLANT);
  const step = loop.step ?? 1;
  const events = EVENTS.map(([time, name, value]) => {
    const call = Math.round(time / step);
    return { call, time, variable: `${loop.member}.${name}`, value };
  });
  await remake(loop, { setup: store.setup(), events, calls: Math.round(STOP / step) });
}
