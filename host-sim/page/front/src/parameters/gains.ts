// What gains of 0 mean, beside them: a servo may move all the same (firmware/control/control.hpp).

import type { Value } from '../protocol/bridge';
import { valueText } from './values';

const gain = /^(strain|temperature|resistance|force)\.(proportional|integral|derivative)_(W|W_K|W_ohm|W_N|1_s|s)$/;
const units: Record<string, string> = { strain: 'W', temperature: 'W_K', resistance: 'W_ohm', force: 'W_N' };

/** What a loop does of which the PID does not react. */
function withoutPid(loop: string, values: Record<string, Value>): string {
  switch (loop) {
    case 'temperature':
      return (
        'The servo gives the power that holds the set-point by the model of the wire, and the wire approaches it as ' +
        'slowly as it warms or cools by itself.'
      );
    case 'resistance':
    case 'force':
      return 'The servo gives the power that holds the wire as it is, and does not go to its set-point.';
    default: {
      const time_s = values['trajectory.feed_forward_s'];
      return time_s === 0
        ? 'As trajectory.feed_forward_s is 0, too, the servo only replaces the heat that the wire loses: it does not ' +
            'contract to its set-point.'
        : 'The servo moves by the model of the wire alone: it gives the heat that is missing to the reference within ' +
            `trajectory.feed_forward_s${time_s === undefined ? '' : `, ${valueText(time_s)} s`}.`;
    }
  }
}

/** For the gain of this name with these values; '' where it needs no explanation. */
export function gainText(name: string, values: Record<string, Value>): string {
  const [, loop, part] = gain.exec(name) ?? [];
  if (loop === undefined) {
    return '';
  }
  const proportional = `${loop}.proportional_${units[loop]}`;
  if (values[proportional] !== 0) {
    return '';
  }
  if (part === 'proportional') {
    return (
      'At 0 the PID does not react to the error: its other gains are factors on this one. ' + withoutPid(loop, values)
    );
  }
  return values[name] === 0 ? '' : `Adds nothing while ${proportional} is 0: it is a factor on that gain.`;
}

/** Of a servo whose strain loop has no PID in force; '' where it has one, or was not read. */
export function defaultGainsText(values: Record<string, Value>): string {
  if (values['strain.proportional_W'] !== 0 || values['trajectory.feed_forward_s'] === 0) {
    return '';
  }
  return (
    'PID gains of 0 are the default: the inverse model of the wire (feed-forward) moves the servo, and the gains only ' +
    'add to it.'
  );
}

/** The same above the gains, with what to do. */
export function tuningText(values: Record<string, Value>): string {
  const text = defaultGainsText(values);
  return text && `${text} To tune, run a step test, try a gain, and run the test again.`;
}
