// Edits of parameters: drafts, trials, writes, and the history that takes them back.

import { computed, effect, signal, untracked } from '@preact/signals';
import { sameValue } from '../parameters/tree';
import { UndoHistory } from '../parameters/undo';
import { convertText, parseValue, shownName, withShownNames } from '../parameters/values';
import type { Units } from '../numbers/units';
import type { Difference, ParameterInfo, Value } from '../protocol/bridge';
import { say, sayError, sayFileError } from './notices';
import { isNumber, isStrings, saved } from './saved';
import { act, call, description, node, own, set, state } from './session';
import { units } from './units';

/** What was typed and not written yet, by name, with the units in which it was typed. */
export const drafts = signal<Record<string, { text: string; units: Units }>>({});
export const favourites = saved<string[]>(
  'favourites',
  ['strain.proportional_W', 'strain.integral_1_s', 'strain.derivative_s', 'limits.current_A', 'limits.temperature_K'],
  isStrings,
);
export const trySeconds = saved<number>('try_s', 30, isNumber);

const histories = new Map<number, UndoHistory>();
const changedHistory = signal(0);

export const history = computed<UndoHistory>(() => {
  void changedHistory.value;
  const which = node.value ?? -1;
  if (!histories.has(which)) {
    histories.set(which, new UndoHistory());
  }
  return histories.get(which)!;
});
/** Counts up with each change of the history, which is an object that stays the same. */
export const historyVersion = computed(() => changedHistory.value);

export const infos = computed<Map<string, ParameterInfo>>(
  () => new Map((description.value?.parameters ?? []).map((info) => [info.name, info])),
);

/** The name under which a parameter is shown. */
export function nameOf(name: string): string {
  const info = infos.value.get(name);
  return info ? shownName(info, units.value) : name;
}

/** A text for a person, with such names. */
export function named(text: string): string {
  return withShownNames(text, infos.value, units.value);
}

/** What was typed, in the units in force; undefined: nothing. */
export function draftText(info: ParameterInfo): string | undefined {
  const typed = drafts.value[info.name];
  return typed && convertText(info, typed.text, typed.units, units.value);
}

export interface Drafted {
  values: Record<string, Value>;
  refused: Record<string, string>;
}

export const drafted = computed<Drafted>(() => {
  const result: Drafted = { values: {}, refused: {} };
  for (const [name, typed] of Object.entries(drafts.value)) {
    const info = infos.value.get(name);
    if (!info) {
      continue;
    }
    const parsed = parseValue(info, typed.text, typed.units);
    if ('refused' in parsed) {
      const now = parseValue(info, convertText(info, typed.text, typed.units, units.value), units.value);
      result.refused[name] = 'refused' in now ? now.refused : parsed.refused;
    } else if (!sameValue(parsed.value, own.value[name])) {
      result.values[name] = parsed.value;
    }
  }
  return result;
});

export function draft(name: string, text: string | null): void {
  const next = { ...drafts.value };
  if (text === null) {
    delete next[name];
  } else {
    next[name] = { text, units: units.peek() };
  }
  drafts.value = next;
}

export function discard(): void {
  drafts.value = {};
}

/** What is on trial by this page, with the values before it. */
const trial = signal<{ node: number; before: Record<string, Value>; after: Record<string, Value> } | null>(null);
export const trying = computed(() => state.value?.transaction.state === 'trying');

function before(names: string[]): Record<string, Value> {
  return Object.fromEntries(names.filter((name) => name in own.value).map((name) => [name, own.value[name]!]));
}

export async function tryDrafts(): Promise<void> {
  const changed = drafted.value.values;
  if (Object.keys(changed).length === 0) {
    return;
  }
  const was = before(Object.keys(changed));
  if (!(await act('try', { node: node.value, values: changed, seconds: trySeconds.value }))) {
    return;
  }
  const earlier = trial.value;
  trial.value = { node: node.value!, before: { ...was, ...earlier?.before }, after: { ...earlier?.after, ...changed } };
  discard();
}

export async function keep(): Promise<void> {
  const kept = trial.value;
  trial.value = null;
  if (!(await act('commit', { node: node.value }))) {
    trial.value = kept;
    return;
  }
  if (kept) {
    record(kept.before, kept.after, 'kept after a trial');
  }
}

export async function revert(): Promise<void> {
  trial.value = null;
  await act('revert', { node: node.value });
}

/** Writes at once; whether all of it is in force now. */
export async function write(changed: Record<string, Value>, how = 'written'): Promise<boolean> {
  const names = Object.keys(changed);
  if (names.length === 0) {
    return true;
  }
  const was = before(names);
  const prefix = `node${node.value}.`;
  try {
    const inForce = await set(names.map((name) => ({ name: prefix + name, value: changed[name] })));
    const taken = names.every((name) => {
      const found = inForce.find((one) => one.name === prefix + name);
      return found !== undefined && sameValue(found.value as Value, changed[name]);
    });
    if (taken && how) {
      record(was, changed, how);
    }
    return taken;
  } catch (error) {
    sayError(error);
    return false;
  }
}

export async function writeDrafts(): Promise<void> {
  if (await write(drafted.value.values)) {
    discard();
  }
}

function record(was: Record<string, Value>, now: Record<string, Value>, how: string): void {
  history.value.record(
    Object.keys(now)
      .filter((name) => name in was)
      .map((name) => ({ name, before: was[name]!, after: now[name]! })),
    how,
    Date.now(),
  );
  ++changedHistory.value;
}

export async function undo(): Promise<void> {
  const back = history.value.undo();
  if (back && (await write(back, ''))) {
    history.value.undid();
    ++changedHistory.value;
  }
}

export async function redo(): Promise<void> {
  const again = history.value.redo();
  if (again && (await write(again, ''))) {
    history.value.redid();
    ++changedHistory.value;
  }
}

export async function store(): Promise<void> {
  if (await act('store', { node: node.value })) {
    say('Stored: the settings outlast a reset.');
  }
}

/** The settings of a file; what differed before is in the history. */
export async function restore(file: string, toml: string): Promise<void> {
  try {
    const answer = await call('restore', { node: node.value, toml });
    const changed = (answer['changed'] ?? []) as Difference[];
    say(
      changed.length === 0
        ? 'The servo has these settings already.'
        : `Restored: ${changed.length} ${changed.length === 1 ? 'parameter' : 'parameters'}.`,
    );
    const values = (which: 'node' | 'file'): Record<string, Value> =>
      Object.fromEntries(changed.map((one) => [one.name, one[which]]));
    record(values('node'), values('file'), 'restored from a file');
  } catch (error) {
    sayFileError(error, file);
  }
}

export function toggleFavourite(name: string): void {
  favourites.value = favourites.value.includes(name)
    ? favourites.value.filter((one) => one !== name)
    : [...favourites.value, name];
}

function ended(): void {
  if (trial.value === null || trial.value.node !== node.value) {
    return;
  }
  trial.value = null;
  say('The trial has ended: the values before it are back.');
}

/** Says it when a trial ends that nobody kept. */
export function watchTrials(): void {
  let was = false;
  effect(() => {
    const now = trying.value;
    if (was && !now) {
      untracked(ended);
    }
    was = now;
  });
  let last = node.peek();
  effect(() => {
    if (node.value !== last) {
      discard();
    }
    last = node.value;
  });
}
