// What a plot shows of axes that no group shares: gestures change both.

import type { Scales, Span } from './chart';
import type { GroupOptions, Zoom } from './group';

export class Box implements Zoom {
  readonly options: GroupOptions;
  readonly vertical = true;
  private shown: Scales = { x: [0, 1], y: [0, 1] };

  constructor(
    private readonly changed: () => void,
    log = false,
    private zoomed: Scales | null = null,
  ) {
    this.options = { x: 'number', extent: () => null, log };
  }

  /** What is shown now: what gestures have chosen, else all. With a size in pixels, a unit is as long in both. */
  measure(all: () => Scales, size?: { width: number; height: number }): Scales {
    const box = this.zoomed ?? all();
    this.shown = size ? equalised(box, size.width, size.height) : box;
    return this.shown;
  }

  zoom(x: Span, y: Span): void {
    if (x[1] > x[0] && y[1] > y[0]) {
      this.zoomed = { x, y };
    }
    this.changed();
  }
  zoomAt(factor: number, x: number, y: number): void {
    const about = (span: Span, at: number): Span => [at + (span[0] - at) * factor, at + (span[1] - at) * factor];
    this.zoomed = { x: about(this.shown.x, x), y: about(this.shown.y, y) };
    this.changed();
  }
  pan(right: number, up: number): void {
    const moved = (span: Span, share: number): Span => {
      const by = share * (span[1] - span[0]);
      return [span[0] + by, span[1] + by];
    };
    this.zoomed = { x: moved(this.shown.x, right), y: moved(this.shown.y, up) };
    this.changed();
  }
  reset(): void {
    this.zoomed = null;
    this.changed();
  }

  /** Its plot has no cursor, or one of its own. */
  setCursor(): void {}
  stepCursor(): void {}
  hasRightAxis(): boolean {
    return false;
  }
  axisSize(): number {
    return 0;
  }
}

/** Widens the shorter axis until a unit is as long in both. */
function equalised({ x, y }: Scales, width: number, height: number): Scales {
  const unit = Math.max((x[1] - x[0]) / width, (y[1] - y[0]) / height);
  const around = (span: Span, pixels: number): Span => {
    const middle = (span[0] + span[1]) / 2;
    return [middle - (unit * pixels) / 2, middle + (unit * pixels) / 2];
  };
  return { x: around(x, width), y: around(y, height) };
}

/** Makes a span hold a value, or a range of values; NaN is left out. */
export function include(span: Span, low: number, high = low): void {
  if (low < span[0]) {
    span[0] = low;
  }
  if (high > span[1]) {
    span[1] = high;
  }
}
