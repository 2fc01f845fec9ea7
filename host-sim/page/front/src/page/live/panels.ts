// The plots of the live view: what each shows, and how they are arranged.

import { signal } from '@preact/signals';
import { hotSpotLabel, labelOf, plain, roleOf, shownAs, shownIn } from '../../live/display';
import { controlled } from '../../live/feed';
import type { SeriesSpec } from '../../plot/time_plot';
import { isObject, read, saved } from '../../session/saved';

export interface TimePanel {
  kind: 'time';
  id: string;
  title: string;
  unit?: string;
  series: SeriesSpec[];
  limits?: boolean; ///< shows which limits act
}
export interface LoopPanel {
  kind: 'loop';
  id: string;
  title: string;
  unit: string;
  x: string;
  y: string;
  xLabel: string;
  smallest: [number, number];
}
export type Panel = TimePanel | LoopPanel;

export interface Place {
  id: string;
  shown: boolean;
  half: boolean; ///< beside another one where there is room
}

/** A plot that somebody has put together. */
export interface OwnPanel {
  id: string;
  title: string;
  left: string[];
  right: string[];
}

function series(name: string, more: Partial<SeriesSpec> = {}): SeriesSpec {
  const shown = shownAs(name);
  return {
    key: name,
    label: labelOf(name),
    role: roleOf(name),
    factor: shown.factor,
    offset: shown.offset,
    smallest: shown.smallest,
    ...more,
  };
}

const percent = { factor: 100 };

const fixed: Panel[] = [
  {
    kind: 'time',
    id: 'strain',
    title: 'Strain',
    unit: '%',
    series: [
      { key: 'band', label: '±2σ', role: 'band', style: 'band', low: 'strain_low', high: 'strain_high', ...percent },
      series('setpoint_strain', { style: 'steps' }),
      series('reference_strain', { style: 'dashed' }),
      series('strain', { width: 2 }),
    ],
  },
  {
    kind: 'time',
    id: 'power',
    title: 'Power',
    unit: 'mW',
    limits: true,
    series: [
      series('wanted_power_W', { style: 'dashed' }),
      series('power_W'),
      series('drive_current_A', { axis: 'right', unit: 'mA', label: 'current' }),
    ],
  },
  {
    kind: 'loop',
    id: 'strain-resistance',
    title: 'Strain over resistance',
    unit: '%',
    x: 'resistance_ohm',
    y: 'strain',
    xLabel: 'resistance in Ω',
    smallest: [0.1, 0.1],
  },
  {
    kind: 'loop',
    id: 'strain-temperature',
    title: 'Strain over temperature',
    unit: '%',
    x: 'wire_temperature_K',
    y: 'strain',
    xLabel: 'temperature in °C',
    smallest: [2, 0.1],
  },
  {
    kind: 'time',
    id: 'temperature',
    title: 'Temperature',
    unit: '°C',
    series: [series('estimated_ambient_K', { hidden: true }), series('hot_spot_K'), series('wire_temperature_K')],
  },
  {
    kind: 'time',
    id: 'resistance',
    title: 'Resistance',
    unit: 'Ω',
    series: [series('resistance_ohm'), series('resistance_model_ohm', { style: 'dashed' })],
  },
  {
    kind: 'time',
    id: 'phases',
    title: 'Phases',
    series: [
      { key: 'martensite', label: 'martensite', role: 'martensite', style: 'stack' },
      { key: 'r_phase', label: 'R-phase', role: 'r_phase', style: 'stack' },
      { key: 'austenite', label: 'austenite', role: 'austenite', style: 'stack' },
    ],
  },
  {
    kind: 'time',
    id: 'current',
    title: 'Current',
    unit: 'mA',
    limits: true,
    series: [series('current_A'), series('drive_current_A', { style: 'dashed' })],
  },
  {
    kind: 'time',
    id: 'position',
    title: 'Position',
    unit: 'µm',
    series: [series('position_m')],
  },
  { kind: 'time', id: 'stress', title: 'Stress', unit: 'MPa', series: [series('stress_Pa')] },
];

/** Set-point less measured value, in the unit of the mode. */
function errorPanel(mode: number): TimePanel {
  const variable = controlled(mode) ?? 'position_m';
  const name = `error:${variable}`;
  const shown = shownAs(name);
  return {
    kind: 'time',
    id: 'error',
    title: 'Error',
    unit: shown.unit,
    series: [
      series(name, {
        label: `set-point − ${plain(variable)}`,
        role: 'error',
        smallest: (shown.smallest ?? 0) / 10, // looked at more closely than the quantity itself
      }),
    ],
  };
}

/** With the margin of the hot spot in its label. */
function explained(panel: Panel, margin_K: number): Panel {
  if (panel.id !== 'temperature' || panel.kind !== 'time') {
    return panel;
  }
  const label = hotSpotLabel(margin_K);
  return { ...panel, series: panel.series.map((one) => (one.key === 'hot_spot_K' ? { ...one, label } : one)) };
}

export function panels(mode: number, own: readonly OwnPanel[], hotSpotMargin_K: number): Panel[] {
  const all = fixed.map((panel) => explained(panel, hotSpotMargin_K));
  all.splice(2, 0, errorPanel(mode));
  return [...all, ...own.map((one) => ownPanel(one, mode))];
}

function ownPanel(own: OwnPanel, mode: number): TimePanel {
  const unit = own.left[0] ? shownIn(mode, own.left[0]).unit : '';
  const made = (name: string, n: number, axis: 'left' | 'right'): SeriesSpec => {
    const shown = shownIn(mode, name);
    const other = axis === 'right' || shown.unit !== unit ? { unit: shown.unit } : {};
    return series(name, {
      label: plain(name),
      role: `other${(n % 8) + 1}` as SeriesSpec['role'],
      axis,
      factor: shown.factor,
      offset: shown.offset,
      smallest: shown.smallest,
      ...other,
    });
  };
  return {
    kind: 'time',
    id: own.id,
    title: own.title,
    unit,
    series: [
      ...own.left.map((name, n) => made(name, n, 'left')),
      ...own.right.map((name, n) => made(name, n + own.left.length, 'right')),
    ],
  };
}

const shownFirst = [
  'strain',
  'power',
  'strain-resistance',
  'strain-temperature',
  'temperature',
  'resistance',
  'phases',
  'error',
];

const initial: Place[] = [
  ...shownFirst.map((id) => ({ id, shown: true, half: id.startsWith('strain-') })),
  ...['current', 'position', 'stress'].map((id) => ({ id, shown: false, half: false })),
];

const isPlaces = (value: unknown): value is Place[] =>
  Array.isArray(value) && value.every((place) => isObject(place) && typeof place['id'] === 'string');
const isOwn = (value: unknown): value is OwnPanel[] =>
  Array.isArray(value) &&
  value.every((one) => isObject(one) && Array.isArray(one['left']) && Array.isArray(one['right']));

const kept = saved<Place[]>('plots', initial, isPlaces);

/** Plots that were kept when these signals had other names. */
const renamed: Record<string, string> = {
  temperature_K: 'wire_temperature_K',
  ambient_K: 'estimated_ambient_K',
  current_A: 'drive_current_A',
  voltage_V: 'drive_voltage_V',
  measured_A: 'current_A',
  measured_V: 'voltage_V',
};
const withTheirNames = (names: string[]): string[] => names.map((name) => renamed[name] ?? name);
const keptBefore = read<OwnPanel[]>('own-plots', [], isOwn).map((one) => ({
  ...one,
  left: withTheirNames(one.left),
  right: withTheirNames(one.right),
}));
export const ownPanels = saved<OwnPanel[]>('own-panels', keptBefore, isOwn);
export const arranging = signal(false);

/** In order, with those that a newer page has and the kept arrangement has not. */
export function places(all: readonly Panel[]): Place[] {
  const known = kept.value.filter((place) => all.some((panel) => panel.id === place.id));
  const fresh = all.filter((panel) => !known.some((place) => place.id === panel.id));
  return [...known, ...fresh.map((panel) => ({ id: panel.id, shown: panel.id.startsWith('own-'), half: false }))];
}

export function arrange(next: Place[]): void {
  kept.value = next;
}

export function arrangeAsFirst(): void {
  kept.value = initial;
}

const isHidden = (value: unknown): value is Record<string, boolean> => isObject(value);
/** Series that somebody has switched off or on, by plot and series. */
export const hiddenSeries = saved<Record<string, boolean>>('series', {}, isHidden);
