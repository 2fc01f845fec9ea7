// A plot's frame: head with legend, axes, cursor, selection, gestures, size and colours. uPlot does axes and
// cursor; the kinds of plots draw into it.

import uPlot from 'uplot';
import { axisFont, axisSize, bottomSize, endRoom, endSize, leftSize, rightSize, xAxis, yAxis } from './axes';
import { cancelDraw, requestDraw } from './frames';
import { type GestureTarget, listen } from './gestures';
import type { Member, PlotGroup, Side, Zoom } from './group';
import { element, Legend, type LegendItem } from './legend';
import type { Project } from './pens';
import { onTheme, theme } from './theme';

export type Span = [number, number];
/** What the axes show. */
export interface Scales {
  x: Span;
  y: Span;
  right?: Span;
}

/** Where a drawing goes: canvas pixels, of which `ratio` make a pixel of CSS. */
export interface View {
  ctx: CanvasRenderingContext2D;
  toX: Project;
  toY: Project;
  toRight: Project;
  ratio: number;
  left: number;
  top: number;
  width: number;
  height: number;
}

export interface ChartOptions {
  id: string;
  title: string;
  unit?: string;
  xLabel?: string;
  height?: number; ///< of the drawing, in pixels of CSS; its class says it where absent
  group: PlotGroup | null; ///< that it is a member of
  zoom: Zoom; ///< that group, or a box
  yLog?: boolean;
  right?: boolean;
  axes?: { x?: Partial<uPlot.Axis>; y?: Partial<uPlot.Axis> }; ///< what is unusual of them
  legend: LegendItem[];
  onToggle?: (key: string, hidden: boolean) => void;
}

export abstract class Chart implements Member, GestureTarget {
  readonly root: HTMLElement;
  protected readonly legend: Legend;
  protected u: uPlot;
  private readonly body = element('div', 'plot-body');
  private readonly tag = element('div', 'plot-tag');
  private readonly ends: (() => void)[] = [];
  private onScreen = true;
  private drawnAt = -Infinity;
  private rightShown: boolean;
  /** Widths of the vertical axes: what the labels need, and what they have. */
  private readonly needed = { left: leftSize, right: rightSize };
  private readonly given = { left: leftSize, right: rightSize };
  private end = endSize;
  protected scales: Scales = { x: [0, 1], y: [0, 1] };

  constructor(
    parent: HTMLElement,
    protected readonly options: ChartOptions,
  ) {
    this.root = element('figure', 'plot');
    this.root.tabIndex = 0;
    this.root.dataset['testid'] = `plot-${options.id}`;
    this.root.setAttribute('role', 'group');
    this.root.setAttribute(
      'aria-label',
      `${options.title}: plot. Arrow keys move the cursor, plus and ` +
        'minus zoom, Shift and arrows move, 0 shows all.',
    );
    this.legend = new Legend(options.title, options.unit, options.legend, (key, hidden) => {
      options.onToggle?.(key, hidden);
      this.changed();
    });
    if (options.height) {
      this.body.style.height = `${options.height}px`;
    }
    this.root.append(this.legend.root, this.body);
    if (options.xLabel) {
      this.root.append(element('div', 'plot-x-label', options.xLabel));
    }
    parent.append(this.root);
    this.root.classList.toggle('plot-xy', options.zoom.vertical);
    this.rightShown = this.hasRightAxis();
    this.u = this.make();
    listen(this.root, this);
    this.watch();
    options.group?.add(this);
    this.changed();
  }

  get over(): HTMLElement {
    return this.u.over;
  }

  /** Inside the axes, in pixels of CSS; known without asking the browser for its lay-out. */
  get width(): number {
    return Math.max(1, this.u.bbox.width / uPlot.pxRatio);
  }
  get height(): number {
    return Math.max(1, this.u.bbox.height / uPlot.pxRatio);
  }

  active(): boolean {
    return this.root.contains(document.activeElement);
  }

  /** In the next frame. */
  changed(): void {
    requestDraw(this);
  }

  /** Off screen it is drawn once a second only: enough for whoever prints the page. */
  draw(): void {
    if (this.onScreen || performance.now() - this.drawnAt > 1000) {
      this.drawNow();
    }
  }

  drawNow(): void {
    const right = this.hasRightAxis() || this.options.zoom.hasRightAxis();
    if (right !== this.rightShown) {
      this.rightShown = right;
      this.remake();
    }
    this.scales = this.measure(Math.max(50, this.width));
    const { x } = this.scales;
    this.u.batch(() => {
      this.u.setData([x], false);
      this.u.setScale('x', { min: x[0], max: x[1] });
      if (this.given.left !== this.sizeOf('left') || this.given.right !== this.sizeOf('right')) {
        this.u.redraw(false, true);
      }
    });
    this.root.dataset['drawn'] = 'true';
    this.drawnAt = performance.now();
  }

  destroy(): void {
    this.options.group?.remove(this);
    this.ends.forEach((end) => end());
    cancelDraw(this);
    this.u.destroy();
    this.root.remove();
  }

  /** What is to be shown, before the axes are drawn; `pixels` is the width between them. */
  protected abstract measure(pixels: number): Scales;
  protected abstract paint(view: View): void;

  cursorMoved(_x: number | null): void {
    this.changed();
  }

  hasRightAxis(): boolean {
    return this.options.right ?? false;
  }

  axisSize(side: Side): number {
    return this.options.zoom === this.options.group ? this.needed[side] : 0;
  }

  pan(dx: number, dy: number): void {
    this.options.zoom.pan(-dx / this.width, dy / this.height);
  }
  zoomAt(left: number, top: number, factor: number): void {
    this.options.zoom.zoomAt(factor, this.u.posToVal(left, 'x'), this.u.posToVal(top, 'y'));
  }
  reset(): void {
    this.options.zoom.reset();
  }
  pointAt(left: number | null, _top: number): void {
    this.options.zoom.setCursor(left === null ? null : this.u.posToVal(left, 'x'));
  }
  step(share: number): void {
    this.options.zoom.stepCursor(share);
  }

  /** Puts the vertical line of the cursor, and at its foot a text where the mouse is; null takes both away. */
  protected placeCursor(x: number | null, write: (x: number) => string): void {
    const text = x !== null && this.root.matches(':hover, :focus') ? write(x) : '';
    const left = x === null ? -10 : this.u.valToPos(x, 'x');
    const inside = left >= 0 && left <= this.width;
    if (Math.abs((this.u.cursor.left ?? -10) - left) > 0.5) {
      this.u.setCursor({ left: inside ? left : -10, top: inside ? 0 : -10 }, false);
    }
    this.tag.hidden = !inside || text === '';
    if (!this.tag.hidden) {
      this.tag.textContent = text;
      this.tag.style.left = `${Math.max(28, Math.min(this.width - 28, left))}px`;
    }
  }

  private sizeOf(side: Side): number {
    return Math.max(this.needed[side], this.options.zoom.axisSize(side));
  }

  /** Widens an axis to its labels. The others of the group follow in the next frame. */
  private fitted(side: Side, labels: readonly string[]): number {
    const needed = axisSize(labels, side === 'left' ? leftSize : rightSize);
    if (needed !== this.needed[side]) {
      this.needed[side] = needed;
      this.options.group?.invalidate();
    }
    this.given[side] = this.sizeOf(side);
    return this.given[side];
  }

  private make(): uPlot {
    const { options } = this;
    const {
      vertical,
      options: { log },
    } = options.zoom;
    const range = (which: 'y' | 'right', log?: boolean) => (): Span =>
      drawable(this.scales[which] ?? this.scales.y, log);
    const distr = (log?: boolean): { distr?: 3; log?: 10 } => (log ? { distr: 3, log: 10 } : {});
    const width = this.body.clientWidth || 300;
    const height = this.body.clientHeight || 160;
    const made = new uPlot(
      {
        width,
        height,
        padding: [6, () => (this.rightShown ? 0 : this.end), 0, 0],
        legend: { show: false },
        cursor: {
          y: false,
          points: { show: false },
          drag: { x: true, y: vertical, setScale: false, dist: 4, ...(vertical ? { uni: 30 } : {}) },
          bind: {
            dblclick: () => null,
            mousedown: (_u, _target, handler) => (event) => {
              if (event.button === 0 && !event.shiftKey && !fromTouch(event)) {
                handler(event);
              }
              return null;
            },
          },
        },
        scales: {
          x: { time: false, range: (_u, low, high) => drawable([low, high], log), ...distr(log) },
          y: { range: range('y', options.yLog), ...distr(options.yLog) },
          right: { range: range('right') },
        },
        axes: [
          {
            ...xAxis(options.zoom.options),
            ...options.axes?.x,
            size: (_u, labels) => {
              this.end = endRoom(labels ?? []);
              return bottomSize;
            },
          },
          {
            ...yAxis('left', options.yLog ?? false),
            ...options.axes?.y,
            size: (_u, labels) => this.fitted('left', labels ?? []),
          },
          {
            ...yAxis('right', false, !options.right),
            show: this.rightShown,
            size: (_u, labels) => this.fitted('right', labels ?? []),
          },
        ],
        series: [{}],
        hooks: {
          draw: [(u) => this.painted(u)],
          setSelect: [(u) => this.boxed(u)],
          setCursor: [(u) => this.pointAt((u.cursor.left ?? -1) < 0 ? null : u.cursor.left!, u.cursor.top ?? 0)],
        },
      },
      [[0, 1]],
      this.body,
    );
    made.over.append(this.tag);
    this.tag.hidden = true;
    return made;
  }

  private remake(): void {
    this.u.destroy();
    this.u = this.make();
    // The gestures listen to the area inside the axes, which is another element now.
    listen(this.root, this);
  }

  private painted(u: uPlot): void {
    const { left, top, width, height } = u.bbox;
    const project = (span: Span, from: number, to: number, log = false): Project => {
      const value = (x: number): number => (log ? Math.log10(Math.max(x, 1e-300)) : x);
      const low = value(span[0]);
      const factor = (to - from) / (value(span[1]) - low);
      return log ? (x) => from + (value(x) - low) * factor : (x) => from + (x - low) * factor;
    };
    const { ctx } = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(left, top, width, height);
    ctx.clip();
    this.paint({
      ctx,
      toX: project(this.scales.x, left, left + width, this.options.zoom.options.log),
      toY: project(this.scales.y, top + height, top, this.options.yLog),
      toRight: project(this.scales.right ?? this.scales.y, top + height, top),
      ratio: uPlot.pxRatio,
      left,
      top,
      width,
      height,
    });
    ctx.restore();
  }

  private boxed(u: uPlot): void {
    const { left, top, width, height } = u.select;
    if (width < 4 && height < 4) {
      return;
    }
    const at = (px: number, scale: string): number => u.posToVal(px, scale);
    u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.options.zoom.zoom([at(left, 'x'), at(left + width, 'x')], [at(top + height, 'y'), at(top, 'y')]);
  }

  private watch(): void {
    const size = new ResizeObserver(() => {
      const { clientWidth, clientHeight } = this.body;
      if (clientWidth > 0 && (clientWidth !== this.u.width || clientHeight !== this.u.height)) {
        this.u.setSize({ width: clientWidth, height: clientHeight });
        this.changed();
      }
    });
    size.observe(this.body);
    const sight = new IntersectionObserver(
      ([entry]) => {
        this.onScreen = entry?.isIntersecting ?? true;
        if (this.onScreen) {
          this.changed();
        }
      },
      { rootMargin: '200px' },
    );
    sight.observe(this.root);
    this.ends.push(
      () => size.disconnect(),
      () => sight.disconnect(),
      onTheme(() => {
        this.legend.colour();
        this.drawNow();
      }),
    );
  }
}

/** uPlot looks for the ticks of a logarithmic axis that begins at 0 until the memory is full. */
export function drawable([low, high]: Span, log = false): Span {
  return log && !(low > 0 && high > low) ? [0.1, 1] : [low, high];
}

/** Browsers make mouse events of touches. */
function fromTouch(event: MouseEvent): boolean {
  const source = (event as unknown as { sourceCapabilities?: { firesTouchEvents: boolean } }).sourceCapabilities;
  return source?.firesTouchEvents ?? false;
}

const labelFont = (view: View): string => axisFont.replace('12px', `${11 * view.ratio}px`);

export function labelWidth(view: View, text: string): number {
  view.ctx.font = labelFont(view);
  return view.ctx.measureText(text).width;
}

/** A text in the drawing, in the font of the axes. */
export function label(view: View, text: string, x: number, y: number, colour = theme().soft): void {
  view.ctx.font = labelFont(view);
  view.ctx.fillStyle = colour;
  view.ctx.textAlign = 'left';
  view.ctx.textBaseline = 'bottom';
  view.ctx.fillText(text, x, y);
}

export function dot({ ctx, ratio }: View, px: number, py: number, radius: number, colour: string): void {
  ctx.setLineDash([]);
  ctx.fillStyle = colour;
  ctx.strokeStyle = theme().ground;
  ctx.lineWidth = 1.5 * ratio;
  ctx.beginPath();
  ctx.arc(px, py, radius * ratio, 0, 2 * Math.PI);
  ctx.fill();
  ctx.stroke();
}
