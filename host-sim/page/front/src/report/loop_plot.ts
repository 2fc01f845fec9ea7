// One quantity over another: loops, Nyquist curves. It zooms by itself in both directions. Where its rows have
// a place in a group (time, frequency), it shows the group's stretch in full colour, and a dot where the cursor
// of that group is; and its own cursor moves that one.

import { formatNumber } from '../plot';
import { niceRange } from '../plot/axes';
import { Box, include } from '../plot/box';
import { dot, type Scales, type Span, type View } from '../plot/chart';
import type { PlotGroup } from '../plot/group';
import { colourOf } from './colours';
import type { Panel, Series } from './data';
import { bounded, PanelPlot, type Rows } from './panel_plot';

interface Place {
  series: Series;
  row: number;
}

export class LoopPlot extends PanelPlot {
  private readonly box: Box;
  private pointed: Place | null = null;
  private shown: Rows | null = null;

  constructor(parent: HTMLElement, id: string, panel: Panel, group: PlotGroup) {
    const box = new Box(() => this.changed(), panel.x.log);
    super(parent, id, panel, group, box);
    this.box = box;
  }

  protected measure(): Scales {
    return this.box.measure(() => this.fit(), this.panel.equal ? this : undefined);
  }

  protected rowsOf(series: Series): Rows {
    return this.shown ?? [0, series.x.length];
  }

  protected override paint(view: View): void {
    const window = this.group.zoomed ? this.group.range() : null;
    if (window) {
      view.ctx.globalAlpha = 0.18;
      super.paint(view);
      view.ctx.globalAlpha = 1;
    }
    this.paintWithin(view, window);
    this.paintMarks(view);
  }

  override pointAt(left: number | null, top: number): void {
    const place = left === null ? null : this.nearest(left, top);
    if (place?.row === this.pointed?.row && place?.series === this.pointed?.series) {
      return;
    }
    this.pointed = place;
    const at = place?.series.at?.[place.row];
    if (this.panel.follows) {
      this.group.setCursor(at === undefined || Number.isNaN(at) ? null : at);
    }
    this.writeValues();
    this.changed();
  }

  /** To a neighbour of the row that is pointed at. */
  override step(share: number): void {
    const series = this.pointed?.series ?? this.visible()[0];
    if (!series) {
      return;
    }
    const rows = Math.max(1, Math.round((Math.abs(share) * series.x.length) / 4));
    const from = this.pointed?.row ?? 0;
    const row = Math.min(series.x.length - 1, Math.max(0, from + Math.sign(share) * rows));
    if (Number.isNaN(series.x[row]! + series.y[row]!)) {
      return;
    }
    this.pointed = { series, row };
    if (this.panel.follows && series.at) {
      this.group.setCursor(series.at[row]!);
    }
    this.writeValues();
    this.changed();
  }

  /** The row whose dot is nearest in pixels, and not farther than 30 of them. */
  private nearest(left: number, top: number): Place | null {
    const { x, y } = this.scales;
    const sx = this.width / (x[1] - x[0]);
    const sy = this.height / (y[1] - y[0]);
    let best: Place | null = null;
    let least = 30 * 30;
    for (const series of this.visible()) {
      for (let row = 0; row < series.x.length; ++row) {
        const dx = (series.x[row]! - x[0]) * sx - left;
        const dy = (y[1] - series.y[row]!) * sy - top;
        const distance = dx * dx + dy * dy;
        if (distance < least) {
          least = distance;
          best = { series, row };
        }
      }
    }
    return best;
  }

  private writeValues(): void {
    const place = this.pointed;
    for (const { key } of this.options.legend) {
      const mine = place !== null && place.series.name === key;
      this.legend.show(
        key,
        mine ? `(${formatNumber(place.series.x[place.row]!)}; ${formatNumber(place.series.y[place.row]!)})` : '',
      );
    }
  }

  private fit(): Scales {
    const x: Span = [Infinity, -Infinity];
    const y: Span = [Infinity, -Infinity];
    for (const series of this.visible()) {
      for (let row = 0; row < series.x.length; ++row) {
        if (Number.isNaN(series.x[row]! + series.y[row]!)) {
          continue;
        }
        include(x, series.x[row]!);
        include(y, series.y[row]!);
        if (series.low) {
          include(y, series.low[row]!);
        }
      }
    }
    const { x: across, y: up } = this.panel;
    return { x: bounded(niceRange(...x), across.min, across.max), y: bounded(niceRange(...y), up.min, up.max) };
  }

  /** All, or of the series that have a place in the group the rows of its stretch. */
  private paintWithin(view: View, window: Span | null): void {
    if (!window) {
      super.paint(view);
      return;
    }
    for (const series of this.visible()) {
      const { at } = series;
      if (!at) {
        this.paintSeries(view, series);
        continue;
      }
      const inside = (row: number): boolean => at[row]! >= window[0] && at[row]! <= window[1];
      for (let row = 0; row < at.length; ) {
        while (row < at.length && !inside(row)) {
          ++row;
        }
        const from = row;
        while (row < at.length && inside(row)) {
          ++row;
        }
        this.shown = [from, row];
        if (row > from) {
          this.paintSeries(view, series);
        }
      }
      this.shown = null;
    }
  }

  private paintMarks(view: View): void {
    const { cursor } = this.group;
    if (cursor !== null && this.panel.follows) {
      for (const series of this.visible()) {
        const row = series.at ? nearestTo(series.at, cursor) : -1;
        if (row >= 0) {
          this.markRow(view, series, row);
        }
      }
    }
    if (this.pointed) {
      this.markRow(view, this.pointed.series, this.pointed.row);
    }
  }

  private markRow(view: View, series: Series, row: number): void {
    const px = view.toX(series.x[row]!);
    const py = view.toY(series.y[row]!);
    if (!Number.isNaN(px + py)) {
      dot(view, px, py, 4.5, colourOf(series.colour));
    }
  }
}

function nearestTo(values: Float64Array, wanted: number): number {
  let best = -1;
  let least = Infinity;
  for (let row = 0; row < values.length; ++row) {
    const distance = Math.abs(values[row]! - wanted);
    if (distance < least) {
      least = distance;
      best = row;
    }
  }
  return best;
}
