// How signals are shown to a person, in the chosen units.

import { formatNumber } from '../numbers/format';
import { type Quantity, scaleOf, type Shown, type Units } from '../numbers/units';
import type { Role } from '../plot/theme';
import { controlled } from './feed';

const ends = ['K', 'Pa', 'A', 'W', 'm_s', 'm', 'ohm', 'V', 'N'] as const satisfies readonly Quantity[];

const shares = [
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
];

/** What a signal is; null: a number without a unit. An error of a temperature is a difference. */
function quantityOf(signal: string): Quantity | null {
  if (shares.includes(signal)) {
    return 'share';
  }
  const unit = unitOf(signal);
  return unit === 'K' && signal.startsWith('error:') ? 'difference_K' : unit || null;
}

export function shownAs(signal: string, units: Units): Shown {
  const quantity = quantityOf(signal);
  return quantity === null ? { unit: '', factor: 1, offset: 0 } : scaleOf(quantity, units);
}

/** Set-point and reference are in the unit of what a mode controls. */
export function shownIn(mode: number, signal: string, units: Units): Shown {
  const follows = signal === 'setpoint' || signal === 'reference';
  return shownAs((follows ? controlled(mode) : null) ?? signal, units);
}

/** The unit that ends a name. */
export function unitOf(signal: string): (typeof ends)[number] | '' {
  return ends.find((unit) => signal.endsWith(`_${unit}`)) ?? '';
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
