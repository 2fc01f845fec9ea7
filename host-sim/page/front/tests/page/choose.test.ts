import { beforeEach, expect, it, vi } from 'vitest';

vi.stubGlobal('localStorage', { getItem: () => null, setItem: () => undefined });
const { samplesOf } = await import('../../src/page/choose/course');
const { request, wish } = await import('../../src/page/choose/wish');

beforeEach(() => {
  wish.pull.value = 'weight';
  wish.length_m.value = null;
});

it('what is left empty is not asked for, and only one way back is', () => {
  const plain = ['force_N', 'stroke_m', 'time_s', 'ambient_K', 'fan_m_s', 'life', 'parallel'];
  expect(Object.keys(request())).toEqual(plain);
  wish.pull.value = 'nothing';
  expect(Object.keys(request())).toEqual([...plain.slice(0, 5), 'one_way', ...plain.slice(5)]);
  wish.pull.value = 'spring';
  wish.length_m.value = 0.12;
  expect(request()).toMatchObject({ length_m: 0.12, spring_N: 2, spring_N_m: 100 });
  expect(request()).not.toHaveProperty('one_way');
});

it('courses with times of their own become rows of one plot, without a value where they have ended', () => {
  const samples = samplesOf({
    time_s: [0, 1, 3, 5],
    contraction_m: [0, 0.004, 0.002, 0],
    temperature_K: [300, 370, 330, 310],
    fan_time_s: [0, 1, 2],
    fan_contraction_m: [0, 0.004, 0],
  });
  const rows = Array.from({ length: samples.end }, (_, row) => row);
  const column = (key: string): number[] => rows.map((row) => samples.column(key)!.at(row));
  expect(rows.map((row) => samples.x(row))).toEqual([0, 1, 2, 3, 5]);
  expect(column('still')).toEqual([0, 0.004, 0.003, 0.002, 0]);
  expect(column('temperature')).toEqual([300, 370, 350, 330, 310]);
  expect(column('fan')).toEqual([0, 0.004, 0, NaN, NaN]);
});

it('a course without rows is an empty plot', () => {
  const none = { time_s: [], contraction_m: [], temperature_K: [], fan_time_s: [], fan_contraction_m: [] };
  expect(samplesOf(none).end).toBe(0);
});
