import { expect, test } from 'vitest';
import { celsius, formatCelsius } from '../../src/numbers/temperature';

test('kelvins are read as degrees Celsius, also where they come as floats of 32 bits', () => {
  expect(celsius(273.15)).toBe(0);
  expect(formatCelsius(Math.fround(273.15))).toBe('0 °C');
  expect(formatCelsius(Math.fround(393.15))).toBe('120 °C');
  expect(formatCelsius(253.15)).toBe('−20 °C');
  expect(formatCelsius(361.25, 3)).toBe('88.1 °C');
  expect(formatCelsius(NaN)).toBe('– °C');
});
