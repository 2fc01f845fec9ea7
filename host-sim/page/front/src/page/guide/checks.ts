// What the guide can say of a servo's settings, from what was read and nothing else.

import { formatNumber } from '../../numbers/format';
import { type Quantity, quantityText, type Units } from '../../numbers/units';
import type { Value } from '../../protocol/bridge';

export interface Check {
  ok: boolean | null; ///< null: cannot be judged, as something was not read
  text: string;
}

export type Settings = Record<string, Value>;

function number(settings: Settings, name: string): number {
  const value = settings[name];
  return typeof value === 'number' ? value : NaN;
}

function judged(condition: boolean, parts: number[], text: string): Check {
  return { ok: parts.some(Number.isNaN) ? null : condition, text };
}

/** Temperature at which the wire has contracted, at a stress. */
export function finish_K(settings: Settings, stress_Pa: number): number {
  const of = (power: string): number => number(settings, `wire.m2a.finish_${power}`);
  return of('0_K') + of('1_K_Pa') * stress_Pa + of('2_K_Pa2') * stress_Pa ** 2;
}

/** Of the wire when cold: martensite without stress, as the wire's parameters have it. */
export function cold_ohm(settings: Settings): number {
  const diameter = number(settings, 'wire.diameter_m');
  return (
    (number(settings, 'wire.martensite.resistivity_ohm_m') * number(settings, 'wire.length_m')) /
    ((Math.PI / 4) * diameter ** 2)
  );
}

export function stroke_m(settings: Settings): number {
  return number(settings, 'wire.nominal_stroke') * number(settings, 'wire.length_m');
}

function densityText(density_A_m2: number, units: Units): string {
  return units === 'bench' ? `${formatNumber(density_A_m2 / 1e6)} A/mm²` : `${formatNumber(density_A_m2)} A/m²`;
}

/** Limits against trips, and both against the wire, in these units. `stress_Pa` is the measured one. */
export function limitChecks(settings: Settings, stress_Pa: number, units: Units): Check[] {
  const text = (quantity: Quantity, value: number): string => quantityText(quantity, value, units);
  const of = (name: string): number => number(settings, name);
  const current = of('limits.current_A');
  const trip = of('trips.current_A');
  const hottest = of('limits.temperature_K');
  const tripHottest = of('trips.temperature_K');
  const stress = of('limits.stress_Pa');
  const tripStress = of('trips.stress_Pa');
  const finish = finish_K(settings, stress_Pa);
  const area = (Math.PI / 4) * of('wire.diameter_m') ** 2;
  const density = current / area;
  return [
    judged(
      current < trip,
      [current, trip],
      `limits.current_A is ${text('A', current)}, below the trip at ${text('A', trip)}.`,
    ),
    judged(
      hottest < tripHottest,
      [hottest, tripHottest],
      `limits.temperature_K is ${text('K', hottest)}, below the trip at ${text('K', tripHottest)}.`,
    ),
    judged(
      hottest > finish,
      [hottest, finish],
      `At the measured ${text('Pa', stress_Pa)} this wire has contracted at ${text('K', finish)}; the limit must be above.`,
    ),
    judged(
      stress < tripStress,
      [stress, tripStress],
      `limits.stress_Pa is ${text('Pa', stress)}, below the trip at ${text('Pa', tripStress)}.`,
    ),
    judged(
      stress_Pa < stress,
      [stress_Pa, stress],
      `The measured stress is ${text('Pa', stress_Pa)}, below the limit of ${text('Pa', stress)}.`,
    ),
    judged(
      of('limits.min_strain') < of('axis.zero_strain'),
      [of('limits.min_strain'), of('axis.zero_strain')],
      `Strain may go from ${text('share', of('axis.zero_strain'))} at position 0 down to ` +
        `${text('share', of('limits.min_strain'))}.`,
    ),
    {
      ok: null,
      text:
        `The limit of the current is ${densityText(density, units)} in this wire. The maker's data ` +
        'sheet says what it bears; the page cannot judge it.',
    },
  ].filter((check) => !check.text.includes('–') || check.ok === null);
}

export interface Statistics {
  mean: number;
  sd: number;
  count: number;
}

export function statistics(samples: readonly number[]): Statistics {
  const good = samples.filter((value) => Number.isFinite(value));
  const mean = good.reduce((sum, value) => sum + value, 0) / good.length;
  const squares = good.reduce((sum, value) => sum + (value - mean) ** 2, 0);
  return { mean, sd: Math.sqrt(squares / Math.max(1, good.length - 1)), count: good.length };
}
