// What the browser keeps over a reload. Where it cannot (private windows, a full store), the page works all
// the same and forgets.

import { effect, signal, type Signal } from '@preact/signals';

const prefix = 'smaservo.';

/** A value that is kept; what is found damaged is replaced by `initial`. */
export function saved<T>(key: string, initial: T, valid: (value: unknown) => value is T): Signal<T> {
  const kept = signal<T>(read(key, initial, valid));
  effect(() => {
    const text = JSON.stringify(kept.value);
    try {
      localStorage.setItem(prefix + key, text);
    } catch {
      // Nothing is lost but the memory of it.
    }
  });
  return kept;
}

/** What is kept, without keeping it from now on. */
export function read<T>(key: string, initial: T, valid: (value: unknown) => value is T): T {
  try {
    const text = localStorage.getItem(prefix + key);
    const value: unknown = text === null ? undefined : JSON.parse(text);
    return valid(value) ? value : initial;
  } catch {
    return initial;
  }
}

export const isString = (value: unknown): value is string => typeof value === 'string';
export const isNumber = (value: unknown): value is number => typeof value === 'number' && Number.isFinite(value);
export const isStrings = (value: unknown): value is string[] => Array.isArray(value) && value.every(isString);
export const isObject = (value: unknown): value is Record<string, unknown> =>
  typeof value === 'object' && value !== null && !Array.isArray(value);
