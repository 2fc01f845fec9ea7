// A line of many points as a path of few: of points that follow one another in one column of pixels, the first,
// the extremes and the last. It looks the same, and a canvas strokes it many times as fast.

export type Path = Pick<CanvasRenderingContext2D, 'moveTo' | 'lineTo'>;

interface Point {
  x: number;
  y: number;
}

export class ThinPath {
  private column = NaN;
  private low: Point = { x: 0, y: 0 };
  private high: Point = { x: 0, y: 0 };
  private last: Point = { x: 0, y: 0 };
  private drawn: Point = { x: 0, y: 0 };

  constructor(private readonly path: Path) {}

  /** Begins another line. */
  start(x: number, y: number): void {
    this.end();
    this.path.moveTo(x, y);
    this.begin(x, y);
  }

  to(x: number, y: number): void {
    if (Math.floor(x) !== this.column) {
      this.end();
      this.path.lineTo(x, y);
      this.begin(x, y);
      return;
    }
    this.last = { x, y };
    if (y < this.low.y) {
      this.low = this.last;
    }
    if (y > this.high.y) {
      this.high = this.last;
    }
  }

  /** What the last column still lacks. */
  end(): void {
    if (Number.isNaN(this.column)) {
      return;
    }
    const { low, high, last } = this;
    // The way from one extreme to the other covers the column, whichever comes first.
    for (const point of [low, high, last]) {
      if (point.x === this.drawn.x && point.y === this.drawn.y) {
        continue;
      }
      this.path.lineTo(point.x, point.y);
      this.drawn = point;
    }
    this.column = NaN;
  }

  private begin(x: number, y: number): void {
    this.column = Math.floor(x);
    this.low = this.high = this.last = this.drawn = { x, y };
  }
}
