// The units in which this browser shows quantities.

import { computed, signal } from '@preact/signals';
import { isUnits, type Units } from '../numbers/units';
import { saved } from './saved';

const chosen = saved<Units | null>('units', null, (value): value is Units | null => value === null || isUnits(value));
/** Where nobody has chosen: as the bridge was told. */
export const firstUnits = signal<Units>('bench');

export const units = computed<Units>(() => chosen.value ?? firstUnits.value);

export function chooseUnits(which: Units): void {
  chosen.value = which;
}
