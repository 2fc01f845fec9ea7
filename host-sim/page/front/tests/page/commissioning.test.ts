import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import { heated, isRunning, progressText, readingCounts, resultRows } from '../../src/page/guide/commissioning';
import type { Commission, Commissioned } from '../../src/protocol/bridge';

const run = (changed: Partial<Commission>): Commission => ({
  node: 1,
  client: 3,
  stage: 'heating',
  line: '',
  said: [],
  left_s: null,
  share: 0,
  error: '',
  files: [],
  result: null,
  ...changed,
});

const result: Commissioned = {
  text: '',
  notes: [],
  differences: [],
  numbers: {
    cold_ohm: 24.123,
    cold_factor: 1.012,
    distance: 1.54,
    expected_error_of_stroke: { before: { strain: 0.031, stroke: 0.029 }, after: { strain: 0.025, stroke: 0.0172 } },
    anchors: [{}, {}],
  },
};

describe('a run of commissioning', () => {
  it('lasts as long as its levels and its holds', () => {
    const live = new URL('../../../../../host-sim/commission/live/', import.meta.url);
    const header = (name: string): string => readFileSync(new URL(name, live), 'utf8');
    const of = (name: string, text = header('sequence.hpp')): number =>
      Number(new RegExp(`\\b${name} = ([\\d.]+)`).exec(text)![1]);
    const stairs_s = of('staircases') * (of('levels_up') * of('up_s') + of('levels_down') * of('down_s'));
    const whole_s = of('rest_s') + of('first_s') + of('cool_s') + stairs_s;
    expect(heated(1, 1)).toEqual({ least_s: whole_s, most_s: whole_s + of('hold_s', header('live.hpp')) });
    expect(Math.max(...readingCounts)).toBe(of('most_questions'));
    expect(heated(1, 0)).toEqual({ least_s: 84, most_s: 84 });
    expect(heated(2, 3)).toEqual({ least_s: 168, most_s: 228 });
  });

  it('goes on until it is done or has failed', () => {
    const stages = ['none', 'waiting', 'checking', 'asking', 'heating', 'fitting', 'done', 'failed'] as const;
    expect(stages.filter((stage) => isRunning(run({ stage })))).toEqual([
      'waiting',
      'checking',
      'asking',
      'heating',
      'fitting',
    ]);
    expect(isRunning(null)).toBe(false);
  });

  it('says what goes on', () => {
    expect(progressText(run({ stage: 'checking' }))).toMatch(/checked/);
    expect(progressText(run({ stage: 'asking', left_s: 17.2 }))).toBe('A reading is asked for: 18 s left.');
    const line = 'cycle 2 of 3, level 5 of 13: 210 mA, 22.1 ohm, 150 MPa; 55 s left';
    expect(progressText(run({ line }))).toBe(line);
    expect(progressText(run({ stage: 'fitting', share: 0.456 }))).toMatch(/46 %/);
  });

  it('says what became known, and how far the readings are off only where there are any', () => {
    const rows = Object.fromEntries(resultRows(result, 'bench'));
    expect(rows['Cold resistance']).toMatch(/^24\.12 Ω, 1\.2 %/);
    expect(rows['Expected error of the stroke']).toBe('2.9 % before, 1.7 % after');
    expect(rows['Readings']).toMatch(/^1\.5 standard deviations/);
    const without = { ...result, numbers: { ...result.numbers, anchors: [] } };
    expect(Object.fromEntries(resultRows(without, 'bench'))['Readings']).toBeUndefined();
  });
});
