// Several series over one x axis that is shared by a group: lines, steps, points, a band, stacked areas, on a
// left and a right axis. Draws no more points than the screen has, whatever the number of samples.
//
//     const group = new PlotGroup({ x: 'seconds', extent: () => [0, 20] });
//     const samples = new ArraySamples(time_s, { strain, low, high, reference });
//     new TimePlot(parent, group, {
//       id: 'strain', title: 'Strain', unit: '%', series: [
//         { key: 'band', label: '±2σ', role: 'band', style: 'band', low: 'low', high: 'high', factor: 100 },
//         { key: 'strain', label: 'estimate', role: 'estimate', factor: 100 },
//         { key: 'reference', label: 'reference', role: 'reference', style: 'dashed', factor: 100 }],
//     }, samples);
//     group.invalidate();

import { logRange, niceRange } from './axes';
import { Chart, label, labelWidth, type Scales, type Span, type View } from './chart';
import { formatClock, formatNumber } from '../numbers/format';
import { reduce, Reduced, type Samples, valueAt, type Want } from '../numbers/samples';
import type { PlotGroup } from './group';
import type { Style } from './legend';
import { drawArea, drawLine, drawPoints, drawSteps, type Pen, type Project } from './pens';
import { Raster } from './raster';
import { type Role, theme, translucent } from './theme';

export interface SeriesSpec {
  key: string; ///< of the series, and of its column unless `column` says another one
  column?: string;
  label: string;
  role: Role;
  style?: Style; ///< line
  axis?: 'left' | 'right';
  unit?: string; ///< behind the value, where it is not the plot's
  factor?: number; ///< shown is factor * value + offset
  offset?: number;
  smallest?: number; ///< shortest range of its axis, as it is shown
  low?: string; ///< columns of a band
  high?: string;
  width?: number; ///< of the line, in pixels of CSS
  hidden?: boolean; ///< until it is clicked
}

export interface Line {
  y: number;
  label: string;
  role: Role;
  axis?: 'left' | 'right';
}

export interface TimePlotSpec {
  id: string;
  title: string;
  unit?: string; ///< of the left axis
  series: SeriesSpec[];
  lines?: Line[]; ///< across the plot, such as a limit; they do not widen the axis
  height?: number;
  range?: Span; ///< of the left axis, instead of one that fits
  yLog?: boolean;
  xLabel?: string;
  /** Columns that are above 0 while something is so: strips along the upper edge, with their names. */
  flags?: () => Flag[];
  onToggle?: (key: string, hidden: boolean) => void; ///< a series was switched off or on
}

export interface Flag {
  column: string;
  label: string;
}

export class TimePlot extends Chart {
  private readonly reduced = new Reduced();
  private readonly raster = new Raster();
  private readonly wants: Want[] = [];
  private readonly areas = { low: new Float64Array(0), high: new Float64Array(0) };
  private shownAt = 0;
  private flags: Flag[] = [];
  /** Lines across the plot may change at any time. */
  lines: Line[];

  constructor(
    parent: HTMLElement,
    readonly group: PlotGroup,
    readonly spec: TimePlotSpec,
    public samples: Samples,
  ) {
    super(parent, {
      id: spec.id,
      title: spec.title,
      unit: spec.unit,
      height: spec.height,
      xLabel: spec.xLabel,
      group,
      zoom: group,
      yLog: spec.yLog ?? false,
      right: spec.series.some((series) => series.axis === 'right'),
      legend: spec.series.map((series) => ({ ...series, style: series.style ?? 'line' })),
      onToggle: spec.onToggle,
    });
    this.lines = spec.lines ?? [];
  }

  override cursorMoved(x: number | null): void {
    const { options } = this.group;
    const [from, to] = this.scales.x;
    this.placeCursor(x, (at) =>
      options.x === 'clock'
        ? formatClock(at, (to - from) / 500)
        : `${formatNumber(at, 5)} ${options.x === 'seconds' ? 's' : (options.unit ?? '')}`,
    );
    this.writeValues();
  }

  protected measure(pixels: number): Scales {
    const x = this.group.range();
    this.gather();
    reduce(this.samples, x[0], x[1], pixels, this.wants, this.reduced);
    this.convert();
    const left = this.spec.range ?? this.fit('left', x);
    return { x, y: left, ...(this.hasRightAxis() ? { right: this.fit('right', x) } : {}) };
  }

  protected paint(view: View): void {
    let column = 0;
    let stacked = false;
    for (const series of this.visible()) {
      const y = this.reduced.y[column]!;
      const toY = series.axis === 'right' ? view.toRight : view.toY;
      if (series.style === 'band') {
        this.paintArea(view, series, y, this.reduced.y[column + 1]!, toY, 0.2);
        ++column;
      } else if (series.style === 'stack') {
        this.paintStack(view, series, y, toY, !stacked);
        stacked = true;
      } else {
        this.paintLine(view, series, y, toY);
      }
      ++column;
    }
    this.raster.finish(view);
    this.paintFlags(view, column);
    this.paintLines(view);
    const now = performance.now();
    if (this.group.cursor !== null || now - this.shownAt > 120) {
      this.shownAt = now;
      this.cursorMoved(this.group.cursor);
    }
  }

  private visible(): SeriesSpec[] {
    return this.spec.series.filter((series) => !this.legend.hidden.has(series.key));
  }

  /** One column of the reduced rows for each visible series, two for a band. */
  private gather(): void {
    this.wants.length = 0;
    for (const series of this.visible()) {
      if (series.style === 'band') {
        this.wants.push({ key: series.low!, keep: 'low' }, { key: series.high!, keep: 'high' });
      } else {
        const keep = series.style === 'stack' ? 'ends' : 'both';
        this.wants.push({ key: series.column ?? series.key, keep });
      }
    }
    this.flags = this.spec.flags?.() ?? [];
    for (const flag of this.flags) {
      this.wants.push({ key: flag.column, keep: 'high' });
    }
  }

  /** Rows that were there for the last picture are converted already. */
  private convert(): void {
    let column = 0;
    for (const series of this.visible()) {
      for (let part = series.style === 'band' ? 2 : 1; part > 0; --part, ++column) {
        const { factor = 1, offset = 0 } = series;
        if (factor === 1 && offset === 0) {
          continue;
        }
        const y = this.reduced.y[column]!;
        for (let row = this.reduced.kept; row < this.reduced.count; ++row) {
          y[row] = factor * y[row]! + offset;
        }
      }
    }
  }

  /** Lines must fit; a band may add as much again on either side. */
  private fit(side: 'left' | 'right', x: Span): Span {
    let low = Infinity;
    let high = -Infinity;
    let bandLow = Infinity;
    let bandHigh = -Infinity;
    let stack = false;
    let smallest = 0;
    let column = 0;
    for (const series of this.visible()) {
      const band = series.style === 'band';
      if ((series.axis ?? 'left') === side) {
        smallest = Math.max(smallest, series.smallest ?? 0);
      }
      for (let part = band ? 2 : 1; part > 0; --part, ++column) {
        if ((series.axis ?? 'left') !== side) {
          continue;
        }
        stack ||= series.style === 'stack';
        const [least, most] = this.extremes(this.reduced.y[column]!, x);
        if (band) {
          bandLow = Math.min(bandLow, least);
          bandHigh = Math.max(bandHigh, most);
        } else {
          low = Math.min(low, least);
          high = Math.max(high, most);
        }
      }
    }
    if (stack) {
      return [0, 1];
    }
    if (low > high) {
      [low, high] = [bandLow, bandHigh];
    }
    const room = Math.max(high - low, smallest);
    low = Math.min(low, Math.max(bandLow, low - room));
    high = Math.max(high, Math.min(bandHigh, high + room));
    return side === 'left' && this.spec.yLog ? logRange(low, high) : niceRange(low, high, smallest);
  }

  private extremes(y: Float64Array, [from, to]: Span): Span {
    const rows = this.reduced;
    let low = Infinity;
    let high = -Infinity;
    for (let row = 0; row < rows.count; ++row) {
      const x = rows.x[row]!;
      const value = y[row]!;
      if (x < from || x > to) {
        continue;
      }
      if (value < low && Number.isFinite(value)) {
        low = value;
      }
      if (value > high && Number.isFinite(value)) {
        high = value;
      }
    }
    return [low, high];
  }

  private paintLine(view: View, series: SeriesSpec, y: Float64Array, toY: Project): void {
    const dashed = series.style === 'dashed';
    const pen: Pen = {
      colour: theme()[series.role],
      width: (series.width ?? 1.6) * view.ratio,
      dash: dashed ? [5 * view.ratio, 4 * view.ratio] : [],
    };
    if (series.style !== 'points' && this.dense(view)) {
      this.raster.line(view, this.reduced, y, view.toX, toY, pen, series.style === 'steps');
      return;
    }
    this.raster.finish(view);
    const draw = series.style === 'steps' ? drawSteps : series.style === 'points' ? drawPoints : drawLine;
    draw(view.ctx, this.reduced, y, view.toX, toY, pen);
  }

  private paintStack(view: View, series: SeriesSpec, y: Float64Array, toY: Project, first: boolean): void {
    const { areas } = this;
    const { count } = this.reduced;
    if (areas.low.length < count) {
      areas.low = new Float64Array(this.reduced.x.length);
      areas.high = new Float64Array(this.reduced.x.length);
      first = true;
    }
    for (let row = 0; row < count; ++row) {
      areas.low[row] = first ? 0 : areas.high[row]!;
      areas.high[row] = areas.low[row]! + y[row]!;
    }
    this.paintArea(view, series, areas.low, areas.high, toY, 0.75);
  }

  private paintArea(
    view: View,
    series: SeriesSpec,
    low: Float64Array,
    high: Float64Array,
    toY: Project,
    opacity: number,
  ): void {
    const colour = theme()[series.role];
    if (this.dense(view)) {
      this.raster.area(view, this.reduced, low, high, view.toX, toY, colour, opacity);
    } else {
      drawArea(view.ctx, this.reduced, low, high, view.toX, toY, translucent(colour, opacity));
    }
  }

  /** Whether there are more rows than columns of pixels. */
  private dense(view: View): boolean {
    return this.reduced.starts.length > 0 || this.reduced.count > view.width;
  }

  private paintFlags(view: View, column: number): void {
    const { ctx, ratio } = view;
    const height = 15 * ratio;
    let top = view.top;
    const rows = this.reduced;
    for (const flag of this.flags) {
      const set = rows.y[column++]!;
      let start = NaN;
      let first = NaN;
      ctx.fillStyle = translucent(theme().limit, 0.16);
      for (let row = 0; row < rows.count; ++row) {
        const on = set[row]! > 0;
        const x = view.toX(rows.x[row]!);
        if (on && Number.isNaN(start)) {
          start = x;
        }
        if (Number.isNaN(first) && on) {
          first = Math.max(view.left, x);
        }
        if (!Number.isNaN(start) && (!on || row === rows.count - 1)) {
          ctx.fillRect(start, top, Math.max(ratio, x - start), height - ratio);
          start = NaN;
        }
      }
      if (Number.isNaN(first) || first > view.left + view.width) {
        continue;
      }
      const text = Math.min(first, view.left + view.width - labelWidth(view, flag.label) - 8 * ratio) + 5 * ratio;
      label(view, flag.label, Math.max(view.left, text), top + height - 2 * ratio, theme().limit);
      top += height;
    }
  }

  private paintLines(view: View): void {
    for (const line of this.lines) {
      const toY = line.axis === 'right' ? view.toRight : view.toY;
      const y = Math.round(toY(line.y)) + 0.5;
      if (!(y > view.top && y < view.top + view.height)) {
        continue;
      }
      view.ctx.strokeStyle = theme()[line.role];
      view.ctx.lineWidth = view.ratio;
      view.ctx.setLineDash([2 * view.ratio, 3 * view.ratio]);
      view.ctx.beginPath();
      view.ctx.moveTo(view.left, y);
      view.ctx.lineTo(view.left + view.width, y);
      view.ctx.stroke();
      label(view, line.label, view.left + 6 * view.ratio, y - 2 * view.ratio, theme()[line.role]);
    }
  }

  /** Under the cursor; the newest of a group that follows; else none. */
  private writeValues(): void {
    const { samples, group } = this;
    const live = group.options.follow_s !== undefined;
    const x = group.cursor ?? (live && samples.end > samples.first ? samples.x(samples.end - 1) : null);
    const reach = 0.05 * (this.scales.x[1] - this.scales.x[0]);
    for (const series of this.spec.series) {
      if (x === null || this.legend.hidden.has(series.key)) {
        this.legend.show(series.key, NaN);
        continue;
      }
      const { factor = 1, offset = 0 } = series;
      const at = (key: string): number => valueAt(samples, key, x, reach);
      const value =
        series.style === 'band'
          ? (factor * (at(series.high!) - at(series.low!))) / 2
          : factor * at(series.column ?? series.key) + offset;
      this.legend.show(series.key, this.rounded(value, series.axis));
    }
  }

  /** To what could be seen on the axis ten thousand pixels high: the noise of a zero is 0, not 8.32e-08. */
  private rounded(value: number, axis: 'left' | 'right' = 'left'): number {
    const [low, high] = (axis === 'right' ? this.scales.right : undefined) ?? this.scales.y;
    if (this.spec.yLog || !(high > low)) {
      return value;
    }
    const step = 10 ** Math.floor(Math.log10((high - low) / 1e4));
    return Math.round(value / step) * step;
  }
}
