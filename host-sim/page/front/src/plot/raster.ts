// Lines and areas of samples that are denser than pixels, as pixels. Stroking a zigzag that goes up and down
// at each column of pixels takes ten times as long as all else of a picture; here a column costs what it is
// high, and a plot of three signals 0.2 ms.

import type { Pen, Project, Rows } from './pens';

interface Place {
  ctx: CanvasRenderingContext2D;
  left: number;
  top: number;
  width: number;
  height: number;
}

type Colour = [red: number, green: number, blue: number];

/** Of `#rrggbb`. */
function parts(colour: string): Colour {
  const at = (from: number): number => parseInt(colour.slice(from, from + 2), 16);
  return [at(1), at(3), at(5)];
}

export class Raster {
  private canvas: HTMLCanvasElement | null = null;
  private image: ImageData | null = null;
  private bytes = new Uint8ClampedArray(0);
  private words = new Uint32Array(0);
  private width = 0;
  private height = 0;
  private empty = true;
  // What a line covers of each column of pixels; above `high` where nothing.
  private low = new Float64Array(0);
  private high = new Float64Array(0);

  /** Takes the size of the place that is drawn at next. */
  private fit(place: Place): void {
    const width = Math.max(1, Math.round(place.width));
    const height = Math.max(1, Math.round(place.height));
    if (!this.canvas || width !== this.width || height !== this.height) {
      this.canvas ??= document.createElement('canvas');
      this.canvas.width = this.width = width;
      this.canvas.height = this.height = height;
      this.image = new ImageData(width, height);
      this.bytes = this.image.data;
      this.words = new Uint32Array(this.bytes.buffer);
      this.low = new Float64Array(width);
      this.high = new Float64Array(width);
    }
    if (this.empty) {
      this.words.fill(0);
    }
    this.empty = false;
  }

  /** Puts what has been drawn where it belongs, over what is there. */
  finish(place: Place): void {
    if (this.empty || !this.canvas || !this.image) {
      return;
    }
    this.empty = true;
    this.canvas.getContext('2d')?.putImageData(this.image, 0, 0);
    place.ctx.drawImage(this.canvas, Math.round(place.left), Math.round(place.top));
  }

  /** A line from row to row, or (`steps`) each value until the next one. A NaN ends it. */
  line(place: Place, rows: Rows, y: Float64Array, toX: Project, toY: Project, pen: Pen, steps: boolean): void {
    this.fit(place);
    this.low.fill(Infinity);
    this.high.fill(-Infinity);
    let lastX = NaN;
    let lastY = NaN;
    for (let row = 0; row < rows.count; ++row) {
      const px = toX(rows.x[row]!) - place.left;
      const py = toY(y[row]!) - place.top;
      if (Number.isNaN(py)) {
        if (steps && !Number.isNaN(lastY)) {
          this.cover(lastX, lastY, px, lastY);
        }
      } else if (Number.isNaN(lastY)) {
        this.cover(px, py, px, py);
      } else if (steps) {
        this.cover(lastX, lastY, px, lastY);
        this.cover(px, lastY, px, py);
      } else {
        this.cover(lastX, lastY, px, py);
      }
      lastX = px;
      lastY = py;
    }
    this.ink(pen, this.dashes(rows, toX, pen, place));
  }

  /** The area between two rows of values. */
  area(
    place: Place,
    rows: Rows,
    low: Float64Array,
    high: Float64Array,
    toX: Project,
    toY: Project,
    colour: string,
    opacity: number,
  ): void {
    this.fit(place);
    this.low.fill(Infinity);
    this.high.fill(-Infinity);
    let column = -1;
    for (let row = 0; row < rows.count; ++row) {
      const next = Math.floor(toX(rows.x[row]!) - place.left);
      const bottom = toY(low[row]!) - place.top;
      const top = toY(high[row]!) - place.top;
      if (Number.isNaN(bottom) || Number.isNaN(top)) {
        column = -1;
        continue;
      }
      // The last row of a pixel counts: two areas that touch have the same edge.
      const from = Math.max(0, column < 0 ? next : Math.min(next, column + 1));
      for (let at = from; at <= next && at < this.width; ++at) {
        this.low[at] = Math.min(top, bottom);
        this.high[at] = Math.max(top, bottom);
      }
      column = next;
    }
    const ink = parts(colour);
    for (let at = 0; at < this.width; ++at) {
      if (this.high[at]! >= this.low[at]!) {
        this.upright(at, this.low[at]!, this.high[at]!, ink, opacity);
      }
    }
  }

  /** A straight piece: what it covers of each column. */
  private cover(x0: number, y0: number, x1: number, y1: number): void {
    const from = Math.max(0, Math.floor(x0));
    const to = Math.min(this.width - 1, Math.floor(x1));
    const slope = x1 > x0 ? (y1 - y0) / (x1 - x0) : 0;
    for (let column = from; column <= to; ++column) {
      const begin = column <= x0 ? y0 : y0 + (column - x0) * slope;
      const end = column + 1 >= x1 ? y1 : y0 + (column + 1 - x0) * slope;
      if (begin < this.low[column]!) {
        this.low[column] = begin;
      }
      if (begin > this.high[column]!) {
        this.high[column] = begin;
      }
      if (end < this.low[column]!) {
        this.low[column] = end;
      }
      if (end > this.high[column]!) {
        this.high[column] = end;
      }
    }
  }

  /** Whether a dashed line is there, by column: the dashes belong to x, and move with it. */
  private dashes(rows: Rows, toX: Project, pen: Pen, place: Place): ((column: number) => boolean) | null {
    const [on = 0, off = 0] = pen.dash;
    const period = on + off;
    const last = rows.count - 1;
    if (!(period > 0) || last < 1) {
      return null;
    }
    const [x0, x1] = [rows.x[0]!, rows.x[last]!];
    const origin = toX(x0) - place.left - (x0 * (toX(x1) - toX(x0))) / (x1 - x0);
    return (column) => (((column - origin) % period) + period) % period < on;
  }

  /** Draws what is covered, as wide as the pen. Of dashes, an upright part that stands alone stays whole. */
  private ink(pen: Pen, there: ((column: number) => boolean) | null): void {
    const width = Math.max(1, Math.round(pen.width));
    const before = (width - 1) >> 1;
    const after = width - 1 - before;
    const colour = parts(pen.colour);
    const half = pen.width / 2;
    const tall = (column: number): boolean => this.high[column]! - this.low[column]! > 4 * width;
    for (let column = 0; column < this.width; ++column) {
      let low = Infinity;
      let high = -Infinity;
      for (let near = Math.max(0, column - after); near <= column + before && near < this.width; ++near) {
        if (there && !there(near) && !(tall(near) && !(tall(near - 3 * width) || tall(near + 3 * width)))) {
          continue;
        }
        if (this.low[near]! < low) {
          low = this.low[near]!;
        }
        if (this.high[near]! > high) {
          high = this.high[near]!;
        }
      }
      if (high >= low) {
        this.upright(column, low - half, high + half, colour, 1);
      }
    }
  }

  /** A piece of a column; its ends cover their pixels in part. */
  private upright(column: number, low: number, high: number, ink: Colour, opacity: number): void {
    const from = Math.max(0, low);
    const to = Math.min(this.height, high);
    if (!(to > from)) {
      return;
    }
    const first = Math.ceil(from);
    const last = Math.floor(to);
    if (first > last) {
      this.blend(column, last, ink, opacity * (to - from));
      return;
    }
    if (first > from) {
      this.blend(column, first - 1, ink, opacity * (first - from));
    }
    if (to > last) {
      this.blend(column, last, ink, opacity * (to - last));
    }
    if (opacity < 1) {
      for (let row = first; row < last; ++row) {
        this.blend(column, row, ink, opacity);
      }
      return;
    }
    // All machines with a browser have the low byte first.
    const word = ((255 << 24) | (ink[2] << 16) | (ink[1] << 8) | ink[0]) >>> 0;
    const end = last * this.width + column;
    for (let at = first * this.width + column; at < end; at += this.width) {
      this.words[at] = word;
    }
  }

  private blend(column: number, row: number, ink: Colour, opacity: number): void {
    const at = 4 * (row * this.width + column);
    const { bytes } = this;
    const under = (bytes[at + 3]! / 255) * (1 - opacity);
    const all = opacity + under;
    if (!(all > 0)) {
      return;
    }
    for (let part = 0; part < 3; ++part) {
      bytes[at + part] = (ink[part]! * opacity + bytes[at + part]! * under) / all;
    }
    bytes[at + 3] = 255 * all;
  }
}
