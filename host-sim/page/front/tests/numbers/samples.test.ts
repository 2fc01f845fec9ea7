import { describe, expect, it } from 'vitest';
import { ArraySamples, RangedColumn } from '../../src/numbers/columns';
import { lowerBound, nearestRow, reduce, Reduced, valueAt } from '../../src/numbers/samples';
import { SampleRing } from '../../src/live/ring';
import { randomFrom } from '../random';

interface Series {
  x: number[];
  y: (number | null)[];
}

/** Irregular steps, bursts, single gaps and long ones. */
function randomSeries(random: () => number, rows: number): Series {
  const x: number[] = [];
  const y: (number | null)[] = [];
  let at = 1.7e9 + Math.floor(random() * 1000);
  let absent = 0;
  for (let row = 0; row < rows; ++row) {
    at += random() < 0.001 ? 5 * random() : 0.01 * random();
    if (random() < 0.002) {
      absent = Math.floor(random() * 50);
    }
    at = Math.round(at * 1024) / 1024;
    x.push(at);
    y.push(absent-- > 0 ? null : (random() - 0.5) * (random() < 0.001 ? 1000 : 1));
  }
  return { x, y };
}

function extremes(values: Iterable<number | null>): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (value === null || Number.isNaN(value)) {
      continue;
    }
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  return [low, high];
}

function add(lists: Map<number, (number | null)[]>, key: number, value: number | null): void {
  const list = lists.get(key);
  if (list) {
    list.push(value);
  } else {
    lists.set(key, [value]);
  }
}

describe('reduce', () => {
  it('keeps every peak of each pixel, in order of x, in at most four rows a pixel', () => {
    const random = randomFrom(10);
    for (let round = 0; round < 30; ++round) {
      const { x, y } = randomSeries(random, 2000 + Math.floor(random() * 20000));
      const samples = new ArraySamples(x, { y });
      // A width that divides without rounding: then a sample's pixel is known exactly.
      const width = [1 / 16, 1 / 32, 3 / 64][round % 3]!;
      const pixels = 20 + Math.floor(random() * 400);
      const from = x[Math.floor(random() * 0.4 * x.length)]!;
      const to = from + width * pixels;
      const out = new Reduced();
      reduce(samples, from, to, pixels, [{ key: 'y', keep: 'both' }], out);
      expect(out.count).toBeLessThanOrEqual(Math.max(2 * pixels, 4 * (pixels + 4)));
      for (let row = 1; row < out.count; ++row) {
        expect(out.x[row]!).toBeGreaterThanOrEqual(out.x[row - 1]!);
      }
      const bucket = (at: number): number => Math.floor(at / width);
      const wanted = new Map<number, (number | null)[]>();
      x.forEach((at, row) => {
        if (at < from || at > to) {
          return;
        }
        add(wanted, bucket(at), y[row] ?? null);
      });
      const got = new Map<number, (number | null)[]>();
      for (let row = 0; row < out.count; ++row) {
        add(got, bucket(out.x[row]!), out.y[0]![row]!);
      }
      // The outer pixels are shared with rows outside of the window.
      const inner = [...wanted.keys()].filter((key) => key > bucket(from) && key < bucket(to));
      for (const key of inner) {
        expect(extremes(got.get(key) ?? [])).toEqual(extremes(wanted.get(key)!));
      }
    }
  });

  it('keeps a gap that begins or ends in a pixel', () => {
    const x = Array.from({ length: 10000 }, (_, row) => row * 1e-3 + (row > 5000 ? 20 : 0));
    const y: (number | null)[] = x.map(() => 1);
    y[5000] = null;
    const out = new Reduced();
    reduce(new ArraySamples(x, { y }), 0, 30, 100, [{ key: 'y', keep: 'both' }], out);
    const values = [...out.y[0]!.subarray(0, out.count)];
    const gap = values.findIndex((value) => Number.isNaN(value));
    expect(out.x[gap]).toBe(5);
    expect(values.filter((value) => Number.isNaN(value))).toHaveLength(1);
  });

  it('gives the rows themselves where there are few, with one beyond each end', () => {
    const x = [0, 1, 2, 3, 4, 5];
    const out = new Reduced();
    reduce(new ArraySamples(x, { y: [0, 10, 20, null, 40, 50] }), 1.5, 3.5, 100, [{ key: 'y', keep: 'both' }], out);
    expect([...out.x.subarray(0, out.count)]).toEqual([1, 2, 3, 4]);
    expect([...out.y[0]!.subarray(0, out.count)]).toEqual([10, 20, NaN, 40]);
  });

  it('does not flicker: a window that moves by a whole pixel gives the same rows', () => {
    const random = randomFrom(11);
    const { x, y } = randomSeries(random, 20000);
    const samples = new ArraySamples(x, { y });
    const span = x[15000]! - x[2000]!;
    const rowsUntil = (end: number): Set<string> => {
      const out = new Reduced();
      reduce(samples, end - span, end, 200, [{ key: 'y', keep: 'both' }], out);
      return new Set(Array.from({ length: out.count }, (_, row) => `${out.x[row]} ${out.y[0]![row]}`));
    };
    for (let step = 0; step < 200; ++step) {
      const end = x[15000 + 20 * step]!;
      const one = rowsUntil(end);
      const other = rowsUntil(end + span / 200);
      const lost = [...one].filter((row) => !other.has(row));
      expect(lost.length).toBeLessThanOrEqual(12); // those of the outermost pixels
      expect(one.size).toBeGreaterThan(100);
    }
  });

  it('gives the same rows with those of the last window as without', () => {
    const random = randomFrom(13);
    const { x, y } = randomSeries(random, 30000);
    const samples = new ArraySamples(x, { y });
    const wants = [
      { key: 'y', keep: 'both' as const },
      { key: 'y', keep: 'ends' as const },
    ];
    const again = new Reduced();
    let keptAny = 0;
    let from = x[1000]!;
    let span = 40;
    for (let round = 0; round < 400; ++round) {
      if (random() < 0.05) {
        span = 20 + 40 * random();
      }
      // Mostly on by little, sometimes back or far; the samples end in some of the windows.
      from += random() < 0.1 ? 60 * (random() - 0.5) : 0.2 * random();
      from = Math.min(Math.max(from, x[0]! - 5), x[x.length - 1]! - 20);
      const fresh = new Reduced();
      reduce(samples, from, from + span, 300, wants, fresh);
      reduce(samples, from, from + span, 300, wants, again);
      keptAny += again.kept;
      expect(again.kept).toBeLessThanOrEqual(again.count);
      expect(again.x.subarray(0, again.count)).toEqual(fresh.x.subarray(0, fresh.count));
      for (const c of [0, 1]) {
        expect(again.y[c]!.subarray(0, again.count)).toEqual(fresh.y[c]!.subarray(0, fresh.count));
      }
    }
    expect(keptAny).toBeGreaterThan(400 * 300);
  });

  it('keeps rows while samples are added to a ring that overwrites the oldest', () => {
    const ring = new SampleRing(4096);
    const again = new Reduced();
    const wants = [{ key: 'y', keep: 'both' as const }];
    const random = randomFrom(14);
    for (let at = 0; at < 20000; ++at) {
      ring.push(at * 0.001, { y: random() });
      if (at % 37 !== 0 || at < 1000) {
        continue;
      }
      const fresh = new Reduced();
      reduce(ring, at * 0.001 - 4, at * 0.001, 100, wants, fresh);
      reduce(ring, at * 0.001 - 4, at * 0.001, 100, wants, again);
      // The first pixel may have samples that the ring has no more.
      const known = (rows: Reduced): [number, number][] =>
        Array.from({ length: rows.count }, (_, row): [number, number] => [rows.x[row]!, rows.y[0]![row]!]).filter(
          ([x]) => x > at * 0.001 - 3.95,
        );
      expect(known(again)).toEqual(known(fresh));
    }
  });

  it('takes one extreme for the edges of a band, and outer samples for what is stacked', () => {
    const x = Array.from({ length: 1000 }, (_, row) => row);
    const y = x.map((row) => Math.sin(row));
    const out = new Reduced();
    const wants = (['low', 'high', 'ends'] as const).map((keep) => ({ key: 'y', keep }));
    reduce(new ArraySamples(x, { y }), 0, 1000, 10, wants, out);
    for (let row = 0; row + 1 < out.count; row += 2) {
      const from = out.x[row]!;
      const to = out.x[row + 1]!;
      const [low, high] = extremes(y.slice(from, to + 1));
      expect([out.y[0]![row], out.y[0]![row + 1]]).toEqual([low, low]);
      expect([out.y[1]![row], out.y[1]![row + 1]]).toEqual([high, high]);
      expect([out.y[2]![row], out.y[2]![row + 1]]).toEqual([y[from], y[to]]);
    }
  });
});

describe('RangedColumn', () => {
  it('knows the range of any rows that the ring still holds', () => {
    const random = randomFrom(12);
    const capacity = 4096;
    const column = new RangedColumn(new Float64Array(capacity));
    const all: number[] = [];
    for (let row = 0; row < 3 * capacity; ++row) {
      all.push(random() < 0.1 ? NaN : random());
      column.set(row, all[row]!);
      if (row % 97 !== 0) {
        continue;
      }
      const first = Math.max(0, row + 1 - capacity);
      const from = first + Math.floor(random() * (row + 1 - first));
      const to = from + Math.floor(random() * (row + 1 - from)) + 1;
      const range = { low: 0, high: 0 };
      column.range(from, to, range);
      const [low, high] = extremes(all.slice(from, to));
      expect(range).toEqual(low > high ? { low: NaN, high: NaN } : { low, high });
    }
  });
});

describe('rows', () => {
  const samples = new ArraySamples([0, 1, 1, 4], { y: [5, 6, 7, null] });
  it('are found by x', () => {
    expect([-1, 0, 0.5, 1, 3, 4, 5].map((x) => lowerBound(samples, x))).toEqual([0, 0, 1, 1, 3, 3, 4]);
    expect([-1, 0.4, 0.6, 2, 3, 9].map((x) => nearestRow(samples, x))).toEqual([0, 0, 1, 2, 3, 3]);
  });
  it('have a value near x, or none', () => {
    expect(valueAt(samples, 'y', 0.2)).toBe(5);
    expect(valueAt(samples, 'y', 0.2, 0.1)).toBeNaN();
    expect(valueAt(samples, 'y', 4)).toBeNaN();
    expect(valueAt(samples, 'other', 0)).toBeNaN();
  });
});
