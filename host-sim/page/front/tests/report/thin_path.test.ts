import { describe, expect, it } from 'vitest';
import { ThinPath } from '../../src/report/thin_path';
import { randomFrom } from '../random';

type Point = [number, number];

class Lines {
  readonly all: Point[][] = [];
  moveTo(x: number, y: number): void {
    this.all.push([[x, y]]);
  }
  lineTo(x: number, y: number): void {
    this.all.at(-1)!.push([x, y]);
  }
}

function drawn(lines: Point[][]): Point[][] {
  const kept = new Lines();
  const path = new ThinPath(kept);
  for (const line of lines) {
    line.forEach(([x, y], k) => (k === 0 ? path.start(x, y) : path.to(x, y)));
  }
  path.end();
  return kept.all;
}

/** By column of pixels: the lowest and the highest point. */
function extremes(line: Point[]): Map<number, Point> {
  const all = new Map<number, Point>();
  for (const [x, y] of line) {
    const [low, high] = all.get(Math.floor(x)) ?? [y, y];
    all.set(Math.floor(x), [Math.min(low, y), Math.max(high, y)]);
  }
  return all;
}

describe('ThinPath', () => {
  const next = randomFrom(5);
  it('keeps ends and extremes of each column, in few points, along any line', () => {
    for (let k = 0; k < 200; ++k) {
      const back = k % 2 === 1; // a loop goes back as well
      const line: Point[] = [];
      let x = 100 * next();
      for (let i = 0; i < 2000; ++i) {
        x = Math.min(99, Math.max(0, x + (next() - (back ? 0.5 : 0.2))));
        line.push([x, next() < 0.1 ? 100 * next() : Math.round(100 * next()) / 10]);
      }
      const [thin] = drawn([line]);
      expect(thin![0]).toEqual(line[0]);
      expect(thin!.at(-1)).toEqual(line.at(-1));
      expect(extremes(thin!)).toEqual(extremes(line));
      const visits = line.filter(([at], i) => i === 0 || Math.floor(at) !== Math.floor(line[i - 1]![0])).length;
      expect(thin!.length).toBeLessThanOrEqual(4 * visits);
    }
  });
  it('does not join two lines', () => {
    const lines: Point[][] = [
      [
        [0.1, 1],
        [0.2, 2],
        [0.3, 0],
      ],
      [
        [0.4, 7],
        [3, 8],
      ],
    ];
    expect(drawn(lines)).toEqual([
      [
        [0.1, 1],
        [0.3, 0],
        [0.2, 2],
        [0.3, 0],
      ],
      [
        [0.4, 7],
        [3, 8],
      ],
    ]);
  });
});
