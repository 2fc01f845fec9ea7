// Samples of one servo as they come, with what a plot needs and no signal has: the band of the estimate, the
// share of austenite, set-points as strain, the error in the unit of the mode, the limits that act.

import { parseJson } from '../protocol/codec';
import { type Row, SampleRing } from './ring';

/** What a set-point means, by the mode of operation of CiA 402. */
export function controlled(mode: number): string | null {
  switch (mode) {
    case 1:
    case 8:
      return 'position_m';
    case 4:
    case 10:
      return 'force_N';
    case -1:
      return 'current_A';
    case -2:
      return 'power_W';
    case -3:
      return 'wire_temperature_K';
    default:
      return null;
  }
}

export interface Geometry {
  zero_strain: number;
  length_m: number;
}

const gap_s = 1; // a line over a longer silence would be a claim

export class Feed {
  readonly ring: SampleRing;
  mode = 0;
  geometry: Geometry = { zero_strain: NaN, length_m: NaN };
  received = 0;
  private held: Row = {};
  private limits: string[] = []; // columns of the bits of limit_reasons
  private rate = { since_ms: 0, count: 0, value: 0 };

  constructor(capacity?: number) {
    this.ring = new SampleRing(capacity);
  }

  /** Names of the bits of limit_reasons. */
  setLimitNames(names: string[]): void {
    this.limits = names.map((name) => `limit:${name}`);
  }

  /** Messages a second, over about a second. */
  get rate_hz(): number {
    return this.rate.value;
  }

  message(data: Uint8Array, time_s: number): void {
    const row = parseJson(data) as Row | null;
    if (!row) {
      return;
    }
    ++this.received;
    this.count();
    const last = this.ring.last_s;
    if (last !== null && time_s - last > gap_s) {
      this.interrupt();
    }
    // A signal that a message lacks keeps its value: not all come at the full rate.
    Object.assign(this.held, row);
    this.derive(this.held);
    this.ring.push(time_s, this.held);
  }

  /** Rows of the service `history`; they must come before the first message. */
  history(answer: Record<string, unknown>): void {
    const { t_ns: times, ...signals } = answer as Record<string, (number | null)[]>;
    if (!Array.isArray(times)) {
      return;
    }
    for (let i = 0; i < times.length; ++i) {
      const row: Row = {};
      for (const name in signals) {
        row[name] = signals[name]?.[i] ?? null;
      }
      this.derive(row);
      this.ring.push(Number(times[i]) / 1e9, row);
    }
  }

  /** Leaves a gap before the next sample. */
  interrupt(): void {
    const last = this.ring.last_s;
    if (last !== null) {
      this.ring.push(last + 1e-6, {});
    }
    this.held = {};
  }

  private derive(row: Row): void {
    const number = (key: string): number => row[key] ?? NaN;
    // Without a current there is no resistance to measure, and no set-point in force: 0 is not a reading.
    if (row['resistance_ohm'] === 0) {
      row['resistance_ohm'] = null;
    }
    if (row['drive_current_A'] === 0) {
      row['setpoint'] = row['reference'] = null;
    }
    const strain = number('strain');
    const sd = number('strain_sd');
    row['strain_low'] = strain - 2 * sd;
    row['strain_high'] = strain + 2 * sd;
    row['austenite'] = 1 - number('martensite') - number('r_phase');
    row['resistance_difference_ohm'] = number('resistance_ohm') - number('resistance_model_ohm');
    row['contraction'] = this.geometry.zero_strain - strain;
    const variable = controlled(this.mode);
    const setpoint = number('setpoint');
    if (variable !== null) {
      row[`error:${variable}`] = setpoint - number(variable);
    }
    const moves = variable === 'position_m';
    row['setpoint_strain'] = moves ? this.strainOf(setpoint) : NaN;
    row['reference_strain'] = moves ? this.strainOf(number('reference')) : NaN;
    const reasons = number('limit_reasons');
    for (let bit = 0; bit < this.limits.length; ++bit) {
      const acts = Number.isNaN(reasons) ? NaN : (reasons >>> bit) & 1;
      const key = this.limits[bit]!;
      if (acts !== 0 || this.ring.column(key)) {
        row[key] = acts;
      }
    }
  }

  private strainOf(position_m: number): number {
    return this.geometry.zero_strain - position_m / this.geometry.length_m;
  }

  private count(): void {
    const now = performance.now();
    ++this.rate.count;
    const elapsed = now - this.rate.since_ms;
    if (elapsed < 1000) {
      return;
    }
    this.rate.value = elapsed < 5000 ? (1000 * this.rate.count) / elapsed : 0;
    this.rate.since_ms = now;
    this.rate.count = 0;
  }
}
