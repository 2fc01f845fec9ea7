// The plots of the live view: what each shows, and how they are arranged.

import { signal } from '@preact/signals';
import { hotSpotLabel, labelOf, plain, roleOf, shownAs, shownIn } from '../../live/display';
import { controlled } from '../../live/feed';
import type { Units } from '../../numbers/units';
import type { SeriesSpec } from '../../plot/time_plot';
import { isObject, read, saved } from '../../session/saved';

export interface TimePanel {
  kind: 'time';
  id: string;
  title: string;
  unit?: string;
  series: SeriesSpec[];
  limits?: boolean; ///< shows which limits act
  range?: [number, number]; ///< of the left axis, instead of one that fits
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

type Made = (name: string, more?: Partial<SeriesSpec>) => SeriesSpec;

/** Series with the scale of their signals. */
function seriesIn(units: Units): Made {
  return (name, more = {}) => {
    const { factor, offset, smallest } = shownAs(name, units);
    return { key: name, label: labelOf(name), role: roleOf(name), factor, offset, smallest, ...more };
  };
}

function timePanel(id: string, title: string, units: Units, series: SeriesSpec[], limits = false): TimePanel {
  // The left axis has the unit of its last series: a band before it is of the same kind.
  const left = series.filter((one) => one.axis !== 'right').at(-1)!;
  return { kind: 'time', id, title, unit: shownAs(left.key, units).unit, series, ...(limits ? { limits } : {}) };
}

function loopPanel(id: string, title: string, units: Units, x: string, y: string, xTitle: string): LoopPanel {
  const across = shownAs(x, units);
  const up = shownAs(y, units);
  return {
    kind: 'loop',
    id,
    title,
    unit: up.unit,
    x,
    y,
    xLabel: `${xTitle} in ${across.unit}`,
    smallest: [loopSmallest[x]! * across.factor, loopSmallest[y]! * up.factor],
  };
}

/** Shortest ranges of the axes of loops, in SI. */
const loopSmallest: Record<string, number> = { resistance_ohm: 0.1, wire_temperature_K: 2, strain: 0.001 };

function fixedPanels(units: Units): Panel[] {
  const series = seriesIn(units);
  const stack = { style: 'stack' } as const;
  return [
    timePanel('strain', 'Strain', units, [
      series('strain', {
        key: 'band',
        label: '±2σ',
        role: 'band',
        style: 'band',
        low: 'strain_low',
        high: 'strain_high',
      }),
      series('setpoint_strain', { style: 'steps' }),
      series('reference_strain', { style: 'dashed' }),
      series('strain', { width: 2 }),
    ]),
    timePanel(
      'power',
      'Power',
      units,
      [
        series('wanted_power_W', { style: 'dashed' }),
        series('power_W'),
        series('drive_current_A', { axis: 'right', unit: shownAs('drive_current_A', units).unit, label: 'current' }),
      ],
      true,
    ),
    loopPanel('strain-resistance', 'Strain over resistance', units, 'resistance_ohm', 'strain', 'resistance'),
    loopPanel('strain-temperature', 'Strain over temperature', units, 'wire_temperature_K', 'strain', 'temperature'),
    timePanel('temperature', 'Temperature', units, [
      series('estimated_ambient_K', { hidden: true }),
      series('hot_spot_K'),
      series('wire_temperature_K'),
    ]),
    timePanel('resistance', 'Resistance', units, [
      series('resistance_ohm'),
      series('resistance_model_ohm', { style: 'dashed' }),
    ]),
    {
      ...timePanel('phases', 'Phases', units, [
        series('martensite', stack),
        series('r_phase', stack),
        series('austenite', stack),
      ]),
      range: [0, shownAs('martensite', units).factor],
    },
    timePanel('current', 'Current', units, [series('current_A'), series('drive_current_A', { style: 'dashed' })], true),
    timePanel('position', 'Position', units, [series('position_m')]),
    timePanel('stress', 'Stress', units, [series('stress_Pa')]),
  ];
}

/** Set-point less measured value, in the unit of the mode. */
function errorPanel(mode: number, units: Units): TimePanel {
  const variable = controlled(mode) ?? 'position_m';
  const name = `error:${variable}`;
  return timePanel('error', 'Error', units, [
    seriesIn(units)(name, {
      label: `set-point − ${plain(variable)}`,
      role: 'error',
      smallest: (shownAs(name, units).smallest ?? 0) / 10, // looked at more closely than the quantity itself
    }),
  ]);
}

/** With the margin of the hot spot in its label. */
function explained(panel: Panel, margin_K: number): Panel {
  if (panel.id !== 'temperature' || panel.kind !== 'time') {
    return panel;
  }
  const label = hotSpotLabel(margin_K);
  return { ...panel, series: panel.series.map((one) => (one.key === 'hot_spot_K' ? { ...one, label } : one)) };
}

export function panels(mode: number, own: readonly OwnPanel[], hotSpotMargin_K: number, units: Units): Panel[] {
  const all = fixedPanels(units).map((panel) => explained(panel, hotSpotMargin_K));
  all.splice(2, 0, errorPanel(mode, units));
  return [...all, ...own.map((one) => ownPanel(one, mode, units))];
}

function ownPanel(own: OwnPanel, mode: number, units: Units): TimePanel {
  const unit = own.left[0] ? shownIn(mode, own.left[0], units).unit : '';
  const made = (name: string, n: number, axis: 'left' | 'right'): SeriesSpec => {
    const shown = shownIn(mode, name, units);
    const other = axis === 'right' || shown.unit !== unit ? { unit: shown.unit } : {};
    return seriesIn(units)(name, {
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
