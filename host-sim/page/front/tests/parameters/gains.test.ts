import { describe, expect, it } from 'vitest';
import { gainText, tuningText } from '../../src/parameters/gains';

/** As a servo has them by default. */
const usual = {
  'strain.proportional_W': 0,
  'strain.integral_1_s': 0,
  'strain.derivative_s': 0,
  'strain.setpoint_weight': 1,
  'trajectory.feed_forward_s': 0.01,
  'temperature.proportional_W_K': 0.05,
  'temperature.integral_1_s': 1,
  'force.proportional_W_N': 0,
  'force.integral_1_s': 1,
};

describe('a gain of 0', () => {
  it('says what moves the servo nevertheless', () => {
    const text = gainText('strain.proportional_W', usual);
    expect(text).toContain('At 0 the PID does not react to the error');
    expect(text).toContain('by the model of the wire alone');
    expect(text).toContain('trajectory.feed_forward_s, 0.01 s.');
  });

  it('says where nothing does', () => {
    expect(gainText('strain.proportional_W', { ...usual, 'trajectory.feed_forward_s': 0 })).toContain(
      'does not contract to its set-point',
    );
    expect(gainText('force.proportional_W_N', usual)).toContain('does not go to its set-point');
  });

  it('takes the effect of the gains that are factors on it', () => {
    expect(gainText('force.integral_1_s', usual)).toBe(
      'Adds nothing while force.proportional_W_N is 0: it is a factor on that gain.',
    );
    // Said once, at the gain itself.
    expect(gainText('strain.integral_1_s', usual)).toBe('');
  });

  it('is the only one that is explained', () => {
    expect(gainText('strain.proportional_W', { ...usual, 'strain.proportional_W': 2 })).toBe('');
    for (const name of ['temperature.proportional_W_K', 'temperature.integral_1_s', 'strain.setpoint_weight']) {
      expect(gainText(name, usual)).toBe('');
    }
    expect(gainText('drive.proportional', { 'drive.proportional': 0 })).toBe('');
    expect(gainText('strain.proportional_W', {})).toBe('');
  });
});

it('the default gains are explained where a person tunes, with what to do', () => {
  expect(tuningText(usual)).toMatch(/the default: the inverse model of the wire \(feed-forward\) moves the servo/);
  expect(tuningText(usual)).toMatch(/run a step test, try a gain/);
  expect(tuningText({ ...usual, 'strain.proportional_W': 2 })).toBe('');
  expect(tuningText({ ...usual, 'trajectory.feed_forward_s': 0 })).toBe('');
  expect(tuningText({})).toBe('');
});
