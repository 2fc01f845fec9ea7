// One quantity over another: hysteresis loops, live with a trail that fades, or a Nyquist curve with axes of
// equal scale. Lines join rows in their order, so it needs no ascending x.

import { niceRange } from './axes';
import { Box, include } from './box';
import { Chart, dot, type Scales, type Span, type View } from './chart';
import { type Column, lowerBound, nearestRow, type Samples } from '../numbers/samples';
import type { PlotGroup } from './group';
import { type Role, theme } from './theme';

export interface LoopSpec {
  key: string;
  label: string;
  x: string; ///< columns
  y: string;
  role: Role;
  style?: 'line' | 'dashed' | 'points';
  samples?: Samples; ///< where they are not the plot's
  hidden?: boolean;
}

export interface Circle {
  x: number;
  y: number;
  radius: number;
  role: Role;
}

export interface XYPlotSpec {
  id: string;
  title: string; ///< what y is
  unit?: string; ///< of y
  xLabel: string; ///< what x is, with its unit
  loops: LoopSpec[];
  xFactor?: number; ///< shown is factor * value + offset
  xOffset?: number;
  yFactor?: number;
  yOffset?: number;
  equal?: boolean; ///< a unit is as long in both directions: circles are round
  circles?: Circle[];
  range?: { x: Span; y: Span }; ///< to begin with, instead of all
  trail_s?: number; ///< shows the last so many seconds of the group's stretch, fading
  height?: number;
  smallest?: Span; ///< shortest range of x and of y
}

const most = 4000; // points of a loop
const fades = 24;
const old_ms = 500;

interface Shown {
  samples: Samples;
  from: number;
  to: number;
  x: Column;
  y: Column;
}

/** A trail as it was painted a moment ago. */
interface Trail {
  canvas: HTMLCanvasElement;
  of: string; // scales, size and colour
  at_ms: number;
  to: number; // its last row
}

export class XYPlot extends Chart {
  private readonly box: Box;
  private readonly trails = new Map<string, Trail>();

  /** In a group it shows the rows of the group's stretch and the place of the group's cursor. */
  constructor(
    parent: HTMLElement,
    readonly group: PlotGroup | null,
    readonly spec: XYPlotSpec,
    public samples: Samples,
  ) {
    const box = new Box(() => this.changed(), false, spec.range);
    super(parent, {
      id: spec.id,
      title: spec.title,
      xLabel: spec.xLabel,
      unit: spec.unit,
      height: spec.height,
      group,
      zoom: box,
      legend: spec.loops.length > 1 ? spec.loops.map((loop) => ({ ...loop, style: loop.style ?? 'line' })) : [],
    });
    this.box = box;
  }

  protected measure(): Scales {
    return this.box.measure(() => this.fit(), this.spec.equal ? this : undefined);
  }

  protected paint(view: View): void {
    for (const circle of this.spec.circles ?? []) {
      view.ctx.strokeStyle = theme()[circle.role];
      view.ctx.lineWidth = 1.2 * view.ratio;
      view.ctx.setLineDash([4 * view.ratio, 3 * view.ratio]);
      view.ctx.beginPath();
      const width = Math.abs(view.toX(circle.x + circle.radius) - view.toX(circle.x));
      const height = Math.abs(view.toY(circle.y + circle.radius) - view.toY(circle.y));
      view.ctx.ellipse(view.toX(circle.x), view.toY(circle.y), width, height, 0, 0, 2 * Math.PI);
      view.ctx.stroke();
    }
    for (const loop of this.spec.loops) {
      if (!this.legend.hidden.has(loop.key)) {
        this.paintLoop(view, loop);
      }
    }
  }

  private shown(loop: LoopSpec): Shown | null {
    const samples = loop.samples ?? this.samples;
    const x = samples.column(loop.x);
    const y = samples.column(loop.y);
    if (!x || !y) {
      return null;
    }
    if (!this.group) {
      return { samples, from: samples.first, to: samples.end, x, y };
    }
    const [begin, end] = this.group.range();
    const from = this.spec.trail_s === undefined ? begin : Math.max(begin, end - this.spec.trail_s);
    return { samples, from: lowerBound(samples, from), to: lowerBound(samples, end), x, y };
  }

  private xOf(value: number): number {
    return (this.spec.xFactor ?? 1) * value + (this.spec.xOffset ?? 0);
  }
  private yOf(value: number): number {
    return (this.spec.yFactor ?? 1) * value + (this.spec.yOffset ?? 0);
  }

  private fit(): Scales {
    const x: Span = [Infinity, -Infinity];
    const y: Span = [Infinity, -Infinity];
    const range = { low: NaN, high: NaN };
    for (const loop of this.spec.loops) {
      const rows = this.legend.hidden.has(loop.key) ? null : this.shown(loop);
      if (!rows) {
        continue;
      }
      rows.x.range(rows.from, rows.to, range);
      include(x, this.xOf(range.low), this.xOf(range.high));
      rows.y.range(rows.from, rows.to, range);
      include(y, this.yOf(range.low), this.yOf(range.high));
    }
    for (const circle of this.spec.circles ?? []) {
      include(x, circle.x - circle.radius, circle.x + circle.radius);
      include(y, circle.y - circle.radius, circle.y + circle.radius);
    }
    const [width = 0, height = 0] = this.spec.smallest ?? [];
    return { x: niceRange(x[0], x[1], width), y: niceRange(y[0], y[1], height) };
  }

  private paintLoop(view: View, loop: LoopSpec): void {
    const rows = this.shown(loop);
    if (!rows || rows.to <= rows.from) {
      return;
    }
    // Every k-th row by its number in the ring: a trail that grows does not flicker.
    const stride = Math.max(1, Math.ceil((rows.to - rows.from) / most));
    const first = Math.ceil(rows.from / stride) * stride;
    if (this.spec.trail_s === undefined) {
      this.pen(view, loop);
      this.paintRows(view, loop, rows.x, rows.y, first, rows.to - 1, stride);
    } else {
      this.paintTrail(view, loop, rows, first, stride);
    }
    const cursor = this.group?.cursor ?? null;
    const marked =
      cursor !== null ? nearestRow(rows.samples, cursor) : this.spec.trail_s !== undefined ? rows.to - 1 : -1;
    if (marked >= 0) {
      dot(view, view.toX(this.xOf(rows.x.at(marked))), view.toY(this.yOf(rows.y.at(marked))), 4, theme().ink);
    }
  }

  private pen({ ctx, ratio }: View, loop: LoopSpec): void {
    ctx.strokeStyle = ctx.fillStyle = theme()[loop.role];
    ctx.lineWidth = 1.6 * ratio;
    ctx.lineJoin = 'bevel';
    ctx.setLineDash(loop.style === 'dashed' ? [5 * ratio, 4 * ratio] : []);
  }

  /** Stroking twenty seconds takes longer than all else of a frame: they are kept for a while, and only what is
   * new is added to them. */
  private paintTrail(view: View, loop: LoopSpec, rows: Shown, first: number, stride: number): void {
    const of = [this.scales.x, this.scales.y, view.left, view.top, view.width, view.height, theme()[loop.role]].join();
    const now = performance.now();
    let trail = this.trails.get(loop.key);
    if (!trail || trail.of !== of || now - trail.at_ms > old_ms || trail.to > rows.to - 1 || trail.to < first) {
      trail = { canvas: trail?.canvas ?? document.createElement('canvas'), of, at_ms: now, to: rows.to - 1 };
      this.trails.set(loop.key, trail);
      this.fade(trail.canvas, view, loop, rows, first, stride);
    }
    const left = Math.round(view.left);
    const top = Math.round(view.top);
    view.ctx.drawImage(trail.canvas, left, top);
    this.pen(view, loop);
    if (trail.to < rows.to - 1) {
      this.paintRows(view, loop, rows.x, rows.y, trail.to, rows.to - 1, stride);
    }
  }

  private fade(
    canvas: HTMLCanvasElement,
    view: View,
    loop: LoopSpec,
    rows: Shown,
    first: number,
    stride: number,
  ): void {
    const left = Math.round(view.left);
    const top = Math.round(view.top);
    // Also clears it.
    canvas.width = Math.max(1, Math.round(view.width));
    canvas.height = Math.max(1, Math.round(view.height));
    const ctx = canvas.getContext('2d');
    if (!ctx) {
      return;
    }
    ctx.translate(-left, -top);
    const there = { ...view, ctx };
    this.pen(there, loop);
    const count = Math.max(1, Math.ceil((rows.to - first) / stride));
    for (let part = 0; part < fades; ++part) {
      const from = first + Math.floor((count * part) / fades) * stride;
      const to = first + Math.floor((count * (part + 1)) / fades) * stride;
      ctx.globalAlpha = 0.15 + 0.85 * ((part + 1) / fades) ** 2;
      this.paintRows(there, loop, rows.x, rows.y, from, Math.min(to, rows.to - 1), stride);
    }
  }

  private paintRows(view: View, loop: LoopSpec, x: Column, y: Column, from: number, to: number, stride: number): void {
    const { ctx } = view;
    let down = false;
    let lastX = 0;
    let lastY = 0;
    const near = 0.7 * view.ratio; // what is nearer to the last point cannot be seen
    ctx.beginPath();
    for (let row = from; row <= to; row += stride) {
      const px = view.toX(this.xOf(x.at(row)));
      const py = view.toY(this.yOf(y.at(row)));
      const there = !Number.isNaN(px) && !Number.isNaN(py);
      if (down && there && row + stride <= to && Math.abs(px - lastX) < near && Math.abs(py - lastY) < near) {
        continue;
      }
      lastX = px;
      lastY = py;
      if (there && loop.style === 'points') {
        ctx.rect(px - 1.5 * view.ratio, py - 1.5 * view.ratio, 3 * view.ratio, 3 * view.ratio);
      } else if (there) {
        if (down) {
          ctx.lineTo(px, py);
        } else {
          ctx.moveTo(px, py);
        }
      }
      down = there;
    }
    if (loop.style === 'points') {
      ctx.fill();
    } else {
      ctx.stroke();
    }
  }
}
