// What all panels of a report have in common: the drawing of their series, lines across and texts.

import { Chart, label, type Span, type View } from '../plot/chart';
import type { PlotGroup, Zoom } from '../plot/group';
import { element, type LegendItem, type Style } from '../plot/legend';
import { theme, translucent } from '../plot/theme';
import { colourOf } from './colours';
import type { Panel, Series } from './data';
import { ThinPath } from './thin_path';

/** Rows of a series that are drawn: all, or those that a window shows. */
export type Rows = [from: number, to: number];

function styleOf(series: Series): Style {
  // A band's colour is pale by itself.
  if (series.kind === 'area' || series.kind === 'band') {
    return 'stack';
  }
  if (series.kind === 'points') {
    return 'points';
  }
  return series.dashed ? 'dashed' : 'line';
}

/** One entry for all series of a name. */
function legendOf(panel: Panel): LegendItem[] {
  const items = new Map<string, LegendItem>();
  for (const series of panel.series) {
    const { name } = series;
    if (!name || series.kind === 'spans' || items.has(name)) {
      continue;
    }
    items.set(name, {
      key: name,
      label: name,
      role: 'ink',
      colour: () => colourOf(series.colour),
      style: styleOf(series),
    });
  }
  return [...items.values()];
}

export abstract class PanelPlot extends Chart {
  constructor(
    parent: HTMLElement,
    id: string,
    readonly panel: Panel,
    readonly group: PlotGroup,
    zoom: Zoom,
  ) {
    super(parent, {
      id,
      title: panel.title,
      xLabel: panel.x.label,
      height: panel.height - (panel.half ? 60 : 50),
      group,
      zoom,
      yLog: panel.y.log ?? false,
      right: panel.series.some((series) => series.right),
      axes: {
        ...(panel.x.ticks ? { x: named(panel.x.ticks) } : {}),
        ...(panel.y.ticks ? { y: named(panel.y.ticks) } : {}),
      },
      legend: legendOf(panel),
    });
    // The page has the title; here stand the units of the axes.
    this.legend.root.querySelector('.plot-title')!.textContent = panel.y.label ?? '';
    if (panel.right.label) {
      this.legend.root.append(element('div', 'plot-right-label', panel.right.label));
    }
  }

  protected visible(): Series[] {
    return this.panel.series.filter((series) => !series.name || !this.legend.hidden.has(series.name));
  }

  protected abstract rowsOf(series: Series): Rows;

  protected paint(view: View): void {
    const behind = (series: Series): boolean => series.kind === 'band' || series.kind === 'area';
    const all = this.visible();
    for (const series of all.filter(behind)) {
      this.paintArea(view, series);
    }
    this.paintRules(view);
    for (const series of all) {
      if (!behind(series)) {
        this.paintSeries(view, series);
      }
    }
    for (const [x, y, text] of this.panel.notes) {
      label(view, text, view.toX(x), view.toY(y), theme().ink);
    }
  }

  protected paintSeries(view: View, series: Series): void {
    if (series.kind === 'points') {
      this.paintPoints(view, series);
    } else {
      this.paintLine(view, series, this.rowsOf(series));
    }
  }

  protected paintLine(view: View, series: Series, [from, to]: Rows): void {
    const { ctx } = view;
    const toY = series.right ? view.toRight : view.toY;
    ctx.strokeStyle = colourOf(series.colour);
    ctx.lineWidth = 1.3 * Math.min(3, series.width ?? 1) * view.ratio;
    ctx.lineJoin = 'bevel';
    ctx.setLineDash(series.dashed ? [5 * view.ratio, 4 * view.ratio] : []);
    ctx.beginPath();
    const path = new ThinPath(ctx);
    let last = NaN;
    for (let row = from; row < to; ++row) {
      const px = view.toX(series.x[row]!);
      const py = toY(series.y[row]!);
      if (Number.isNaN(px) || Number.isNaN(py)) {
        last = NaN;
        continue;
      }
      if (Number.isNaN(last)) {
        path.start(px, py);
        // A row between two gaps would leave nothing.
        if (row + 1 >= to || Number.isNaN(series.y[row + 1]!)) {
          path.to(px + ctx.lineWidth, py);
        }
      } else {
        if (series.kind === 'steps') {
          path.to(px, last);
        }
        path.to(px, py);
      }
      last = py;
    }
    path.end();
    ctx.stroke();
    ctx.setLineDash([]);
  }

  private paintPoints(view: View, series: Series): void {
    const { ctx } = view;
    const toY = series.right ? view.toRight : view.toY;
    ctx.fillStyle = colourOf(series.colour);
    const [from, to] = this.rowsOf(series);
    const size = 2.6 * view.ratio;
    for (let row = from; row < to; ++row) {
      const px = view.toX(series.x[row]!);
      const py = toY(series.y[row]!);
      if (Number.isNaN(px) || Number.isNaN(py)) {
        continue;
      }
      ctx.beginPath();
      ctx.arc(px, py, size, 0, 2 * Math.PI);
      ctx.fill();
    }
  }

  private paintArea(view: View, series: Series): void {
    const { ctx } = view;
    const toY = series.right ? view.toRight : view.toY;
    const low = series.low!;
    const there = (row: number): boolean =>
      !Number.isNaN(series.x[row]!) && !Number.isNaN(series.y[row]!) && !Number.isNaN(low[row]!);
    ctx.fillStyle = series.kind === 'band' ? colourOf(series.colour) : translucent(colourOf(series.colour), 0.85);
    const [from, to] = this.rowsOf(series);
    for (let row = from; row < to; ) {
      if (!there(row)) {
        ++row;
        continue;
      }
      const first = row;
      ctx.beginPath();
      for (; row < to && there(row); ++row) {
        ctx.lineTo(view.toX(series.x[row]!), toY(series.y[row]!));
      }
      for (let back = row - 1; back >= first; --back) {
        ctx.lineTo(view.toX(series.x[back]!), toY(low[back]!));
      }
      ctx.closePath();
      ctx.fill();
    }
  }

  private paintRules(view: View): void {
    const { ctx } = view;
    for (const rule of this.panel.rules) {
      ctx.strokeStyle = colourOf(rule.colour);
      ctx.lineWidth = view.ratio;
      ctx.setLineDash([4 * view.ratio, 3 * view.ratio]);
      ctx.beginPath();
      const at = Math.round((rule.vertical ? view.toX : view.toY)(rule.at)) + 0.5;
      if (rule.vertical) {
        ctx.moveTo(at, view.top);
        ctx.lineTo(at, view.top + view.height);
      } else {
        ctx.moveTo(view.left, at);
        ctx.lineTo(view.left + view.width, at);
      }
      ctx.stroke();
      ctx.setLineDash([]);
      if (rule.name && !rule.vertical) {
        label(view, rule.name, view.left + 6 * view.ratio, at - 2 * view.ratio, colourOf(rule.colour));
      }
    }
  }
}

function named(ticks: [number, string][]): object {
  const text = new Map(ticks);
  return {
    splits: () => ticks.map(([at]) => at),
    values: (_u: unknown, splits: number[]) => splits.map((at) => text.get(at) ?? ''),
  };
}

/** A span with the ends that an axis states, where it does. */
export function bounded([low, high]: Span, min?: number, max?: number): Span {
  const from = min ?? low;
  const to = max ?? high;
  return to > from ? [from, to] : [from, from + 1];
}
