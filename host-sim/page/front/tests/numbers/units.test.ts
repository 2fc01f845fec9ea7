import { describe, expect, it } from 'vitest';
import { fromShown, type Quantity, quantityText, scaleOf, toShown } from '../../src/numbers/units';
import { randomFrom } from '../random';

const all: Quantity[] = [
  'K',
  'difference_K',
  'Pa',
  'A',
  'W',
  'm',
  'wire_m',
  'm_s',
  'ohm',
  'V',
  'N',
  'share',
  'response_s',
];

describe('quantities', () => {
  it('are read in the units of the choice', () => {
    const read = (quantity: Quantity, value: number): string[] => [
      quantityText(quantity, value, 'bench'),
      quantityText(quantity, value, 'si'),
    ];
    expect(read('K', 393.15)).toEqual(['120 °C', '393.1 K']);
    expect(read('difference_K', 18)).toEqual(['18 K', '18 K']);
    expect(read('Pa', 150e6)).toEqual(['150 MPa', '1.5e+08 Pa']);
    expect(read('A', 0.1)).toEqual(['100 mA', '0.1 A']);
    expect(read('m', 76e-6)).toEqual(['76 µm', '7.6e-05 m']);
    expect(read('wire_m', 0.1)).toEqual(['100 mm', '0.1 m']);
    expect(read('share', 0.04)).toEqual(['4 %', '0.04']);
    expect(read('response_s', 0.12)).toEqual(['120 ms', '0.12 s']);
  });

  it('are degrees Celsius also where kelvins come as floats of 32 bits', () => {
    expect(quantityText('K', 273.15, 'bench')).toBe('0 °C');
    expect(quantityText('K', Math.fround(273.15), 'bench')).toBe('0 °C');
    expect(quantityText('K', Math.fround(393.15), 'bench')).toBe('120 °C');
    expect(quantityText('K', 253.15, 'bench')).toBe('−20 °C');
    expect(quantityText('K', NaN, 'bench')).toBe('– °C');
  });

  it('come back from what is shown', () => {
    const random = randomFrom(50);
    for (const quantity of all) {
      for (const units of ['bench', 'si'] as const) {
        const scale = scaleOf(quantity, units);
        for (let i = 0; i < 200; ++i) {
          // Of temperatures those that a wire can have, to the 0.1 mK in which they are shown.
          const value = quantity === 'K' ? Math.round(1e4 * (200 + 400 * random())) / 1e4 : (random() - 0.5) * 1e3;
          expect(fromShown(scale, toShown(scale, value)) / value).toBeCloseTo(1, 10);
        }
      }
    }
  });
});
