// Values of parameters as text, and back, with the reason where a text is refused before it is sent. A person
// reads and writes them in the chosen units; values are in SI, as they are sent.

import { formatExact } from '../numbers/format';
import { tidy, type Units, withUnit } from '../numbers/units';
import type { ParameterInfo, ParameterUnit, Value } from '../protocol/bridge';

export type Parsed = { value: Value } | { refused: string };

/** Units of the bench, as names of parameters end in them; a parameter has one of them at most. */
const benchUnits = ['degC', 'MPa', 'mA', 'mW', 'um', 'K_MPa'];
const long_m = 1; // a length that may be longer is in mm
/** Strains, and what is compared with a strain or with the length of the wire. Other numbers are factors. */
const inPercent = /strain$|\.nominal_stroke$|^strain\.dead_band$|^trips\.following_error$/;

/** The unit in which a value is shown and typed: one of those that the servo's tools take. */
export function unitOf(parameter: ParameterInfo, choice: Units): ParameterUnit {
  const si = { unit: parameter.unit, factor: 1, offset: 0 };
  if (choice === 'si') {
    return si;
  }
  const wanted = (one: ParameterUnit): boolean => {
    if (one.unit === 'percent') {
      return inPercent.test(parameter.name);
    }
    if (one.unit === 'mm' || one.unit === 'um') {
      return (one.unit === 'mm') === (parameter.max !== null && parameter.max > long_m);
    }
    return benchUnits.includes(one.unit);
  };
  return parameter.units?.find(wanted) ?? si;
}

/** The name with the unit in which the value is shown: limits.temperature_degC. host-sim takes it as well. */
export function shownName(parameter: ParameterInfo, choice: Units): string {
  const { unit } = unitOf(parameter, choice);
  if (unit === parameter.unit) {
    return parameter.name;
  }
  const bare = parameter.unit ? parameter.name.slice(0, -parameter.unit.length - 1) : parameter.name;
  return `${bare}_${unit}`;
}

/** A text in which parameters have the names under which they are shown. */
export function withShownNames(text: string, infos: ReadonlyMap<string, ParameterInfo>, choice: Units): string {
  return text.replace(/\w+(\.\w+)+/g, (name) => {
    const info = infos.get(name);
    return info ? shownName(info, choice) : name;
  });
}

/** In SI. */
export function valueText(value: Value | null | undefined): string {
  if (value === null || value === undefined) {
    return '';
  }
  return typeof value === 'number' ? formatExact(value) : String(value);
}

/** As it is edited: the shortest text that gives the same float of 32 bits again. */
export function editText(parameter: ParameterInfo, value: Value | null | undefined, choice: Units): string {
  const unit = unitOf(parameter, choice);
  if (typeof value !== 'number' || !Number.isFinite(value) || unit.unit === parameter.unit) {
    return valueText(value);
  }
  const shown = (value - unit.offset) / unit.factor;
  const same = (text: string): boolean => Math.fround(toSi(unit, Number(text))) === Math.fround(value);
  for (let digits = 0; digits <= 15; ++digits) {
    // Of a temperature the decimals count: 273.15 K is 0 °C and not 6e-14.
    const text = unit.offset !== 0 ? shown.toFixed(digits) : shown.toPrecision(digits + 1);
    if (same(text)) {
      return formatExact(Number(text) || 0); // no −0
    }
  }
  return formatExact(shown);
}

function toSi({ factor, offset }: ParameterUnit, shown: number): number {
  return tidy(factor * shown + offset);
}

/** As it is read, with its unit. */
export function readText(parameter: ParameterInfo | undefined, value: Value | null | undefined, choice: Units): string {
  if (!parameter) {
    return valueText(value);
  }
  const text = editText(parameter, value, choice).replace(/^-/, '−');
  return typeof value === 'number' ? withUnit(text, unitText(unitOf(parameter, choice).unit)) : text;
}

/** A unit as it is written: 1/s where names have 1_s, Ω m where they have ohm_m. */
export function unitText(unit: string): string {
  switch (unit) {
    case 'degC':
      return '°C';
    case 'um':
      return 'µm';
    case 'percent':
      return '%';
    default:
      return unit
        .replace(/^ohm_m(?=_|$)/, 'Ω m')
        .replace(/ohm/g, 'Ω')
        .replaceAll('_', '/')
        .replace(/([A-Za-z])2$/, '$1²');
  }
}

export function rangeText(parameter: ParameterInfo, choice: Units): string {
  if (parameter.type === 'boolean') {
    return 'true, false';
  }
  if (parameter.type === 'choice') {
    return (parameter.choices ?? []).join(', ');
  }
  const { min, max } = parameter;
  const read = (value: number): string => readText(parameter, value, choice);
  if (min !== null && max !== null) {
    return `${editText(parameter, min, choice).replace(/^-/, '−')} to ${read(max)}`;
  }
  if (min !== null) {
    return `at least ${read(min)}`;
  }
  return max === null ? '' : `at most ${read(max)}`;
}

/** The value in SI. The servo has the last word; this says at once what it would refuse anyway. */
export function parseValue(parameter: ParameterInfo, text: string, choice: Units): Parsed {
  const written = text.trim();
  const refused = (what: string): Parsed => ({ refused: `${what}; allowed: ${rangeText(parameter, choice)}` });
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
      const value = writtenValue(parameter, written, choice);
      if (value === null) {
        return refused(written === '' ? 'a number is missing' : `"${written}" is not a number`);
      }
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

/** Of a number that may be out of range; null where it is none. */
function writtenValue(parameter: ParameterInfo, text: string, choice: Units): number | null {
  if (!/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(text)) {
    return null;
  }
  const unit = unitOf(parameter, choice);
  return unit.unit === parameter.unit ? Number(text) : toSi(unit, Number(text));
}

/** A text that was typed in units of `from`, in those of `to`. */
export function convertText(parameter: ParameterInfo, text: string, from: Units, to: Units): string {
  const value = from === to ? null : writtenValue(parameter, text.trim(), from);
  return value === null ? text : editText(parameter, value, to);
}
