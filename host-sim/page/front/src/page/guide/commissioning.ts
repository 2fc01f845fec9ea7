// What the step of commissioning says of a run, from what the bridge told of it.

import { formatNumber } from '../../numbers/format';
import { quantityText, type Units } from '../../numbers/units';
import type { Commission, Commissioned } from '../../protocol/bridge';

/** Readings of the heated wire that can be asked for; none: nothing is asked. */
export const readingCounts = [0, 1, 2, 3, 4] as const;

const heated_s = 84;
const hold_s = 20; // for one reading, at most

/** How long the wire is heated: without readings, and with them at most. */
export function heated(pace: number, readings: number): { least_s: number; most_s: number } {
  const least_s = Math.round(heated_s * pace);
  return { least_s, most_s: least_s + hold_s * readings };
}

export function isRunning(run: Commission | null): run is Commission {
  return run !== null && !['none', 'done', 'failed'].includes(run.stage);
}

/** What goes on, in a line. */
export function progressText(run: Commission): string {
  switch (run.stage) {
    case 'waiting':
      return 'Waiting for the bus …';
    case 'checking':
      return 'Servo and wire are checked …';
    case 'asking':
      return `A reading is asked for: ${Math.ceil(run.left_s ?? 0)} s left.`;
    case 'fitting':
      return `The heat is off. The wire is fitted to the run: ${Math.round(100 * run.share)} %.`;
    default:
      return run.line === '' ? 'The heat begins …' : run.line;
  }
}

/** What became known, as titles and texts. */
export function resultRows({ numbers }: Commissioned, units: Units): [string, string][] {
  const share = (value: number, digits = 2): string => quantityText('share', value, units, digits);
  const { before, after } = numbers.expected_error_of_stroke;
  const rows: [string, string][] = [
    ['Cold resistance', `${formatNumber(numbers.cold_ohm)} Ω, ${share(numbers.cold_factor - 1)} from the settings`],
    ['Expected error of the length', `${share(before.strain)} of the stroke before, ${share(after.strain)} after`],
    ['Expected error of the stroke', `${share(before.stroke)} before, ${share(after.stroke)} after`],
  ];
  if (numbers.anchors.length > 0) {
    rows.push(['Readings', `${formatNumber(numbers.distance, 2)} standard deviations from the type`]);
  }
  return rows;
}
