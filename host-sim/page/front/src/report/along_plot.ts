// A panel along an x axis: over time, over a frequency, or states and faults as bars. Panels of one group
// show the same stretch, and the cursor stands at the same place in all of them.

import { logRange, niceRange } from '../plot/axes';
import { label, type Scales, type Span, type View } from '../plot/chart';
import type { PlotGroup } from '../plot/group';
import { formatNumber } from '../plot';
import { theme } from '../plot/theme';
import { colourOf } from './colours';
import { ascends, type Panel, type Piece, pieces, rowAt, type Series, valueAt } from './data';
import { bounded, PanelPlot, type Rows } from './panel_plot';

const rowHeight = 26; // of a bar with its name

export class AlongPlot extends PanelPlot {
  private readonly piecesOf = new Map<Series, Piece[]>();
  private readonly spans: Series[];

  constructor(parent: HTMLElement, id: string, panel: Panel, group: PlotGroup) {
    const spans = panel.series.filter((series) => series.kind === 'spans');
    const shown = spans.length === 0 ? panel : { ...panel, height: 80 + rowHeight * spans.length, y: { ticks: [] } };
    super(parent, id, shown, group, group);
    this.spans = spans;
    for (const series of panel.series) {
      if (series.kind !== 'spans') {
        this.piecesOf.set(
          series,
          pieces(series.x).filter((piece) => ascends(series.x, piece)),
        );
      }
    }
  }

  override cursorMoved(x: number | null): void {
    const unit = this.group.options.x === 'seconds' ? ' s' : '';
    this.placeCursor(x, (at) => formatNumber(at, 6) + unit);
    const values = new Map<string, number[]>();
    for (const series of this.visible()) {
      if (!series.name || series.kind === 'spans') {
        continue;
      }
      const known = values.get(series.name) ?? [];
      values.set(series.name, known);
      if (x === null) {
        continue;
      }
      for (const piece of this.piecesOf.get(series) ?? []) {
        const value = valueAt(series, piece, x);
        if (!Number.isNaN(value)) {
          known.push(value);
        }
      }
    }
    for (const { key } of this.options.legend) {
      this.legend.show(key, written(values.get(key) ?? []));
    }
  }

  protected measure(): Scales {
    const x = this.group.range();
    // rowsOf() is to find the rows of the new window, not of the last one.
    this.scales = { ...this.scales, x };
    if (this.spans?.length) {
      return { x, y: [-this.spans.length, 0] };
    }
    const { y, right } = this.panel;
    return {
      x,
      y: bounded(this.fit(false, x), y.min, y.max),
      ...(this.hasRightAxis() ? { right: bounded(this.fit(true, x), right.min, right.max) } : {}),
    };
  }

  protected rowsOf(series: Series): Rows {
    const all = this.piecesOf?.get(series) ?? [];
    const only = all.length === 1 && all[0]!.to - all[0]!.from === series.x.length ? all[0] : undefined;
    if (!only) {
      return [0, series.x.length];
    }
    const [from, to] = this.scales.x;
    return [Math.max(0, rowAt(series.x, only, from) - 1), Math.min(only.to, rowAt(series.x, only, to) + 2)];
  }

  protected override paintSeries(view: View, series: Series): void {
    if (series.kind !== 'spans') {
      super.paintSeries(view, series);
      return;
    }
    const { ctx, ratio } = view;
    const top = view.toY(-this.spans.indexOf(series));
    const bottom = view.toY(-this.spans.indexOf(series) - 1);
    label(view, series.name ?? '', view.left + 4 * ratio, top + 14 * ratio, theme().ink);
    ctx.fillStyle = colourOf(series.colour);
    for (let row = 0; row < series.x.length; ++row) {
      const from = view.toX(series.x[row]!);
      ctx.fillRect(
        from,
        top + 15 * ratio,
        Math.max(1.5 * ratio, view.toX(series.y[row]!) - from),
        bottom - top - 18 * ratio,
      );
    }
  }

  /** Of what the window shows; a band widens it no more than the lines' own range. */
  private fit(right: boolean, [from, to]: Span): Span {
    let low = Infinity;
    let high = -Infinity;
    for (const series of this.visible()) {
      if (Boolean(series.right) !== right || series.kind === 'band') {
        continue;
      }
      const [first, end] = this.rowsOf(series);
      for (let row = first; row < end; ++row) {
        const x = series.x[row]!;
        if (!(x >= from && x <= to)) {
          continue;
        }
        for (const value of series.low ? [series.low[row]!, series.y[row]!] : [series.y[row]!]) {
          if (value < low) {
            low = value;
          }
          if (value > high) {
            high = value;
          }
        }
      }
    }
    for (const rule of right ? [] : this.panel.rules) {
      if (rule.vertical || !rule.name) {
        continue;
      }
      low = Math.min(low, rule.at);
      high = Math.max(high, rule.at);
    }
    return !right && this.panel.y.log ? logRange(low, high) : niceRange(low, high);
  }
}

/** One value, or the range of several curves. */
function written(values: number[]): string {
  if (values.length === 0) {
    return '';
  }
  const low = Math.min(...values);
  const high = Math.max(...values);
  return low === high ? formatNumber(low) : `${formatNumber(low)} … ${formatNumber(high)}`;
}
