import { describe, expect, it } from 'vitest';
import { ascends, parsed, pieces, rowAt, type Series, valueAt } from '../../src/report/data';
import { randomFrom } from '../random';

const page = JSON.stringify({
  columns: [
    [0, 1, 2, 3],
    [5, null, 7, 8],
    [0, 0, 1, 1],
  ],
  panels: [
    {
      title: 'a',
      height: 200,
      x: {},
      y: {},
      right: {},
      rules: [],
      notes: [],
      series: [{ kind: 'area', name: 's', colour: 'ink', x: 0, y: 1, low: 2 }],
    },
    null,
  ],
});

describe('parsed()', () => {
  it('puts columns in the place of their numbers, NaN in the place of gaps', () => {
    const [panel, picture] = parsed(page);
    expect(picture).toBeNull();
    const series = panel!.series[0]!;
    expect([...series.x]).toEqual([0, 1, 2, 3]);
    expect([...series.y]).toEqual([5, NaN, 7, 8]);
    expect([...series.low!]).toEqual([0, 0, 1, 1]);
    expect(series.at).toBeUndefined();
  });
});

describe('pieces()', () => {
  it('are what stands between gaps of x', () => {
    expect(pieces(Float64Array.of(NaN, 1, 2, NaN, NaN, 3))).toEqual([
      { from: 1, to: 3 },
      { from: 5, to: 6 },
    ]);
    expect(pieces(new Float64Array())).toEqual([]);
  });
  it('ascend or not', () => {
    const x = Float64Array.of(1, 1, 2, 1);
    expect(ascends(x, { from: 0, to: 3 })).toBe(true);
    expect(ascends(x, { from: 0, to: 4 })).toBe(false);
  });
});

describe('rowAt() and valueAt()', () => {
  const next = randomFrom(11);
  const x = Float64Array.from({ length: 500 }, next).sort();
  const y = Float64Array.from({ length: 500 }, next);
  const line: Series = { kind: 'line', colour: 'ink', x, y };
  const all = { from: 0, to: x.length };

  it('agree with a search through all rows', () => {
    for (let k = 0; k < 1000; ++k) {
      const at = 1.2 * next() - 0.1;
      const first = x.findIndex((value) => value >= at);
      expect(rowAt(x, all, at)).toBe(first < 0 ? x.length : first);
      const value = valueAt(line, all, at);
      if (at < x[0]! || at > x[499]!) {
        expect(value).toBeNaN();
      } else {
        const distances = [...x].map((one) => Math.abs(one - at));
        expect(value).toBe(y[distances.indexOf(Math.min(...distances))]);
      }
    }
  });
  it('a step holds what it had, and an area shows its own height', () => {
    const rows = { x: Float64Array.of(0, 10), y: Float64Array.of(3, 8), low: Float64Array.of(1, 2) };
    const piece = { from: 0, to: 2 };
    expect(valueAt({ kind: 'steps', colour: 'ink', ...rows }, piece, 9)).toBe(3);
    expect(valueAt({ kind: 'steps', colour: 'ink', ...rows }, piece, 10)).toBe(8);
    expect(valueAt({ kind: 'area', colour: 'ink', ...rows }, piece, 9)).toBe(6);
  });
});
