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
