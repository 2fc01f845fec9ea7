// Axes: ranges that fit what is drawn and end at round numbers, and the labels of their ticks.

import type uPlot from 'uplot';
import { formatClock, formatNumber, formatTicks } from '../numbers/format';
import type { GroupOptions } from './group';
import { theme } from './theme';

export const axisFont = '12px system-ui, -apple-system, "Segoe UI", Roboto, sans-serif';
export const leftSize = 52;
export const rightSize = 48;

/** 1, 2 or 5 times a power of ten, at or above the value. */
export function niceStep(value: number): number {
  if (!(value > 0) || !Number.isFinite(value)) {
    return 1;
  }
  const power = 10 ** Math.floor(Math.log10(value));
  const mantissa = value / power;
  return (mantissa <= 1 ? 1 : mantissa <= 2 ? 2 : mantissa <= 5 ? 5 : 10) * power;
}

/** A range around the data that ends at round numbers; at least `smallest` wide, so that noise is not all. */
export function niceRange(low: number, high: number, smallest = 0): [number, number] {
  if (!Number.isFinite(low) || !Number.isFinite(high)) {
    return [0, 1];
  }
  const least = Math.max(smallest, 2e-4 * Math.max(Math.abs(low), Math.abs(high)), 1e-12);
  if (high - low < least) {
    const middle = (low + high) / 2;
    low = middle - least / 2;
    high = middle + least / 2;
  }
  const pad = 0.04 * (high - low);
  const step = niceStep((high - low) / 10);
  const from = low >= 0 && low - pad < 0 ? 0 : Math.floor((low - pad) / step) * step;
  const to = high <= 0 && high + pad > 0 ? 0 : Math.ceil((high + pad) / step) * step;
  return [from, to];
}

/** Of a logarithmic axis: whole decades unless the data fill less than one. */
export function logRange(low: number, high: number): [number, number] {
  if (!(low > 0) || !(high > 0)) {
    return [0.1, 1];
  }
  if (high / low < 5) {
    return [low / 1.2, high * 1.2];
  }
  return [10 ** Math.floor(Math.log10(low) + 1e-9), 10 ** Math.ceil(Math.log10(high) - 1e-9)];
}

const seconds = [
  1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120,
  300, 600, 1200, 1800, 3600, 7200, 14400, 43200, 86400,
];

function common(): Partial<uPlot.Axis> {
  return {
    font: axisFont,
    stroke: () => theme().soft,
    grid: { stroke: () => theme().grid, width: 1 },
    ticks: { stroke: () => theme().axis, width: 1, size: 4 },
    border: { show: true, stroke: () => theme().axis, width: 1 },
    gap: 4,
  };
}

export function xAxis(options: GroupOptions): uPlot.Axis {
  const written = (step: number, ticks: number[]): string[] => {
    if (options.x === 'clock') {
      return ticks.map((tick) => formatClock(tick, step));
    }
    return options.log ? ticks.map((tick) => formatNumber(tick)) : formatTicks(ticks, step);
  };
  return {
    ...common(),
    scale: 'x',
    size: 24,
    space: options.x === 'clock' ? 72 : 64,
    ...(options.x === 'number' ? {} : { incrs: seconds }),
    values: (_u, ticks, _axis, _space, step) =>
      options.log ? ticks.map((tick) => (tick === null ? '' : formatNumber(tick))) : written(step, ticks),
  };
}

/** An axis that is `empty` only keeps its place, so that plots of a group stay in line. */
export function yAxis(side: 'left' | 'right', log: boolean, empty = false): uPlot.Axis {
  const axis = common();
  return {
    ...axis,
    scale: side === 'left' ? 'y' : 'right',
    side: side === 'left' ? 3 : 1,
    size: side === 'left' ? leftSize : rightSize,
    space: 26,
    grid: { ...axis.grid, show: side === 'left' },
    ticks: { ...axis.ticks, show: !empty },
    border: { ...axis.border, show: !empty },
    values: (_u, ticks, _axis, _space, step) =>
      empty ? [] : log ? ticks.map((tick) => (tick === null ? '' : formatNumber(tick))) : formatTicks(ticks, step),
  };
}
