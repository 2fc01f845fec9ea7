// What the wire has to do, as the fields have it: in SI, kept over a reload.

import { isNumber, saved } from '../../session/saved';

const number = (key: string, initial: number) => saved<number>(`choose.${key}`, initial, isNumber);
const optional = (key: string) =>
  saved<number | null>(
    `choose.${key}`,
    null,
    (value): value is number | null => value === null || (isNumber(value) && value > 0),
  );
const oneOf = <T extends string | number>(key: string, choices: readonly T[]) =>
  saved<T>(`choose.${key}`, choices[0]!, (value): value is T => (choices as readonly unknown[]).includes(value));

export const pulls = ['weight', 'nothing', 'spring'] as const;
export const lives = ['long', 'short'] as const;
export const counts = [1, 2, 3, 4, 5, 6, 7, 8] as const;

export const wish = {
  force_N: number('force_N', 5),
  stroke_m: number('stroke_m', 0.004),
  time_s: number('time_s', 1),
  length_m: optional('length_m'),
  supply_V: optional('supply_V'),
  ambient_K: number('ambient_K', 298.15),
  fan_m_s: number('fan_m_s', 2),
  pull: oneOf('pull', pulls),
  spring_N: number('spring_N', 2),
  spring_N_m: number('spring_N_m', 100),
  life: oneOf('life', lives),
  parallel: oneOf('parallel', counts),
};

/** What the service `choose` is asked; without what is left empty. */
export function request(): Record<string, unknown> {
  const { length_m, supply_V, pull } = wish;
  return {
    force_N: wish.force_N.value,
    stroke_m: wish.stroke_m.value,
    time_s: wish.time_s.value,
    ...(length_m.value !== null && { length_m: length_m.value }),
    ...(supply_V.value !== null && { supply_V: supply_V.value }),
    ambient_K: wish.ambient_K.value,
    fan_m_s: wish.fan_m_s.value,
    ...(pull.value === 'nothing' && { one_way: true }),
    ...(pull.value === 'spring' && { spring_N: wish.spring_N.value, spring_N_m: wish.spring_N_m.value }),
    life: wish.life.value,
    parallel: wish.parallel.value,
  };
}
