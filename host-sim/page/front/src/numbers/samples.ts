// Where plots have their numbers from, and how many samples become the few points that a screen can show
// without the loss of a peak.
//
// A Samples is rows in order of x, numbered from `first` up to but not including `end`. It may be an array
// (a report), or a ring that new rows are pushed into (the live page).

/** One quantity of all rows. NaN is a gap. */
export interface Column {
  at(row: number): number;
  /** Smallest and largest number of the rows from `from` up to but not including `to`; NaN where none. */
  range(from: number, to: number, result: Range): void;
}

export interface Range {
  low: number;
  high: number;
}

export interface Samples {
  readonly first: number;
  readonly end: number;
  x(row: number): number;
  column(key: string): Column | undefined;
}

/** What is kept of the samples that share a pixel: both extremes, one of them, or the outer samples. */
export type Keep = 'both' | 'low' | 'high' | 'ends';

export interface Want {
  key: string;
  keep: Keep;
}

/** Reduced rows; buffers that are used again. Only the first `count` numbers of each are valid. */
export class Reduced {
  count = 0;
  x = new Float64Array(0);
  y: Float64Array[] = [];
  /**
   * So many rows were there after the last reduce() already, and what has been made of their y since is kept:
   * who scales rows must scale only those from here on.
   */
  kept = 0;
  /** Where the pixels begin, as samples and as rows here; of the last reduce() that put samples together. */
  readonly starts: number[] = [];
  readonly places: number[] = [];
  private of: { samples: Samples; width: number; wants: string } | null = null;

  reserve(rows: number, columns: number): void {
    if (this.x.length < rows) {
      this.x = new Float64Array(rows);
      this.y = [];
      this.of = null;
    }
    while (this.y.length < columns) {
      this.y.push(new Float64Array(this.x.length));
    }
  }

  /** No row is kept. */
  clear(): void {
    this.count = this.kept = this.starts.length = this.places.length = 0;
    this.of = null;
  }

  /**
   * Keeps the rows of the whole pixels between two samples, if they are of the same samples and wants; says
   * which sample is the first that is missing.
   */
  keep(samples: Samples, width: number, wants: readonly Want[], begin: number, end: number): number {
    const { of, starts, places } = this;
    const text = wants.map((want) => `${want.keep} ${want.key}`).join('\n');
    let first = 0;
    let last = starts.length - 1; // may get more samples, so it is made anew
    while (last > 0 && starts[last]! > end) {
      --last;
    }
    while (first < last && starts[first + 1]! <= begin) {
      ++first;
    }
    const same = of !== null && of.samples === samples && of.width === width && of.wants === text;
    if (!same || !(first < last) || starts[first]! > begin) {
      this.clear();
      this.of = { samples, width, wants: text };
      return begin;
    }
    const [from, to] = [places[first]!, places[last]!];
    const next = starts[last]!;
    this.x.copyWithin(0, from, to);
    for (const y of this.y) {
      y.copyWithin(0, from, to);
    }
    starts.splice(last);
    places.splice(last);
    starts.splice(0, first);
    places.splice(0, first);
    for (let pixel = 0; pixel < places.length; ++pixel) {
      places[pixel]! -= from;
    }
    this.count = this.kept = to - from;
    return next;
  }
}

/** First row whose x is not below the value, between two rows. */
export function lowerBound(samples: Samples, value: number, from = samples.first, to = samples.end): number {
  let low = from;
  let high = to;
  while (low < high) {
    const middle = (low + high) >>> 1;
    if (samples.x(middle) < value) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

/** The row nearest to x, or -1 of no rows. */
export function nearestRow(samples: Samples, x: number): number {
  if (samples.end === samples.first) {
    return -1;
  }
  const row = lowerBound(samples, x);
  if (row === samples.end) {
    return row - 1;
  }
  if (row === samples.first) {
    return row;
  }
  return x - samples.x(row - 1) <= samples.x(row) - x ? row - 1 : row;
}

/** The value of the row nearest to x; NaN where there is none, or none within `reach` of x. */
export function valueAt(samples: Samples, key: string, x: number, reach = Infinity): number {
  const row = nearestRow(samples, x);
  const column = samples.column(key);
  if (row < 0 || !column || Math.abs(samples.x(row) - x) > reach) {
    return NaN;
  }
  return column.at(row);
}

/**
 * The rows between two x, and one beyond each end so that lines reach the edge. Samples that share one of
 * `pixels` columns become at most four rows: the extremes, and gaps at either end. Columns are multiples of
 * their width, not parts of the window, so that a picture that scrolls does not flicker; the leftmost of them
 * is a whole one. A window that moves on keeps the rows that `out` has already.
 * Cost: about 40 comparisons for each new pixel and want, whatever the number of samples.
 */
export function reduce(
  samples: Samples,
  from: number,
  to: number,
  pixels: number,
  wants: readonly Want[],
  out: Reduced,
): void {
  const begin = Math.max(samples.first, lowerBound(samples, from) - 1);
  const end = Math.min(samples.end, lowerBound(samples, to) + 1);
  const columns = wants.map((want) => samples.column(want.key));
  const rows = Math.max(0, end - begin);
  if (rows <= 2 * pixels) {
    out.clear();
    out.reserve(Math.max(rows, 2 * pixels), wants.length);
    out.count = rows;
    for (let row = begin; row < end; ++row) {
      out.x[row - begin] = samples.x(row);
    }
    columns.forEach((column, c) => {
      const y = out.y[c]!;
      for (let row = begin; row < end; ++row) {
        y[row - begin] = column ? column.at(row) : NaN;
      }
    });
    return;
  }
  out.reserve(4 * (Math.ceil(pixels) + 4), wants.length);
  // Six digits: the ends of a window that scrolls are rounded, and with them its length.
  const width = Number(((to - from) / pixels).toPrecision(6));
  const whole = lowerBound(samples, Math.floor(samples.x(begin) / width) * width, samples.first, begin);
  for (let row = out.keep(samples, width, wants, whole, end); row < end; ) {
    const edge = (Math.floor(samples.x(row) / width) + 1) * width;
    const next = Math.max(row + 1, gallop(samples, edge, row + 1, end));
    out.starts.push(row);
    out.places.push(out.count);
    put(samples, columns, wants, row, next, out);
    row = next;
  }
}

/** lowerBound() for an answer that is near. */
function gallop(samples: Samples, value: number, from: number, end: number): number {
  let step = 1;
  let low = from;
  while (low + step < end && samples.x(low + step) < value) {
    low += step;
    step *= 2;
  }
  return lowerBound(samples, value, low, Math.min(end, low + step + 1));
}

const range: Range = { low: NaN, high: NaN };

function put(
  samples: Samples,
  columns: readonly (Column | undefined)[],
  wants: readonly Want[],
  from: number,
  to: number,
  out: Reduced,
): void {
  const last = to - 1;
  const opens = columns.some((column) => column && Number.isNaN(column.at(from)));
  const closes = last > from && columns.some((column) => column && Number.isNaN(column.at(last)));
  const row = out.count;
  let rows = 0;
  const at = (x: number): void => {
    out.x[row + rows++] = x;
  };
  if (opens) {
    at(samples.x(from));
  }
  at(samples.x(from));
  at(samples.x(last));
  if (closes) {
    at(samples.x(last));
  }
  for (let c = 0; c < columns.length; ++c) {
    const column = columns[c];
    const y = out.y[c]!;
    const [early, late] = column ? kept(column, wants[c]!.keep, from, to) : [NaN, NaN];
    let i = row;
    if (opens) {
      y[i++] = column && Number.isNaN(column.at(from)) ? NaN : early;
    }
    y[i++] = early;
    y[i++] = late;
    if (closes) {
      y[i] = column && Number.isNaN(column.at(last)) ? NaN : late;
    }
  }
  out.count += rows;
}

const pair: [number, number] = [NaN, NaN];

function kept(column: Column, keep: Keep, from: number, to: number): [number, number] {
  const early = column.at(from);
  const late = column.at(to - 1);
  if (keep === 'ends') {
    pair[0] = early;
    pair[1] = late;
    return pair;
  }
  column.range(from, to, range);
  const { low, high } = range;
  if (keep === 'both') {
    const falls = early > late;
    pair[0] = falls ? high : low;
    pair[1] = falls ? low : high;
  } else {
    pair[0] = pair[1] = keep === 'low' ? low : high;
  }
  return pair;
}
