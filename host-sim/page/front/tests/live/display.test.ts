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
      expect(shownIn(mode, 'setpoint')).toEqual(shownAs(signal));
      expect(shownIn(mode, 'reference')).toEqual(shownAs(signal));
      expect(shownIn(mode, 'hot_spot_K')).toEqual(shownAs('hot_spot_K'));
    }
    expect(shownIn(0, 'setpoint').unit).toBe('');
  });
});

it('explains the hot spot with the margin that is set, or without a number where none was read', () => {
  expect(hotSpotText(18)).toContain('plus a fixed margin of 18 K (limits.hot_spot_K)');
  expect(hotSpotText(NaN)).toContain('plus a fixed margin (limits.hot_spot_K)');
  expect([hotSpotLabel(18), hotSpotLabel(NaN)]).toEqual(['hot spot (wire + 18 K)', 'hot spot']);
});
