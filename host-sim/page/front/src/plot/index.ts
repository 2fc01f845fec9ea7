// What pages use of the plots.

export { ArraySamples, RangedColumn } from '../numbers/columns';
export { formatClock, formatDuration, formatExact, formatNumber } from '../numbers/format';
export type { Column, Samples } from '../numbers/samples';
export { drawNow, requestDraw } from './frames';
export { PlotGroup } from './group';
export { forceTheme, onTheme, otherRole, theme } from './theme';
export type { Role } from './theme';
export { TimePlot } from './time_plot';
export type { Line, SeriesSpec, TimePlotSpec } from './time_plot';
export { XYPlot } from './xy_plot';
export type { Circle, LoopSpec, XYPlotSpec } from './xy_plot';
