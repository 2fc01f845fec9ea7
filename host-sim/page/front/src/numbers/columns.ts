// Columns of numbers that know the extremes of their blocks, so that the range of 600 000 samples costs no
// more than that of 100; and Samples of given arrays.

import type { Column, Range, Samples } from './samples';

const bits = [5, 10] as const; // blocks of 32 and of 1024 rows

export type Numbers = Float32Array | Float64Array;

/**
 * A ring of `capacity` numbers (a multiple of 1024). Rows are counted without end; row r is at r modulo the
 * capacity, and asking for a row that has been overwritten gives another one's number. Rows before `start`
 * are NaN without being written: memory that nobody touches is not taken from the machine.
 */
export class RangedColumn implements Column {
  private readonly lows: Numbers[];
  private readonly highs: Numbers[];

  constructor(
    private readonly values: Numbers,
    private readonly capacity = values.length,
    private readonly start = 0,
  ) {
    const make = (size: number): Numbers =>
      values instanceof Float32Array ? new Float32Array(size) : new Float64Array(size);
    this.lows = bits.map((b) => make(Math.ceil(capacity / (1 << b))));
    this.highs = bits.map((b) => make(Math.ceil(capacity / (1 << b))));
  }

  at(row: number): number {
    return row < this.start ? NaN : this.values[row % this.capacity]!;
  }

  /** All rows from `start` on must be set, in order. */
  set(row: number, value: number): void {
    const place = row % this.capacity;
    this.values[place] = value;
    // Only whole blocks are ever asked for.
    if ((place & 31) === 31) {
      this.fold(place);
    }
  }

  /** The extremes of the blocks that end at a place. */
  private fold(place: number): void {
    const block = place >> bits[0];
    const range = { low: NaN, high: NaN };
    for (let at = block << bits[0]; at <= place; ++at) {
      include(range, this.values[at]!, this.values[at]!);
    }
    this.lows[0]![block] = range.low;
    this.highs[0]![block] = range.high;
    if ((place & 1023) !== 1023) {
      return;
    }
    const large = place >> bits[1];
    range.low = range.high = NaN;
    for (let at = large << 5; at <= block; ++at) {
      include(range, this.lows[0]![at]!, this.highs[0]![at]!);
    }
    this.lows[1]![large] = range.low;
    this.highs[1]![large] = range.high;
  }

  range(from: number, to: number, result: Range): void {
    result.low = NaN;
    result.high = NaN;
    let row = Math.max(from, this.start);
    while (row < to) {
      const place = row % this.capacity;
      const level = this.levelAt(place, to - row);
      if (level < 0) {
        include(result, this.values[place]!, this.values[place]!);
        ++row;
      } else {
        const b = bits[level]!;
        include(result, this.lows[level]![place >> b]!, this.highs[level]![place >> b]!);
        row += 1 << b;
      }
    }
  }

  /** The largest block that begins here and ends before `rows` rows. */
  private levelAt(place: number, rows: number): number {
    for (let level = bits.length - 1; level >= 0; --level) {
      const size = 1 << bits[level]!;
      if ((place & (size - 1)) === 0 && rows >= size && place + size <= this.capacity) {
        return level;
      }
    }
    return -1;
  }
}

function include(result: Range, low: number, high: number): void {
  if (!(low >= result.low)) {
    result.low = Number.isNaN(low) ? result.low : low;
  }
  if (!(high <= result.high)) {
    result.high = Number.isNaN(high) ? result.high : high;
  }
}

/** Samples of arrays that do not change; null and NaN are gaps. x must ascend. */
export class ArraySamples implements Samples {
  readonly first = 0;
  readonly end: number;
  private readonly columns = new Map<string, RangedColumn>();

  constructor(
    private readonly xs: ArrayLike<number>,
    ys: Record<string, ArrayLike<number | null>>,
  ) {
    this.end = xs.length;
    for (const [key, values] of Object.entries(ys)) {
      const column = new RangedColumn(new Float64Array(values.length), Math.max(1, values.length));
      for (let row = 0; row < values.length; ++row) {
        column.set(row, values[row] ?? NaN);
      }
      this.columns.set(key, column);
    }
  }

  x(row: number): number {
    return this.xs[row]!;
  }

  column(key: string): RangedColumn | undefined {
    return this.columns.get(key);
  }
}
