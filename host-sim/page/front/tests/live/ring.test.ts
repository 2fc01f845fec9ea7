import { describe, expect, it } from 'vitest';
import { Feed } from '../../src/live/feed';
import { SampleRing } from '../../src/live/ring';
import { randomFrom } from '../random';

describe('SampleRing', () => {
  it('holds the last rows, and knows their extremes, after it has wrapped', () => {
    const random = randomFrom(30);
    const ring = new SampleRing(2048);
    const a: number[] = [];
    const b: number[] = [];
    for (let row = 0; row < 7000; ++row) {
      a.push(random());
      b.push(row < 700 ? NaN : random()); // a column that begins in the middle of a block
      ring.push(row * 0.01, row < 700 ? { a: a[row]! } : { a: a[row]!, b: b[row]! });
      if (row % 211 !== 0) {
        continue;
      }
      expect(ring.end).toBe(row + 1);
      expect(ring.first).toBe(Math.max(0, row + 1 - 2048));
      const from = ring.first + Math.floor(random() * (ring.end - ring.first));
      for (const [key, values] of [
        ['a', a],
        ['b', b],
      ] as const) {
        const column = ring.column(key);
        const good = values.slice(from, ring.end).filter((value) => !Number.isNaN(value));
        const range = { low: 1, high: -1 };
        column?.range(from, ring.end, range);
        if (!column) {
          expect(good).toHaveLength(0);
        } else if (good.length === 0) {
          expect(range).toEqual({ low: NaN, high: NaN });
        } else {
          expect(range).toEqual({ low: Math.fround(Math.min(...good)), high: Math.fround(Math.max(...good)) });
        }
        if (column) {
          expect(column.at(from)).toBe(Math.fround(values[from]!));
        }
      }
    }
  });

  it('leaves out rows that are not later than the last, or have no time', () => {
    const ring = new SampleRing(1024);
    ring.push(2, { a: 1 });
    for (const time of [2, 1, NaN, Infinity]) {
      ring.push(time, { a: 5 });
    }
    expect(ring.end).toBe(1);
  });

  it('does not grow with the names that are sent', () => {
    const ring = new SampleRing(1024);
    for (let i = 0; i < 1000; ++i) {
      ring.push(i, { [`name${i}`]: i });
    }
    expect(Array.from({ length: 1000 }, (_, i) => ring.column(`name${i}`)).filter(Boolean)).toHaveLength(96);
  });
});

describe('Feed', () => {
  const message = (row: object): Uint8Array => new TextEncoder().encode(JSON.stringify(row));

  it('adds band, austenite, set-point as strain, error, and the limits that act', () => {
    const feed = new Feed(1024);
    feed.mode = 1;
    feed.geometry = { zero_strain: 0.04, length_m: 0.1 };
    feed.setLimitNames(['min_current', 'current']);
    const row = { strain: 0.03, strain_sd: 0.001, martensite: 0.5, r_phase: 0.1, setpoint: 0.001, position_m: 0.0009 };
    feed.message(message({ ...row, limit_reasons: 2 }), 1);
    feed.message(message({ ...row, limit_reasons: 0 }), 1.01);
    const at = (key: string, index = 0): number => feed.ring.column(key)!.at(index);
    expect(at('strain_low')).toBeCloseTo(0.028, 6);
    expect(at('strain_high')).toBeCloseTo(0.032, 6);
    expect(at('austenite')).toBeCloseTo(0.4, 6);
    expect(at('setpoint_strain')).toBeCloseTo(0.03, 6);
    expect(at('error:position_m')).toBeCloseTo(1e-4, 8);
    expect([at('limit:current'), at('limit:current', 1)]).toEqual([1, 0]);
    expect(feed.ring.column('limit:min_current')).toBeUndefined();
  });

  it('shows no resistance and no set-point where no current flows', () => {
    const feed = new Feed(1024);
    feed.mode = 1;
    feed.message(message({ resistance_ohm: 0, drive_current_A: 0, setpoint: 0, reference: 0, position_m: 1e-4 }), 1);
    for (const key of ['resistance_ohm', 'setpoint', 'reference', 'error:position_m']) {
      expect(feed.ring.column(key)!.at(0)).toBeNaN();
    }
  });

  it('keeps the value of a signal that a message lacks, but not over a gap', () => {
    const feed = new Feed(1024);
    feed.message(message({ strain: 0.01, supply_V: 12 }), 1);
    feed.message(message({ strain: 0.02 }), 1.1);
    feed.message(message({ strain: 0.03 }), 5);
    const supply = feed.ring.column('supply_V')!;
    expect([0, 1, 2, 3].map((row) => supply.at(row))).toEqual([12, 12, NaN, NaN]);
  });

  it('makes no line over a silence, and none over a lost connection', () => {
    const feed = new Feed(1024);
    feed.message(message({ strain: 0.01 }), 10);
    feed.message(message({ strain: 0.01 }), 13);
    expect([0, 1, 2].map((row) => feed.ring.column('strain')!.at(row))).toEqual([
      Math.fround(0.01),
      NaN,
      Math.fround(0.01),
    ]);
    feed.interrupt();
    expect(feed.ring.column('strain')!.at(3)).toBeNaN();
  });

  it('takes what the bridge remembers, then what comes, in one line', () => {
    const feed = new Feed(1024);
    feed.history({ t_ns: [1e9, 1.5e9], strain: [0.01, null] });
    feed.message(message({ strain: 0.02 }), 1.5);
    feed.message(message({ strain: 0.03 }), 1.6);
    expect(feed.ring.end).toBe(3);
    expect(feed.ring.column('strain')!.at(2)).toBe(Math.fround(0.03));
  });

  it('takes no harm from what is no message', () => {
    const feed = new Feed(1024);
    for (const text of ['', '[]', '3', '{', '{"strain": "wide"}', '{"strain": {"a": 1}}']) {
      feed.message(new TextEncoder().encode(text), 1 + feed.ring.end);
    }
    feed.history({});
    feed.history({ t_ns: 'x' });
    expect(feed.ring.end).toBe(2);
    expect(feed.ring.column('strain')!.at(0)).toBeNaN();
  });
});
