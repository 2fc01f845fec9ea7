// Drawing reduced rows on a canvas. A NaN ends a line and begins another one after it.

export interface Rows {
  count: number;
  x: Float64Array;
}

/** What turns values into pixels of the canvas. */
export type Project = (value: number) => number;

export interface Pen {
  colour: string;
  width: number; ///< in pixels of the canvas
  dash: number[];
}

function begin(ctx: CanvasRenderingContext2D, pen: Pen): void {
  ctx.strokeStyle = pen.colour;
  ctx.lineWidth = pen.width;
  ctx.lineJoin = 'bevel';
  ctx.setLineDash(pen.dash);
  ctx.beginPath();
}

export function drawLine(
  ctx: CanvasRenderingContext2D,
  rows: Rows,
  y: Float64Array,
  toX: Project,
  toY: Project,
  pen: Pen,
): void {
  begin(ctx, pen);
  let down = false;
  for (let row = 0; row < rows.count; ++row) {
    const value = y[row]!;
    if (Number.isNaN(value)) {
      down = false;
      continue;
    }
    const px = toX(rows.x[row]!);
    const py = toY(value);
    if (down) {
      ctx.lineTo(px, py);
    } else {
      ctx.moveTo(px, py);
      if (!(row + 1 < rows.count) || Number.isNaN(y[row + 1]!)) {
        ctx.lineTo(px + pen.width, py);
      }
    }
    down = true;
  }
  ctx.stroke();
}

/** Each value holds until the next one. */
export function drawSteps(
  ctx: CanvasRenderingContext2D,
  rows: Rows,
  y: Float64Array,
  toX: Project,
  toY: Project,
  pen: Pen,
): void {
  begin(ctx, pen);
  let last = NaN;
  for (let row = 0; row < rows.count; ++row) {
    const value = y[row]!;
    const px = toX(rows.x[row]!);
    if (!Number.isNaN(last)) {
      ctx.lineTo(px, last);
    }
    if (Number.isNaN(value)) {
      last = NaN;
      continue;
    }
    const py = toY(value);
    if (Number.isNaN(last)) {
      ctx.moveTo(px, py);
    } else {
      ctx.lineTo(px, py);
    }
    last = py;
  }
  ctx.stroke();
}

export function drawPoints(
  ctx: CanvasRenderingContext2D,
  rows: Rows,
  y: Float64Array,
  toX: Project,
  toY: Project,
  pen: Pen,
): void {
  ctx.fillStyle = pen.colour;
  const size = Math.max(2, 1.8 * pen.width);
  for (let row = 0; row < rows.count; ++row) {
    const value = y[row]!;
    if (Number.isNaN(value)) {
      continue;
    }
    ctx.fillRect(toX(rows.x[row]!) - size / 2, toY(value) - size / 2, size, size);
  }
}

/** The area between two rows of values. */
export function drawArea(
  ctx: CanvasRenderingContext2D,
  rows: Rows,
  low: Float64Array,
  high: Float64Array,
  toX: Project,
  toY: Project,
  fill: string,
): void {
  ctx.fillStyle = fill;
  const there = (row: number): boolean => !Number.isNaN(low[row]!) && !Number.isNaN(high[row]!);
  for (let row = 0; row < rows.count; ) {
    if (!there(row)) {
      ++row;
      continue;
    }
    const from = row;
    ctx.beginPath();
    for (; row < rows.count && there(row); ++row) {
      ctx.lineTo(toX(rows.x[row]!), toY(high[row]!));
    }
    for (let back = row - 1; back >= from; --back) {
      ctx.lineTo(toX(rows.x[back]!), toY(low[back]!));
    }
    ctx.closePath();
    ctx.fill();
  }
}
