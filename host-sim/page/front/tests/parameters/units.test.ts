// Over all parameters of the firmware: its reference has their names and ranges, model/units.hpp the units.

import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import type { Units } from '../../src/numbers/units';
import { find, sameValue } from '../../src/parameters/tree';
import {
  convertText,
  editText,
  parseValue,
  rangeText,
  readText,
  shownName,
  unitOf,
  withShownNames,
} from '../../src/parameters/values';
import type { ParameterInfo, ParameterUnit } from '../../src/protocol/bridge';
import { randomFrom } from '../random';

const root = new URL('../../../../../', import.meta.url);
const choices: Units[] = ['bench', 'si'];
const zero_degC_K = 273.15;

/** The kinds of model/units.hpp: lists of units, SI's own first. */
const kinds: Record<string, ParameterUnit[]> = Object.fromEntries(
  [
    ...readFileSync(new URL('model/units.hpp', root), 'utf8').matchAll(
      /auto (\w+) =\s*std::to_array<Unit>\(\{(.*?)\}\);/gs,
    ),
  ].map(([, kind, rows]) => [
    kind,
    [...rows!.matchAll(/\{"(\w*)", ([\d.e-]+)(?:, (\w+))?\}/g)].map(([, unit, factor, offset]) => ({
      unit: unit!,
      factor: Number(factor),
      offset: offset === 'zero_degC_K' ? zero_degC_K : 0,
    })),
  ]),
);

/** Differences of temperatures; the bridge's test (PageServos) says that they are those with a bound below 100 K. */
const isDifference = (name: string): boolean =>
  /(^limits\.hot_spot|_sd|^profile\.overheat|^temperature\.dead_band|smallest_reversal)_K$/.test(name);

/** As the bridge describes them. */
function described(name: string, range: string): ParameterInfo | null {
  const [, min, max] = /^(\S+) to (\S+)$/.exec(range) ?? [];
  if (min === undefined || max === undefined) {
    return null;
  }
  const listed = Object.entries(kinds).filter(([kind]) => kind !== 'count');
  // The longest unit that ends the name; a temperature and a difference of two have the same.
  const fits = listed
    .filter(
      ([kind, [si]]) =>
        kind !== (isDifference(name) ? 'temperature' : 'temperature_difference') &&
        si!.unit &&
        name.endsWith(`_${si!.unit}`),
    )
    .sort((a, b) => b[1][0]!.unit.length - a[1][0]!.unit.length)[0]?.[1];
  const units = fits ?? kinds['number']!;
  return {
    name,
    type: 'number',
    unit: units[0]!.unit,
    units,
    min: Math.fround(Number(min)),
    max: Math.fround(Number(max)),
    default: null,
    change: 'live',
    level: 'tune',
    meaning: '',
  };
}

const all = [
  ...readFileSync(new URL('firmware/reference/PARAMETERS.md', root), 'utf8').matchAll(
    /^\| \w+:\d+ \| `([\w.]+)` \| REAL32 \| ([^|]+) \|/gm,
  ),
].flatMap(([, name, range]) => described(name!, range!) ?? []);
const one = (name: string): ParameterInfo => all.find((info) => info.name === name)!;

/** Values of a parameter as the bus has them: its bounds, and floats between them. */
function valuesOf(info: ParameterInfo, random: () => number): number[] {
  const [min, max] = [info.min!, info.max!];
  const inside = Array.from({ length: 40 }, (_, i) =>
    i % 2 === 0 ? min + (max - min) * random() : min + (max - min) * 10 ** (-9 * random()),
  );
  const round = [0, 0.1, 1, 18, zero_degC_K, 393.15, 150e6, 7.6e-5].filter((value) => value >= min && value <= max);
  return [min, max, ...inside, ...round].map(Math.fround).map((value) => Math.min(max, Math.max(min, value)));
}

describe('all parameters', () => {
  it('are known with their units', () => {
    expect(all.length).toBeGreaterThan(120);
    expect(kinds['temperature']).toEqual([
      { unit: 'K', factor: 1, offset: 0 },
      { unit: 'degC', factor: 1, offset: zero_degC_K },
    ]);
    for (const info of all) {
      expect(info.unit === '' || info.name.endsWith(`_${info.unit}`)).toBe(true);
    }
  });

  it('give the same float when what is shown is typed and sent', () => {
    const random = randomFrom(60);
    for (const info of all) {
      for (const value of valuesOf(info, random)) {
        for (const choice of choices) {
          const parsed = parseValue(info, editText(info, value, choice), choice);
          expect('value' in parsed && sameValue(parsed.value, value), `${info.name} ${value} ${choice}`).toBe(true);
        }
      }
    }
  });

  it('give the same float when the units are switched while it is edited, there and back', () => {
    const random = randomFrom(61);
    for (const info of all) {
      for (const value of valuesOf(info, random)) {
        for (const [from, to] of [choices, [...choices].reverse()] as [Units, Units][]) {
          const there = convertText(info, editText(info, value, from), from, to);
          const parsed = parseValue(info, convertText(info, there, to, from), from);
          expect('value' in parsed && sameValue(parsed.value, value), `${info.name} ${value}`).toBe(true);
        }
      }
    }
  });

  it('are shifted by 273.15 where they are temperatures, and never where they are differences or gains', () => {
    for (const info of all) {
      const shift = unitOf(info, 'bench').offset;
      const temperature = info.unit === 'K' && info.min! >= 100;
      expect([info.name, shift]).toEqual([info.name, temperature ? zero_degC_K : 0]);
      if (!temperature && info.unit.includes('K')) {
        expect(unitOf(info, 'bench').unit).toMatch(/K/);
      }
    }
  });

  it('have a name that ends in the unit of what is shown, one of those that the tools take', () => {
    const names = new Set<string>();
    for (const info of all) {
      for (const choice of choices) {
        const { unit } = unitOf(info, choice);
        const name = shownName(info, choice);
        expect(info.units!.map((known) => known.unit)).toContain(unit);
        expect(unit === '' || name.endsWith(`_${unit}`)).toBe(true);
        names.add(`${choice} ${name}`);
      }
      expect(shownName(info, 'si')).toBe(info.name);
    }
    expect(names.size).toBe(2 * all.length);
  });
});

describe('a parameter', () => {
  it('is shown in the units of the choice, with its range', () => {
    const shown: [string, number, string, string][] = [
      ['limits.temperature_K', 393.15, 'limits.temperature_degC', '120 °C'],
      ['limits.hot_spot_K', 18, 'limits.hot_spot_K', '18 K'],
      ['limits.current_A', 0.1, 'limits.current_mA', '100 mA'],
      ['limits.power_W', 2, 'limits.power_mW', '2000 mW'],
      ['limits.stress_Pa', 150e6, 'limits.stress_MPa', '150 MPa'],
      ['wire.length_m', 0.1, 'wire.length_mm', '100 mm'],
      ['wire.diameter_m', 7.6e-5, 'wire.diameter_um', '76 µm'],
      ['axis.zero_strain', 0.04, 'axis.zero_strain_percent', '4 %'],
      ['strain.dead_band', 5e-5, 'strain.dead_band_percent', '0.005 %'],
      ['strain.setpoint_weight', 1, 'strain.setpoint_weight', '1'],
      ['wire.m2a.finish_0_K', 340, 'wire.m2a.finish_0_degC', '66.85 °C'],
      ['wire.m2a.finish_1_K_Pa', 1e-7, 'wire.m2a.finish_1_K_MPa', '0.1 K/MPa'],
      ['temperature.proportional_W_K', 0.05, 'temperature.proportional_W_K', '0.05 W/K'],
      ['trips.min_ambient_K', 253.15, 'trips.min_ambient_degC', '−20 °C'],
    ];
    for (const [name, value, bench, text] of shown) {
      const info = one(name);
      expect([shownName(info, 'bench'), readText(info, Math.fround(value), 'bench')]).toEqual([bench, text]);
    }
    expect(rangeText(one('limits.temperature_K'), 'bench')).toBe('0 to 326.85 °C');
    expect(rangeText(one('limits.temperature_K'), 'si')).toBe('273.15 to 600 K');
    expect(rangeText(one('trips.min_ambient_K'), 'bench')).toBe('−100 to 126.85 °C');
    expect(readText(undefined, 2, 'bench')).toBe('2');
    expect(readText(one('limits.current_A'), null, 'bench')).toBe('');
  });

  it('is typed in these units, and refused in them', () => {
    const info = one('limits.temperature_K');
    expect(parseValue(info, '120', 'bench')).toEqual({ value: 393.15 });
    expect(parseValue(info, '393.15', 'si')).toEqual({ value: 393.15 });
    expect(parseValue(info, '393.15', 'bench')).toEqual({ refused: '393.15 is too large; allowed: 0 to 326.85 °C' });
    expect(parseValue(info, '-1', 'bench')).toHaveProperty('refused');
    expect(parseValue(one('limits.current_A'), '0.3', 'bench')).toHaveProperty('refused');
    expect(parseValue(one('limits.current_A'), '300', 'bench')).toEqual({ value: 0.3 });
  });

  it('keeps a text that is no number when the units are switched', () => {
    expect(convertText(one('limits.temperature_K'), '1 2', 'bench', 'si')).toBe('1 2');
    expect(convertText(one('limits.temperature_K'), '900', 'bench', 'si')).toBe('1173.15');
  });

  it('is found by both names, and named in texts as it is shown', () => {
    const found = (text: string): string[] =>
      find(all, { text, shown: (info) => shownName(info, 'bench') }).map((info) => info.name);
    expect(found('limits.temperature_degC')).toContain('limits.temperature_K');
    expect(found('limits.temperature_K')).toContain('limits.temperature_K');
    const infos = new Map(all.map((info) => [info.name, info]));
    expect(withShownNames('Lower limits.current_A. Not a.b or 1.5 A.', infos, 'bench')).toBe(
      'Lower limits.current_mA. Not a.b or 1.5 A.',
    );
  });
});
