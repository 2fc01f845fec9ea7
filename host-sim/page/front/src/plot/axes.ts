// Axes: ranges that fit what is drawn and end at round numbers, and the labels of their ticks.

import type uPlot from 'uplot';
import { formatClock, formatNumber, formatTicks } from '../numbers/format';
import type { GroupOptions } from './group';
import { theme } from './theme';

export const axisFont = '12px system-ui, -apple-system, "Segoe UI", Roboto, sans-serif';
/** Widths of the vertical axes in pixels of CSS, where the labels need no more. */
export const leftSize = 52;
export const rightSize = 48;
export const bottomSize = 24; ///< height of the horizontal axis
/** Room beside the last label of the horizontal axis, where there is no right axis. */
export const endSize = 14;

const tickSize = 4;
const gap = 4;
const spare = 2; // before the edge of the picture
const grain = 8; // by which an axis widens: it is to move seldom while its labels change

export type WidthOf = (text: string) => number;

/** Width of a vertical axis with these labels, so that none is cut off. */
export function axisSize(labels: readonly string[], least: number, widthOf: WidthOf = textWidth): number {
  const needed = tickSize + gap + widest(labels, widthOf) + spare;
  return needed <= least ? least : Math.ceil(needed / grain) * grain;
}

/** Room to the right of a horizontal axis with these labels: half of one may stand there. */
export function endRoom(labels: readonly string[], widthOf: WidthOf = textWidth): number {
  return Math.max(endSize, Math.ceil(widest(labels, widthOf) / 2) + spare);
}

function widest(labels: readonly string[], widthOf: WidthOf): number {
  return labels.reduce((most, text) => Math.max(most, widthOf(text)), 0);
}

const widths = new Map<string, number>();
let measuring: CanvasRenderingContext2D | null = null;

/** In the font of the axes, by its characters: a browser is asked once for each of them. */
function textWidth(text: string): number {
  let sum = 0;
  for (const letter of text) {
    let width = widths.get(letter);
    if (width === undefined) {
      measuring ??= document.createElement('canvas').getContext('2d')!;
      measuring.font = axisFont;
      width = measuring.measureText(letter).width;
      widths.set(letter, width);
    }
    sum += width;
  }
  return sum;
}

/** 1, 2 or 5 times a power of ten, at or above the value. */
export function niceStep(value: number): number {
  if (!(value > 0) || !Number.isFinite(value)) {
    return 1;
  }
  const power = 10 ** Math.floor(Math.log10(value));
  const mantissa = value / power;
  return (mantissa <= 1 ? 1 : mantissa <= 2 ? 2 : mantissa <= 5 ? 5 : 10) * power;
}

const nothing = 1e-12; // what is smaller is the rounding error of a zero

/** A range around the data that ends at round numbers; at least `smallest` wide, so that noise is not all. Where
 * nobody says what is small, data that do not change have a tenth of their size around them, and zeros 1. */
export function niceRange(low: number, high: number, smallest = 0): [number, number] {
  if (!Number.isFinite(low) || !Number.isFinite(high)) {
    return [0, 1];
  }
  const largest = Math.max(Math.abs(low), Math.abs(high));
  const usual = high - low <= 1e-9 * largest ? 0.1 * largest : 2e-4 * largest;
  const least = smallest > 0 ? Math.max(smallest, 2e-4 * largest) : largest < nothing ? 1 : usual;
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
    ticks: { stroke: () => theme().axis, width: 1, size: tickSize },
    border: { show: true, stroke: () => theme().axis, width: 1 },
    gap,
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
    space: 26,
    grid: { ...axis.grid, show: side === 'left' },
    ticks: { ...axis.ticks, show: !empty },
    border: { ...axis.border, show: !empty },
    values: (_u, ticks, _axis, _space, step) =>
      empty ? [] : log ? ticks.map((tick) => (tick === null ? '' : formatNumber(tick))) : formatTicks(ticks, step),
  };
}
