import { describe, expect, it } from 'vitest';
import { hotSpotLabel, hotSpotText, shownAs, shownIn } from '../../src/live/display';

describe('shownIn', () => {
  it('shows a set-point as what the mode controls', () => {
    const controlled: [number, string][] = [
      [1, 'position_m'],
      [8, 'position_m'],
      [4, 'force_N'],
      [-1, 'current_A'],
      [-2, 'power_W'],
      [-3, 'wire_temperature_K'],
    ];
    for (const [mode, signal] of controlled) {
      for (const units of ['bench', 'si'] as const) {
        expect(shownIn(mode, 'setpoint', units)).toEqual(shownAs(signal, units));
        expect(shownIn(mode, 'reference', units)).toEqual(shownAs(signal, units));
        expect(shownIn(mode, 'hot_spot_K', units)).toEqual(shownAs('hot_spot_K', units));
      }
    }
    expect(shownIn(0, 'setpoint', 'bench').unit).toBe('');
  });
});

describe('shownAs', () => {
  it('has the units of the choice', () => {
    const signals: [string, string, string][] = [
      ['wire_temperature_K', '°C', 'K'],
      ['error:wire_temperature_K', 'K', 'K'],
      ['stress_Pa', 'MPa', 'Pa'],
      ['drive_current_A', 'mA', 'A'],
      ['power_W', 'mW', 'W'],
      ['position_m', 'µm', 'm'],
      ['error:position_m', 'µm', 'm'],
      ['velocity_m_s', 'mm/s', 'm/s'],
      ['strain', '%', ''],
      ['martensite', '%', ''],
      ['resistance_ohm', 'Ω', 'Ω'],
      ['limit_reasons', '', ''],
    ];
    for (const [signal, bench, si] of signals) {
      expect([shownAs(signal, 'bench').unit, shownAs(signal, 'si').unit]).toEqual([bench, si]);
      expect(shownAs(signal, 'si')).toMatchObject({ factor: 1, offset: 0 });
    }
    expect(shownAs('error:wire_temperature_K', 'bench').offset).toBe(0);
  });

  it('draws the same span of an axis at least, in both choices', () => {
    for (const signal of [
      'wire_temperature_K',
      'stress_Pa',
      'drive_current_A',
      'position_m',
      'velocity_m_s',
      'strain',
    ]) {
      const bench = shownAs(signal, 'bench');
      expect(shownAs(signal, 'si').smallest! * bench.factor).toBeCloseTo(bench.smallest!, 9);
    }
  });
});

it('explains the hot spot with the margin that is set, or without a number where none was read', () => {
  expect(hotSpotText(18)).toContain('plus a fixed margin of 18 K (limits.hot_spot_K)');
  expect(hotSpotText(NaN)).toContain('plus a fixed margin (limits.hot_spot_K)');
  expect([hotSpotLabel(18), hotSpotLabel(NaN)]).toEqual(['hot spot (wire + 18 K)', 'hot spot']);
});
