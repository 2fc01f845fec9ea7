// Values of parameters as text, and back, with the reason where a text is refused before it is sent.

import { formatExact } from '../numbers/format';
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
    return `${valueText(min)} to ${valueText(max)}${behind}`;
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

/** A second reading for those who do not think in SI: 393.15 K is 120 °C, 1.5e+08 Pa is 150 MPa. */
export function alsoText(unit: string, value: Value | null | undefined, name = ''): string {
  if (typeof value !== 'number') {
    return '';
  }
  const round = (shown: number): string => String(Number(shown.toPrecision(6)));
  if (unit === 'K' && !isDifference(name) && value > 150) {
    return `${round(celsius(value))} °C`;
  }
  if (unit === 'Pa' && Math.abs(value) >= 1e5) {
    return `${round(value / 1e6)} MPa`;
  }
  if (unit === 'm' && value !== 0 && Math.abs(value) < 1) {
    return `${round(value * 1e3)} mm`;
  }
  return '';
}

function isDifference(name: string): boolean {
  return /(hot_spot|overheat|_sd|reversal|dead_band)/.test(name);
}
