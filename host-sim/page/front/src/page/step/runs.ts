// Step tests that were run: kept in the browser, laid over each other.

import { signal } from '@preact/signals';
import { ArraySamples } from '../../numbers/columns';
import { isChanged, sameValue } from '../../parameters/tree';
import type { ParameterInfo, Recording, StepFigures, Value } from '../../protocol/bridge';
import { isObject, saved } from '../../session/saved';

export interface Run {
  id: string;
  at_ms: number;
  node: number;
  amplitude_um: number;
  seconds: number;
  recording: Recording;
  figures: StepFigures;
  gains: Record<string, Value>;
  shown: boolean;
  /** Rows were left out when it was put away: enough to look at, not to be saved as a file. */
  thinned: boolean;
}

const most = 12;
const keptRows = 1000;

const isRuns = (value: unknown): value is Run[] =>
  Array.isArray(value) &&
  value.every(
    (run) =>
      isObject(run) &&
      isObject(run['recording']) &&
      Array.isArray(run['recording']['rows']) &&
      isObject(run['gains']) &&
      isObject(run['figures']),
  );

const kept = saved<Run[]>('runs', [], isRuns);
/** Newest first. Those of this visit are whole, those of an earlier one are thinned. */
export const runs = signal<Run[]>(kept.peek().map((run) => ({ ...run })));

function changed(next: Run[]): void {
  runs.value = next;
  kept.value = next.map(thin);
}

function thin(run: Run): Run {
  const { rows, period_s } = run.recording;
  const stride = Math.ceil(rows.length / keptRows);
  if (stride <= 1) {
    return run;
  }
  const recording = {
    ...run.recording,
    period_s: period_s * stride,
    rows: rows.filter((_, row) => row % stride === 0),
  };
  return { ...run, recording, thinned: true };
}

export function addRun(run: Run): void {
  changed([run, ...runs.value].slice(0, most));
}
export function removeRun(id: string): void {
  changed(runs.value.filter((run) => run.id !== id));
}
export function showRun(id: string, shown: boolean): void {
  changed(runs.value.map((run) => (run.id === id ? { ...run, shown } : run)));
}

export function column(recording: Recording, signalName: string): number[] {
  const at = recording.signals.indexOf(signalName);
  return at < 0 ? [] : recording.rows.map((row) => row[at] ?? NaN);
}

/** Seconds at which the set-point leaves its first value; 0 where it never does. */
export function edge_s(run: Run): number {
  const setpoints = column(run.recording, 'setpoint');
  const enough = Math.abs(run.amplitude_um) * 1e-7;
  const row = setpoints.findIndex((value) => Math.abs(value - setpoints[0]!) > enough);
  return Math.max(0, row) * run.recording.period_s;
}

const overlaid = ['position_m', 'wire_temperature_K', 'drive_current_A', 'setpoint'] as const;

/** All runs over the time since their step, position and set-point from where the set-point began. */
export function overlay(shown: readonly Run[]): ArraySamples {
  const period_s = Math.min(...shown.map((run) => run.recording.period_s));
  const from = Math.max(-0.2, -Math.max(...shown.map(edge_s)));
  const to = Math.max(...shown.map((run) => run.recording.rows.length * run.recording.period_s - edge_s(run)));
  const times: number[] = [];
  for (let i = 0; from + i * period_s <= to; ++i) {
    times.push(from + i * period_s);
  }
  const ys: Record<string, number[]> = {};
  for (const run of shown) {
    const start = edge_s(run);
    const begin = column(run.recording, 'setpoint')[0] ?? column(run.recording, 'position_m')[0] ?? 0;
    for (const name of overlaid) {
      const values = column(run.recording, name);
      const zero = name === 'position_m' || name === 'setpoint' ? begin : 0;
      ys[`${run.id}/${name}`] = times.map((time) => {
        const row = Math.round((time + start) / run.recording.period_s);
        return (values[row] ?? NaN) - zero;
      });
    }
  }
  return new ArraySamples(times, ys);
}

/** The gains in which runs differ, or that are not the default where there is one run only. */
export function tellingGains(all: readonly Run[], known: ReadonlyMap<string, ParameterInfo>): string[] {
  const names = [...new Set(all.flatMap((run) => Object.keys(run.gains)))];
  if (all.length > 1) {
    return names.filter((name) => all.some((run) => !sameValue(run.gains[name], all[0]!.gains[name])));
  }
  return names.filter((name) => {
    const info = known.get(name);
    return info?.level === 'tune' && isChanged(info, all[0]?.gains[name]);
  });
}
