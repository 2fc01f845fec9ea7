import { describe, expect, it } from 'vitest';
import { cold_ohm, finish_K, limitChecks, type Settings, statistics } from '../../src/page/guide/checks';

const settings: Settings = {
  'limits.current_A': 0.1,
  'trips.current_A': 0.15,
  'limits.temperature_K': 393.15,
  'trips.temperature_K': 403.15,
  'limits.stress_Pa': 250e6,
  'trips.stress_Pa': 300e6,
  'limits.min_strain': 0,
  'axis.zero_strain': 0.04,
  'wire.diameter_m': 76e-6,
  'wire.length_m': 0.1,
  'wire.martensite.resistivity_ohm_m': 0.9e-6,
  'wire.m2a.finish_0_K': 340,
  'wire.m2a.finish_1_K_Pa': 1e-7,
  'wire.m2a.finish_2_K_Pa2': 0,
};
const wrong = (changed: Settings, stress_Pa = 150e6): string[] =>
  limitChecks({ ...settings, ...changed }, stress_Pa, 'bench')
    .filter((check) => check.ok === false)
    .map((check) => check.text);

describe('the checks of the guide', () => {
  it('find nothing wrong with settings that fit', () => expect(wrong({})).toEqual([]));

  it.each([
    ['limits.current_A', 0.2],
    ['limits.temperature_K', 410],
    ['limits.temperature_K', 350],
    ['limits.stress_Pa', 310e6],
    ['limits.min_strain', 0.05],
  ])('find %s of %d', (name, value) => expect(wrong({ [name]: value })).not.toEqual([]));

  it('find a stress above its limit', () => expect(wrong({}, 260e6)).not.toEqual([]));

  it('judge the same in both choices of units, and say it in these', () => {
    const [bench, si] = (['bench', 'si'] as const).map((units) => limitChecks(settings, 150e6, units));
    expect(si!.map((check) => check.ok)).toEqual(bench!.map((check) => check.ok));
    const texts = (checks: typeof bench): string => checks!.map((check) => check.text).join(' ');
    expect(texts(bench)).toMatch(/100 mA.*150 mA.*120 °C.*130 °C.*150 MPa.*81\.85 °C.*4 %.*A\/mm²/);
    expect(texts(bench)).not.toMatch(/\d (A(?!\/mm)|K|Pa)\b/);
    expect(texts(si)).toMatch(/0\.1 A.*0\.15 A.*393\.1 K.*1\.5e\+08 Pa.*355 K.*0\.04 at position.*A\/m²/);
    expect(texts(si)).not.toMatch(/mA|°C|MPa|%/);
  });

  it('judge nothing that was not read', () => {
    expect(limitChecks({}, NaN, 'bench').every((check) => check.ok === null)).toBe(true);
    expect(limitChecks({ ...settings, 'trips.current_A': 'x' }, 150e6, 'bench')[0]!.ok).toBeNull();
  });

  it('reckon with the wire as its parameters have it', () => {
    expect(finish_K(settings, 150e6)).toBeCloseTo(355, 6);
    expect(cold_ohm(settings)).toBeCloseTo(19.84, 2);
  });

  it('count samples that are numbers', () => {
    expect(statistics([1, NaN, 3])).toEqual({ mean: 2, sd: Math.SQRT2, count: 2 });
    expect(statistics([]).count).toBe(0);
  });
});
