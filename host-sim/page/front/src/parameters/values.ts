// Values of parameters as text, and back, with the reason where a text is refused before it is sent.

import { formatExact, formatNumber } from '../numbers/format';
import { celsius } from '../numbers/temperature';
import type { ParameterInfo, Value } from '../protocol/bridge';

export type Parsed = { value: Value } | { refused: string };

export function valueText(value: Value | null | undefined): string {
  if (value === null || value === undefined) {
    return '';
  }
  return typeof value === 'number' ? formatExact(value) : String(value);
}

/** A unit as it is written: 1/s where names have 1_s, Ω m where they have ohm_m. */
export function unitText(unit: string): string {
  return unit
    .replace(/^ohm_m(?=_|$)/, 'Ω m')
    .replace(/ohm/g, 'Ω')
    .replaceAll('_', '/')
    .replace(/([A-Za-z])2$/, '$1²');
}

export function rangeText(parameter: ParameterInfo): string {
  if (parameter.type === 'boolean') {
    return 'true, false';
  }
  if (parameter.type === 'choice') {
    return (parameter.choices ?? []).join(', ');
  }
  const { min, max, unit } = parameter;
  const behind = unit ? ` ${unitText(unit)}` : '';
  if (min !== null && max !== null) {
    const reading = readingOf(parameter);
    const also =
      reading?.suits(min) && reading.suits(max)
        ? ` (${formatNumber(reading.of(min), 6)} to ${formatNumber(reading.of(max), 6)} ${reading.unit})`
        : '';
    return `${valueText(min)} to ${valueText(max)}${behind}${also}`;
  }
  if (min !== null) {
    return `at least ${valueText(min)}${behind}`;
  }
  return max === null ? '' : `at most ${valueText(max)}${behind}`;
}

/** The servo has the last word; this says at once what it would refuse anyway. */
export function parseValue(parameter: ParameterInfo, text: string): Parsed {
  const written = text.trim();
  const refused = (what: string): Parsed => ({ refused: `${what}; allowed: ${rangeText(parameter)}` });
  switch (parameter.type) {
    case 'boolean':
      if (written === 'true') {
        return { value: true };
      }
      if (written === 'false') {
        return { value: false };
      }
      return refused(`"${written}" is neither true nor false`);
    case 'choice':
      return parameter.choices?.includes(written) ? { value: written } : refused(`"${written}" is no choice`);
    default: {
      if (!/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(written)) {
        return refused(written === '' ? 'a number is missing' : `"${written}" is not a number`);
      }
      const value = Number(written);
      if (parameter.type === 'integer' && !Number.isInteger(value)) {
        return refused(`${written} is not a whole number`);
      }
      // A bound is a float on the servo: 0.1 is not above a bound of 0.1.
      const size = Math.fround(value);
      if (parameter.min !== null && size < Math.fround(parameter.min)) {
        return refused(`${written} is too small`);
      }
      if (parameter.max !== null && size > Math.fround(parameter.max)) {
        return refused(`${written} is too large`);
      }
      return { value };
    }
  }
}

interface Reading {
  unit: string;
  of(value: number): number;
  suits(value: number): boolean;
}

const readings: Record<string, Reading> = {
  K: { unit: '°C', of: celsius, suits: () => true },
  Pa: { unit: 'MPa', of: (value) => value / 1e6, suits: (value) => Math.abs(value) >= 1e5 },
  m: { unit: 'mm', of: (value) => value * 1e3, suits: (value) => value !== 0 && Math.abs(value) < 1 },
};

const coldest_K = 100; // bound of a parameter that is a temperature; a difference of two may be smaller

function readingOf({ unit, min }: ParameterInfo): Reading | undefined {
  return unit === 'K' && !(min !== null && min >= coldest_K) ? undefined : readings[unit];
}

/** As those read it who do not think in SI: 120 °C for 393.15 K, 150 MPa for 1.5e+08 Pa; '' where it is the same. */
export function alsoText(parameter: ParameterInfo, value: Value | null | undefined): string {
  const reading = readingOf(parameter);
  return reading && typeof value === 'number' && reading.suits(value)
    ? `${formatNumber(reading.of(value), 6)} ${reading.unit}`
    : '';
}

/** A value as it is sent, and as it is read where that is something else: 393.15 (120 °C). */
export function bothTexts(parameter: ParameterInfo | undefined, value: Value | null | undefined): string {
  const also = parameter ? alsoText(parameter, value) : '';
  return also ? `${valueText(value)} (${also})` : valueText(value);
}
