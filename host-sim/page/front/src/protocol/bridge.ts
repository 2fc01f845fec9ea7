// What the bridge says: PROTOCOL.md as types.

export interface NodeInfo {
  node: number;
  name: string;
  online: boolean;
  duplicate: boolean;
}

export interface Bridge {
  bus: string;
  read_only: boolean;
  nodes: NodeInfo[];
  control: number | null;
  clients: { client: number; address: string; queued: number; dropped: number; read_only: boolean }[];
  activity: { service: string; node: number; client: number; progress: number } | null;
  recordings: { node: number; client: number; stage: 'filling' | 'waiting' | 'recording' }[];
  trouble: string;
}

export type Drive =
  | 'not_ready'
  | 'switch_on_disabled'
  | 'ready'
  | 'switched_on'
  | 'operation_enabled'
  | 'quick_stop'
  | 'fault_reaction'
  | 'fault';

export interface State {
  node: number;
  online: boolean;
  nmt: string;
  drive: Drive;
  statusword: number;
  mode: number;
  mode_name: string;
  target: number | null;
  position_um: number | null;
  target_reached: boolean;
  active: string[];
  latched: string[];
  warnings?: string[];
  warning_causes?: Record<string, number>; ///< how often the cause of each warning has come
  blocking: string[];
  first_cause: string | null;
  limits: string[];
  freeze_frame: Record<string, number | null> | null;
  transaction: { state: 'none' | 'open' | 'trying'; seconds_left: number | null };
  unsaved: boolean;
  rate_hz: number;
  gaps: number;
}

export type Value = number | boolean | string;

/** The value in SI is factor * value + offset. */
export interface ParameterUnit {
  unit: string;
  factor: number;
  offset: number;
}

export interface ParameterInfo {
  name: string;
  type: 'number' | 'integer' | 'boolean' | 'choice';
  unit: string;
  min: number | null;
  max: number | null;
  default: Value | null;
  choices?: string[];
  units?: ParameterUnit[]; ///< of a number that is no integer: all units of its kind, SI's own first
  change: 'live' | 'not enabled' | 'after reset';
  level: string;
  meaning: string;
}

export interface SignalInfo {
  name: string;
  unit: string;
  meaning: string;
  bits?: string[];
}

export interface FaultInfo {
  name: string;
  code: string;
  class: string;
  text: string;
}

export interface ModeInfo {
  mode: number;
  name: string;
  unit: string;
}

export interface Description {
  version: string;
  parameters: ParameterInfo[];
  signals: SignalInfo[];
  faults: FaultInfo[];
  modes: ModeInfo[];
}

export interface Recording {
  id?: number; ///< under which the bridge keeps it
  period_s: number;
  signals: string[];
  rows: (number | null)[][];
}

export interface StepFigures {
  rise_s: number | null;
  settling_s: number | null;
  overshoot_percent: number | null;
  error_percent: number | null;
  peak_K: number | null;
}

export interface Difference {
  name: string;
  file: Value;
  node: Value;
}

/** A guided run that makes a wire file, or the last one. */
export interface Commission {
  node: number | null;
  client: number | null; ///< who leads it
  stage: 'none' | 'waiting' | 'checking' | 'asking' | 'heating' | 'fitting' | 'done' | 'failed';
  line: string; ///< what goes on now
  said: string[];
  left_s: number | null; ///< of the question
  share: number; ///< of the fit
  error: string;
  files: ('wire' | 'run' | 'readings')[];
  result: Commissioned | null;
}

export interface Commissioned {
  text: string; ///< as `host-sim commission` prints it
  notes: string[];
  differences: Difference[]; ///< between the wire that was found and that of the settings
  numbers: {
    cold_ohm: number;
    cold_factor: number;
    distance: number;
    expected_error_of_stroke: Record<'before' | 'after', { strain: number; stroke: number }>;
    anchors: unknown[];
  };
}

/** What the service `choose` answers. */
export interface Choice {
  wires: ChosenWire[]; ///< those that do it, the best first
  others: { wire: string; why: string }[];
}

export interface ChosenWire {
  wire: string;
  parallel: number; ///< how many side by side
  length_m: number;
  strain: number;
  stress_Pa: number;
  cold_stress_Pa: number;
  current_A: number;
  voltage_V: number;
  power_W: number;
  hold_current_A: number;
  hottest_K: number;
  overheats_s: number | null; ///< null: the current may stay on
  back_still_s: number | null; ///< null: it does not come back in that air
  back_fan_s: number | null;
  spring_N: number | null;
  spring_N_m: number | null;
  cycles: string;
  note: string;
  course: Course;
}

/** Heated, then cooling in still air; with the fan on times of its own. */
export interface Course {
  time_s: number[];
  contraction_m: number[];
  temperature_K: number[];
  fan_time_s: number[];
  fan_contraction_m: number[];
}
