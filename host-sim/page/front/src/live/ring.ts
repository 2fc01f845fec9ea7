// The last samples of a servo, in memory that is taken once.

import { RangedColumn } from '../numbers/columns';
import type { Samples } from '../numbers/samples';

const most_columns = 96; // what a bridge sends has no bound of its own

export type Row = Record<string, number | null | undefined>;

export class SampleRing implements Samples {
  first = 0;
  end = 0;
  private readonly times: Float64Array;
  private readonly columns = new Map<string, RangedColumn>();

  /** 600 * 1024 rows: ten minutes at 1 kHz. A multiple of 1024. */
  constructor(readonly capacity = 600 * 1024) {
    this.times = new Float64Array(capacity);
  }

  x(row: number): number {
    return this.times[row % this.capacity]!;
  }

  column(key: string): RangedColumn | undefined {
    return this.columns.get(key);
  }

  get last_s(): number | null {
    return this.end > 0 ? this.x(this.end - 1) : null;
  }

  extent(): [number, number] | null {
    return this.end > this.first ? [this.x(this.first), this.x(this.end - 1)] : null;
  }

  /** A row that is not later than the last one is left out. */
  push(time_s: number, row: Row): void {
    const last = this.last_s;
    if (!Number.isFinite(time_s) || (last !== null && time_s <= last)) {
      return;
    }
    for (const key in row) {
      if (!this.columns.has(key)) {
        this.add(key);
      }
    }
    const at = this.end;
    this.times[at % this.capacity] = time_s;
    for (const [key, column] of this.columns) {
      const value = row[key];
      column.set(at, typeof value === 'number' ? value : NaN);
    }
    this.end = at + 1;
    if (this.end - this.first > this.capacity) {
      this.first = this.end - this.capacity;
    }
  }

  private add(key: string): void {
    if (this.columns.size >= most_columns) {
      return;
    }
    this.columns.set(key, new RangedColumn(new Float32Array(this.capacity), this.capacity, this.end));
  }
}
