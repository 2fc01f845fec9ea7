// The states of CiA 402 in words, and which commands they allow.

import type { Drive, State } from '../../protocol/bridge';

export const driveNames: Record<Drive, string> = {
  not_ready: 'Not ready',
  switch_on_disabled: 'Switch on disabled',
  ready: 'Ready to switch on',
  switched_on: 'Switched on',
  operation_enabled: 'Operation enabled',
  quick_stop: 'Quick stop active',
  fault_reaction: 'Fault reaction active',
  fault: 'Fault',
};

export type Kind = 'off' | 'on' | 'fault' | 'unknown';

export function driveWords(state: State): { text: string; kind: Kind } {
  if (!state.online) {
    return { text: 'offline', kind: 'unknown' };
  }
  switch (state.drive) {
    case 'operation_enabled':
      return { text: 'Enabled: heated', kind: 'on' };
    case 'quick_stop':
      return { text: 'Quick stop', kind: 'on' };
    case 'fault_reaction':
      return { text: 'Fault reaction', kind: 'fault' };
    case 'fault':
      return { text: 'Fault', kind: 'fault' };
    case 'not_ready':
      return { text: 'Not ready', kind: 'unknown' };
    default:
      return { text: state.blocking.length > 0 ? 'Off: blocked' : 'Off', kind: 'off' };
  }
}

export interface Allowed {
  enable: boolean;
  disable: boolean;
  reset: boolean;
}

export function allowed(state: State | null): Allowed {
  if (!state?.online) {
    return { enable: false, disable: false, reset: false };
  }
  const off = ['switch_on_disabled', 'ready', 'switched_on'].includes(state.drive);
  return {
    enable: off && state.blocking.length === 0,
    disable: ['ready', 'switched_on', 'operation_enabled', 'quick_stop'].includes(state.drive),
    reset: state.drive === 'fault' || (off && state.latched.length > 0),
  };
}
