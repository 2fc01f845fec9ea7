import { describe, expect, it, test } from 'vitest';
import { formatTicks } from '../../src/numbers/format';
import { axisSize, endRoom, endSize, leftSize, niceRange, niceStep, rightSize } from '../../src/plot/axes';
import { randomFrom } from '../random';

const width_px = 7.7; // of the widest digit of the fonts that systems have for `system-ui`, 12 px high
const widthOf = (text: string): number => width_px * text.length;
const edges_px = 8; // tick and gap between a label and its axis

/** Ticks as uPlot has them: at least `apart` pixels from each other, at multiples of 1, 2, 2.5 or 5 times a decade. */
function ticksOf([low, high]: [number, number], height: number, apart = 26): { ticks: number[]; step: number } {
  const least = ((high - low) * apart) / height;
  const decade = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 2.5, 5, 10].map((part) => part * decade).find((one) => one >= least * (1 - 1e-9))!;
  const ticks: number[] = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) {
    ticks.push(k * step);
  }
  return { ticks, step };
}

function labelsOf(range: [number, number], height = 160): string[] {
  const { ticks, step } = ticksOf(range, height);
  return formatTicks(ticks, step);
}

/** Ranges of data as servos and reports have them: zeros, constants, noise, wide ones, of all sizes. */
function* ranges(): Generator<[number, number, number]> {
  const random = randomFrom(50);
  for (const smallest of [0, 0.02, 0.1, 1, 10]) {
    for (const value of [0, -0, 1e-17, 1e-12, -1e-12, 1e-6, 0.25, 25, -114.9, 393.15, 1013.25, 1e6, -1e6, 1e9]) {
      yield [value, value, smallest];
    }
    for (let i = 0; i < 1000; ++i) {
      const middle = (random() - 0.5) * 10 ** (random() * 24 - 12);
      const width = random() * 10 ** (random() * 24 - 12);
      yield [middle - width / 2, middle + width / 2, smallest];
    }
  }
}

describe('the labels of an axis', () => {
  it('fit its width, whatever is drawn', () => {
    for (const [low, high, smallest] of ranges()) {
      for (const least of [leftSize, rightSize]) {
        const labels = labelsOf(niceRange(low, high, smallest), 110 + least);
        const longest = Math.max(...labels.map((text) => text.length));
        expect(width_px * longest + edges_px).toBeLessThanOrEqual(axisSize(labels, least, widthOf));
        // A minus, a point, an exponent, and five digits of which neighbours share the first four.
        expect(longest).toBeLessThanOrEqual(13);
      }
    }
  });

  it('differ from each other, and are few but more than one', () => {
    for (const [low, high, smallest] of ranges()) {
      const labels = labelsOf(niceRange(low, high, smallest));
      expect(new Set(labels).size).toBe(labels.length);
      expect(labels.length).toBeGreaterThan(1);
      expect(labels.length).toBeLessThan(9);
    }
  });

  it('need no more than the usual width where the data are as large as those of a servo', () => {
    for (const value of [0, 0.02, 1, 25, 43, 120, 400]) {
      for (const smallest of [0, 1, 10]) {
        const size = axisSize(labelsOf(niceRange(value, value, smallest)), leftSize, (text) => 6.6 * text.length);
        expect(size).toBe(leftSize);
      }
    }
  });

  it('have the room of half of one at the end of the horizontal axis', () => {
    expect(endRoom([], widthOf)).toBe(endSize);
    expect(endRoom(['0', '0.5', '1'], widthOf)).toBe(endSize);
    expect(endRoom(['14:03:07.25'], widthOf)).toBeGreaterThanOrEqual((11 * width_px) / 2);
  });
});

describe('niceRange', () => {
  it('holds the data, and is as long as it was told at least', () => {
    for (const [low, high, smallest] of ranges()) {
      const [from, to] = niceRange(low, high, smallest);
      const spare = 1e-9 * (to - from);
      expect(from - spare).toBeLessThanOrEqual(low);
      expect(to + spare).toBeGreaterThanOrEqual(high);
      expect(to - from).toBeGreaterThanOrEqual(smallest * (1 - 1e-9));
    }
  });

  test.each([
    [0, 0, 0, -0.6, 0.6],
    [3e-17, 3e-17, 0, -0.6, 0.6],
    [0, 0, 1, -0.6, 0.6],
    [0, 0, 10, -6, 6],
    [25, 25, 2, 23.8, 26.2],
    [100, 100, 0, 94, 106],
    [0, 5, 0, 0, 5.5],
    [NaN, NaN, 0, 0, 1],
  ])('of %d to %d with at least %d', (low, high, smallest, from, to) => {
    const range = niceRange(low, high, smallest);
    expect(range[0]).toBeCloseTo(from, 9);
    expect(range[1]).toBeCloseTo(to, 9);
  });

  it('has steps that are 1, 2 or 5 times a power of ten', () => {
    expect([0.11, 1, 1.1, 2.5, 7].map(niceStep)).toEqual([0.2, 1, 2, 5, 10]);
    expect(niceStep(0)).toBe(1);
  });
});
