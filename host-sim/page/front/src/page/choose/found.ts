// What the bridge has answered: it outlasts a look at another view, but not a reload.

import { batch, computed, signal } from '@preact/signals';
import type { Choice } from '../../protocol/bridge';
import { sayError } from '../../session/notices';
import { call } from '../../session/session';
import { request } from './wish';

export interface Found extends Choice {
  id: number; ///< another one for each answer
  fan_m_s: number; ///< that was asked for
  asked: string; ///< the whole request
}

export const asking = signal(false);
export const refused = signal('');
export const found = signal<Found | null>(null);
/** The row whose course is drawn. */
export const selected = signal(0);
/** Whether the fields say something else than what was answered. */
export const outdated = computed(() => found.value !== null && found.value.asked !== JSON.stringify(request()));

let answers = 0;

export async function find(): Promise<void> {
  const wanted = request();
  batch(() => {
    asking.value = true;
    refused.value = '';
  });
  try {
    const choice = (await call('choose', wanted)) as unknown as Choice;
    batch(() => {
      found.value = {
        ...choice,
        id: ++answers,
        fan_m_s: Number(wanted['fan_m_s']),
        asked: JSON.stringify(wanted),
      };
      selected.value = 0;
    });
  } catch (error) {
    found.value = null;
    refused.value = error instanceof Error ? error.message : String(error);
    sayError(error, 'Choose a wire');
  }
  asking.value = false;
}
