import { expect, it, vi } from 'vitest';
import type { Value } from '../../src/protocol/bridge';

vi.stubGlobal('localStorage', { getItem: () => null, setItem: () => undefined });
const { tellingGains } = await import('../../src/page/step/runs');
type Run = Parameters<typeof tellingGains>[0][number];

const run = (gains: Record<string, Value>): Run => ({
  id: '',
  at_ms: 0,
  node: 1,
  amplitude_um: 500,
  seconds: 1,
  recording: { period_s: 0.001, signals: [], rows: [] },
  figures: { rise_s: null, settling_s: null, overshoot_percent: null, error_percent: null, peak_K: null },
  gains,
  shown: true,
  thinned: false,
});
const info = (
  name: string,
  level: string,
): [string, Parameters<typeof tellingGains>[1] extends ReadonlyMap<string, infer I> ? I : never] => [
  name,
  { name, type: 'number', unit: 'W', min: 0, max: 9, default: 0, change: 'live', level, meaning: '' },
];
const known = new Map([info('strain.proportional_W', 'tune'), info('limits.power_W', 'set up')]);

it('of runs those gains are told in which they differ, also where one run lacks them', () => {
  const first = run({ 'strain.proportional_W': 0, 'limits.power_W': 2, 'strain.dead_band': 5e-5 });
  const second = run({ 'strain.proportional_W': 3, 'limits.power_W': Math.fround(2), 'strain.dead_band': 5e-5 });
  expect(tellingGains([first, second], known)).toEqual(['strain.proportional_W']);
  expect(tellingGains([first, run({})], known)).toHaveLength(3);
  expect(tellingGains([first, first], known)).toEqual([]);
});

it('of one run those are told that are not the default', () => {
  expect(tellingGains([run({ 'strain.proportional_W': 3, 'limits.power_W': 2 })], known)).toEqual([
    'strain.proportional_W',
  ]);
  expect(tellingGains([run({ 'strain.proportional_W': 0 })], known)).toEqual([]);
  expect(tellingGains([], known)).toEqual([]);
});
