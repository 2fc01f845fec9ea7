// The two choices of units in which a person reads quantities. On the bus and in messages all are in SI.

import { formatNumber } from './format';

/** bench: °C, MPa, mA, mW, µm, mm/s, %; si: K, Pa, A, W, m, m/s, 1. */
export type Units = 'bench' | 'si';

export const isUnits = (value: unknown): value is Units => value === 'bench' || value === 'si';

/** A scale: shown is factor * value + offset. */
export interface Shown {
  unit: string;
  factor: number;
  offset: number;
  smallest?: number; ///< shortest range of an axis, in that unit: what is less is noise
}

export const zero_degC_K = 273.15;

/** Kinds of quantities, by their unit of SI where one unit has one kind. */
export type Quantity =
  | 'K' // a temperature
  | 'difference_K' // of two temperatures: no offset
  | 'Pa'
  | 'A'
  | 'W'
  | 'm' // a way
  | 'wire_m' // the length of a wire, and the stroke that one is chosen for
  | 'm_s'
  | 'ohm'
  | 'V'
  | 'N'
  | 'N_m' // the rate of a spring
  | 'share' // a strain, a share of something
  | 'response_s'; // a time of a response

const bench: Record<Quantity, Shown> = {
  K: { unit: '°C', factor: 1, offset: -zero_degC_K, smallest: 2 },
  difference_K: { unit: 'K', factor: 1, offset: 0, smallest: 2 },
  Pa: { unit: 'MPa', factor: 1e-6, offset: 0, smallest: 1 },
  A: { unit: 'mA', factor: 1e3, offset: 0, smallest: 1 },
  W: { unit: 'mW', factor: 1e3, offset: 0, smallest: 1 },
  m: { unit: 'µm', factor: 1e6, offset: 0, smallest: 10 },
  wire_m: { unit: 'mm', factor: 1e3, offset: 0 },
  m_s: { unit: 'mm/s', factor: 1e3, offset: 0, smallest: 0.1 },
  ohm: { unit: 'Ω', factor: 1, offset: 0, smallest: 0.02 },
  V: { unit: 'V', factor: 1, offset: 0, smallest: 0.1 },
  N: { unit: 'N', factor: 1, offset: 0, smallest: 0.1 },
  N_m: { unit: 'N/mm', factor: 1e-3, offset: 0 },
  share: { unit: '%', factor: 100, offset: 0, smallest: 0.1 },
  response_s: { unit: 'ms', factor: 1e3, offset: 0 },
};

const units: Record<Quantity, string> = {
  K: 'K',
  difference_K: 'K',
  Pa: 'Pa',
  A: 'A',
  W: 'W',
  m: 'm',
  wire_m: 'm',
  m_s: 'm/s',
  ohm: 'Ω',
  V: 'V',
  N: 'N',
  N_m: 'N/m',
  share: '',
  response_s: 's',
};

export function scaleOf(quantity: Quantity, choice: Units): Shown {
  const { factor, smallest } = bench[quantity];
  if (choice === 'bench') {
    return bench[quantity];
  }
  return {
    unit: units[quantity],
    factor: 1,
    offset: 0,
    ...(smallest === undefined ? {} : { smallest: tidy(smallest / factor) }),
  };
}

/** Without the last digits, in which products of floating point differ: 0.0003 for 0.3 * 0.001. */
export function tidy(value: number): number {
  return Number.isFinite(value) ? Number(value.toPrecision(12)) : value;
}

/** A temperature to 0.1 mK, which is more than the bus has: 273.15 K is 0 °C, also as a float of 32 bits. */
export function toShown({ factor, offset }: Shown, value: number): number {
  return offset === 0 ? factor * value : Math.round((factor * value + offset) * 1e4) / 1e4;
}

export function fromShown({ factor, offset }: Shown, shown: number): number {
  return tidy((shown - offset) / factor);
}

/** 393.15 as 120 °C, or as 393.2 K. */
export function quantityText(quantity: Quantity, value: number, choice: Units, digits = 4): string {
  const scale = scaleOf(quantity, choice);
  return withUnit(formatNumber(toShown(scale, value), digits), scale.unit);
}

export function withUnit(text: string, unit: string): string {
  return unit ? `${text} ${unit}` : text;
}
