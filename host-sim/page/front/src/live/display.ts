// How quantities are shown to a person: °C, MPa, mA, µm and % where the bus has SI units.

import { formatNumber } from '../numbers/format';
import { zero_degC_K } from '../numbers/temperature';
import type { Role } from '../plot/theme';
import { controlled } from './feed';

export interface Shown {
  unit: string;
  factor: number;
  offset: number;
  smallest?: number; ///< shortest range of an axis, in that unit: what is less is noise
}

const units: Record<string, Shown> = {
  K: { unit: '°C', factor: 1, offset: -zero_degC_K, smallest: 2 },
  Pa: { unit: 'MPa', factor: 1e-6, offset: 0, smallest: 1 },
  A: { unit: 'mA', factor: 1e3, offset: 0, smallest: 1 },
  W: { unit: 'mW', factor: 1e3, offset: 0, smallest: 1 },
  m: { unit: 'µm', factor: 1e6, offset: 0, smallest: 10 },
  'm/s': { unit: 'mm/s', factor: 1e3, offset: 0, smallest: 0.1 },
  m_s: { unit: 'mm/s', factor: 1e3, offset: 0, smallest: 0.1 },
  ohm: { unit: 'Ω', factor: 1, offset: 0, smallest: 0.02 },
  V: { unit: 'V', factor: 1, offset: 0, smallest: 0.1 },
  N: { unit: 'N', factor: 1, offset: 0, smallest: 0.1 },
};

const special: Record<string, Shown> = Object.fromEntries(
  [
    'strain',
    'strain_sd',
    'strain_low',
    'strain_high',
    'setpoint_strain',
    'reference_strain',
    'contraction',
    'martensite',
    'r_phase',
    'austenite',
    'cooling',
  ].map((name) => [name, { unit: '%', factor: 100, offset: 0, smallest: 0.1 }]),
);

/** A difference of temperatures has no offset. */
export function shownAs(signal: string): Shown {
  const named = special[signal];
  if (named) {
    return named;
  }
  const difference = signal.startsWith('error:');
  const unit = unitOf(signal);
  const shown = units[unit] ?? { unit, factor: 1, offset: 0 };
  if (difference && unit === 'K') {
    return { ...shown, unit: 'K', offset: 0 };
  }
  return shown;
}

/** Set-point and reference are in the unit of what a mode controls. */
export function shownIn(mode: number, signal: string): Shown {
  const follows = signal === 'setpoint' || signal === 'reference';
  return shownAs((follows ? controlled(mode) : null) ?? signal);
}

/** The unit that ends a name. */
export function unitOf(signal: string): string {
  if (signal.endsWith('_m_s')) {
    return 'm_s';
  }
  const end = signal.slice(signal.lastIndexOf('_') + 1);
  return end in units ? end : '';
}

const labels: Record<string, [string, Role]> = {
  strain: ['estimate', 'estimate'],
  strain_sd: ['σ of the estimate', 'band'],
  reference_strain: ['reference', 'reference'],
  setpoint_strain: ['set-point', 'setpoint'],
  contraction: ['contraction', 'estimate'],
  wire_temperature_K: ['wire', 'temperature'],
  hot_spot_K: ['hot spot', 'hot_spot'],
  estimated_ambient_K: ['ambient', 'ambient'],
  martensite: ['martensite', 'martensite'],
  r_phase: ['R-phase', 'r_phase'],
  austenite: ['austenite', 'austenite'],
  resistance_ohm: ['measured', 'measured'],
  resistance_model_ohm: ['expected', 'model'],
  resistance_difference_ohm: ['measured − expected', 'error'],
  stress_Pa: ['stress', 'stress'],
  power_W: ['measured', 'power'],
  wanted_power_W: ['wanted', 'wanted'],
  drive_current_A: ['given', 'current'],
  current_A: ['measured', 'measured'],
  voltage_V: ['voltage reading', 'other3'],
  drive_voltage_V: ['voltage given', 'other7'],
  supply_V: ['supply', 'other5'],
  setpoint: ['set-point', 'setpoint'],
  reference: ['reference', 'reference'],
  position_m: ['position', 'estimate'],
  velocity_m_s: ['velocity', 'other4'],
  force_N: ['force', 'stress'],
  cooling: ['cooling', 'other6'],
};

/** `limits.hot_spot_K` in words, wherever a hot spot is shown; NaN where it was not read. */
export function hotSpotText(margin_K: number): string {
  const margin = Number.isNaN(margin_K) ? 'a fixed margin' : `a fixed margin of ${formatNumber(margin_K)} K`;
  return (
    `The hot spot is the estimated temperature of the wire plus ${margin} (limits.hot_spot_K), because the ` +
    'hottest place of the wire is not measured. The servo adds the margin to a cold wire as well.'
  );
}

/** The same in a legend. */
export function hotSpotLabel(margin_K: number): string {
  return Number.isNaN(margin_K) ? 'hot spot' : `hot spot (wire + ${formatNumber(margin_K)} K)`;
}

export function labelOf(signal: string): string {
  return labels[signal]?.[0] ?? plain(signal);
}

export function roleOf(signal: string, n = 0): Role {
  return labels[signal]?.[1] ?? (`other${(n % 8) + 1}` as Role);
}

/** A name of the bus as words: `resistance_model_ohm` is `resistance model`. */
const words: Record<string, string> = {
  current_A: 'current reading',
  voltage_V: 'voltage reading',
  r_phase: 'R-phase',
  strain_sd: 'strain σ',
  setpoint: 'set-point',
  supply_V: 'supply',
  resistance_model_ohm: 'expected resistance',
};

export function plain(signal: string): string {
  const known = words[signal];
  if (known) {
    return known;
  }
  const unit = unitOf(signal);
  const bare = signal.replace(/^[a-z]+:/, '');
  return (unit ? bare.replace(new RegExp(`_${unit}$`), '') : bare).replaceAll('_', ' ');
}
