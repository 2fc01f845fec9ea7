import { describe, expect, it } from 'vitest';
import { formatClock, formatDuration, formatExact, formatNumber, formatTicks } from '../../src/numbers/format';
import { randomFrom } from '../random';

describe('formatNumber', () => {
  it.each([
    [7.599999999999999e-5, '7.6e-05'],
    [0.4, '0.4'],
    [0.1 + 0.2, '0.3'],
    [1013.25, '1013'],
    [99999.7, '100000'],
    [0, '0'],
    [-0, '0'],
    [-2.5, '−2.5'],
    [150e6, '1.5e+08'],
    [NaN, '–'],
    [Infinity, '∞'],
    [0.0001, '0.0001'],
    [-3.2e-9, '−3.2e-09'],
    [1, '1'],
    [12.3456, '12.35'],
    [0.99996, '1'],
  ])('writes %d as %s', (value, text) => expect(formatNumber(value)).toBe(text));

  it('writes what is not there as a dash', () => {
    expect(formatNumber(null)).toBe('–');
    expect(formatNumber(undefined)).toBe('–');
  });

  it('is never further off than half of the last digit asked for', () => {
    const random = randomFrom(1);
    for (let i = 0; i < 20000; ++i) {
      const value = (random() - 0.5) * 10 ** (random() * 24 - 12);
      const digits = 2 + Math.floor(random() * 5);
      const read = Number(formatNumber(value, digits).replaceAll('−', '-'));
      const bound = 0.5 * 10 ** (Math.floor(Math.log10(Math.abs(value))) + 1 - digits);
      expect(Math.abs(read - value)).toBeLessThanOrEqual(bound * (1 + 1e-9));
    }
  });
});

describe('formatExact', () => {
  it.each([
    [Math.fround(0.1), '0.1'],
    [0.1, '0.1'],
    [Math.fround(7.6e-5), '7.6e-05'],
    [4294967295, '4294967295'],
    [150000000, '150000000'],
    [Math.fround(393.15), '393.15'],
    [-1.5, '-1.5'],
    [0, '0'],
    [1e-6, '1e-06'],
  ])('writes %d as %s', (value, text) => expect(formatExact(value)).toBe(text));

  it('reads back as the same float, and in no more than nine digits', () => {
    const random = randomFrom(2);
    for (let i = 0; i < 20000; ++i) {
      const value = Math.fround((random() - 0.5) * 10 ** (random() * 40 - 20));
      const text = formatExact(value);
      expect(Math.fround(Number(text))).toBe(value);
      if (Math.abs(value) < 1e7) {
        const digits = text.replace(/e.*/, '').replace(/[-.]/g, '').replace(/^0+/, '').length;
        expect(digits).toBeLessThanOrEqual(9);
      }
    }
  });

  it('reads back as the same double', () => {
    const random = randomFrom(3);
    for (let i = 0; i < 5000; ++i) {
      const value = (random() - 0.5) * 10 ** (random() * 40 - 20);
      expect(Number(formatExact(value))).toBe(value);
    }
  });
});

describe('formatTicks', () => {
  it('gives all ticks the same decimals', () => {
    expect(formatTicks([0, 0.25, 0.5], 0.25)).toEqual(['0.00', '0.25', '0.50']);
    expect(formatTicks([-0.1, 0, 0.1], 0.1)).toEqual(['−0.1', '0.0', '0.1']);
    expect(formatTicks([0, 20, 40], 20)).toEqual(['0', '20', '40']);
    expect(formatTicks([-1e-17, 1e-4, 2e-4], 1e-4)).toEqual(['0', '0.0001', '0.0002']);
  });
  it('tells neighbours apart', () => {
    const random = randomFrom(4);
    for (let i = 0; i < 2000; ++i) {
      const step = [1, 2, 2.5, 5][Math.floor(random() * 4)]! * 10 ** Math.floor(random() * 8 - 5);
      const first = Math.round((random() - 0.5) * 100) * step;
      const ticks = Array.from({ length: 6 }, (_, k) => first + k * step);
      expect(new Set(formatTicks(ticks, step)).size).toBe(6);
    }
  });
});

describe('times', () => {
  it('writes a time of day with the decimals of the step', () => {
    const time_s = new Date(2026, 0, 2, 3, 4, 5).getTime() / 1000;
    expect(formatClock(time_s)).toBe('03:04:05');
    expect(formatClock(time_s + 0.25, 0.05)).toBe('03:04:05.25');
    expect(formatClock(time_s + 7.5, 0.1)).toBe('03:04:12.5');
    expect(formatClock(time_s + 0.9999, 1)).toBe('03:04:05');
  });
  it('writes durations in words', () => {
    expect([5.2, 60, 185, 3600, 7300].map(formatDuration)).toEqual(['5 s', '1 min', '3 min 5 s', '1 h', '2 h 2 min']);
  });
});
