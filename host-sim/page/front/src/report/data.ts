// The data of a report, as host-sim/report/panel_json.cpp writes it into the page.

export interface Axis {
  label?: string;
  min?: number;
  max?: number;
  log?: boolean;
  ticks?: [number, string][];
}

export type Kind = 'line' | 'steps' | 'points' | 'band' | 'area' | 'spans';

interface SeriesOf<Column> {
  kind: Kind;
  name?: string;
  colour: string; ///< a role of the page, or #rrggbb
  x: Column;
  y: Column;
  low?: Column;
  at?: Column;
  right?: boolean;
  width?: number;
  dashed?: boolean;
}

interface PanelOf<Column> {
  title: string;
  half?: boolean;
  height: number;
  x: Axis;
  y: Axis;
  right: Axis;
  link?: string;
  follows?: string;
  equal?: boolean;
  series: SeriesOf<Column>[];
  rules: { at: number; name?: string; colour: string; vertical?: boolean }[];
  notes: [number, number, string][];
}

export type Series = SeriesOf<Float64Array>;
export type Panel = PanelOf<Float64Array>;

interface Page {
  columns: (number | null)[][];
  panels: (PanelOf<number> | null)[];
}

/** The panels of one data element; null for one that is a picture only. */
export function parsed(text: string): (Panel | null)[] {
  const page = JSON.parse(text) as Page;
  const columns = page.columns.map((values) => Float64Array.from(values, (value) => value ?? NaN));
  const column = (place: number): Float64Array => columns[place]!;
  return page.panels.map(
    (panel) =>
      panel && {
        ...panel,
        series: panel.series.map(({ x, y, low, at, ...rest }) => ({
          ...rest,
          x: column(x),
          y: column(y),
          ...(low === undefined ? {} : { low: column(low) }),
          ...(at === undefined ? {} : { at: column(at) }),
        })),
      },
  );
}

/** Rows from `from` up to but not including `to`, between two gaps of x. */
export interface Piece {
  from: number;
  to: number;
}

export function pieces(x: Float64Array): Piece[] {
  const all: Piece[] = [];
  for (let row = 0; row < x.length; ) {
    while (row < x.length && Number.isNaN(x[row]!)) {
      ++row;
    }
    const from = row;
    while (row < x.length && !Number.isNaN(x[row]!)) {
      ++row;
    }
    if (row > from) {
      all.push({ from, to: row });
    }
  }
  return all;
}

export function ascends(x: Float64Array, { from, to }: Piece): boolean {
  for (let row = from + 1; row < to; ++row) {
    if (x[row]! < x[row - 1]!) {
      return false;
    }
  }
  return true;
}

/** First row of an ascending piece whose x is not below the value. */
export function rowAt(x: Float64Array, { from, to }: Piece, value: number): number {
  let low = from;
  let high = to;
  while (low < high) {
    const middle = (low + high) >>> 1;
    if (x[middle]! < value) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

/** What a series shows at a place of its x axis, in a piece that ascends; NaN beyond the ends. */
export function valueAt(series: Series, piece: Piece, x: number): number {
  const next = rowAt(series.x, piece, x);
  if (next === piece.to || (next === piece.from && series.x[next]! > x)) {
    return NaN;
  }
  const before = Math.max(piece.from, next - 1);
  const nearest = series.x[next]! - x < x - series.x[before]! ? next : before;
  // A step holds what it had.
  const row = series.kind === 'steps' && series.x[next]! > x ? before : nearest;
  return series.kind === 'area' ? series.y[row]! - series.low![row]! : series.y[row]!;
}
