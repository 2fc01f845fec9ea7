import { describe, expect, it } from 'vitest';
import { countOf, find, type Group, isChanged, sameValue, treeOf } from '../../src/parameters/tree';
import { type Change, UndoHistory } from '../../src/parameters/undo';
import { parseValue, rangeText, unitText, valueText } from '../../src/parameters/values';
import type { ParameterInfo, Value } from '../../src/protocol/bridge';
import { randomFrom } from '../random';

function info(name: string, more: Partial<ParameterInfo> = {}): ParameterInfo {
  return {
    name,
    type: 'number',
    unit: 'W',
    min: 0,
    max: 10,
    default: 1,
    change: 'live',
    level: 'tune',
    meaning: 'power of the heater',
    ...more,
  };
}

const parameters = [
  info('strain.proportional_W'),
  info('strain.integral_1_s', { unit: '1/s', meaning: 'integral gain' }),
  info('wire.length_m', { unit: 'm', default: null, meaning: 'length between the clamps' }),
  info('wire.m2a.start_0_K', { unit: 'K', meaning: 'start temperature' }),
  info('wire.m2a.finish_0_K', { unit: 'K', meaning: 'finish temperature' }),
];

function namesOf(group: Group): string[] {
  return [...group.parameters.map((one) => one.name), ...group.groups.flatMap(namesOf)];
}

describe('the tree', () => {
  it('has each parameter once, below the groups of its name', () => {
    const root = treeOf(parameters);
    expect(root.groups.map((group) => group.path)).toEqual(['strain', 'wire']);
    expect(root.groups[1]!.groups[0]!.path).toBe('wire.m2a');
    expect(namesOf(root).sort()).toEqual(parameters.map((one) => one.name).sort());
    expect(countOf(root.groups[1]!)).toBe(3);
  });

  it('holds any names', () => {
    const random = randomFrom(40);
    const names = new Set<string>();
    while (names.size < 300) {
      const depth = 1 + Math.floor(random() * 4);
      names.add(
        Array.from({ length: depth }, () => 'abc'[Math.floor(random() * 3)]! + Math.floor(random() * 9)).join('.'),
      );
    }
    const root = treeOf([...names].map((name) => info(name)));
    expect(namesOf(root).sort()).toEqual([...names].sort());
  });

  it('is searched by all words of a text, in name, meaning and unit', () => {
    const found = (text: string): string[] => find(parameters, { text }).map((one) => one.name);
    expect(found('')).toHaveLength(5);
    expect(found('m2a START')).toEqual(['wire.m2a.start_0_K']);
    expect(found('clamps')).toEqual(['wire.length_m']);
    expect(found('finish 0')).toEqual(['wire.m2a.finish_0_K']);
    expect(found('1/s')).toEqual(['strain.integral_1_s']);
    expect(found('start clamps')).toEqual([]);
  });

  it('marks what differs from its default, as floats', () => {
    const one = info('a.b', { default: 0.1 });
    expect(isChanged(one, Math.fround(0.1))).toBe(false);
    expect(isChanged(one, 0.2)).toBe(true);
    expect(isChanged(info('a.b', { default: null }), 3)).toBe(false);
    expect(isChanged(one, undefined)).toBe(false);
  });
});

describe('values', () => {
  it('are read back from their text', () => {
    const random = randomFrom(41);
    const any = info('a.b', { min: null, max: null });
    for (let i = 0; i < 2000; ++i) {
      const value = Math.fround((random() - 0.5) * 10 ** (random() * 12 - 6));
      const parsed = parseValue(any, valueText(value), 'si');
      expect('value' in parsed && sameValue(parsed.value, value)).toBe(true);
    }
  });

  it.each([
    ['', 'a number is missing'],
    ['1,5', '"1,5" is not a number'],
    ['0x10', '"0x10" is not a number'],
    ['NaN', 'not a number'],
    ['Infinity', 'not a number'],
    ['-1', '-1 is too small'],
    ['10.1', '10.1 is too large'],
    ['1 2', 'not a number'],
  ])('refuses "%s" with the reason and the range', (text, why) => {
    const parsed = parseValue(info('a.b'), text, 'si');
    if (!('refused' in parsed)) {
      throw new Error(`${text} was taken`);
    }
    expect(parsed.refused).toContain(why);
    expect(parsed.refused).toContain('0 to 10 W');
  });

  it('takes both ends of the range, also where they are no exact floats', () => {
    const bounded = info('a.b', { min: 0.1, max: 0.3 });
    for (const text of ['0.1', '0.3', ' .2 ', '2e-1', '+0.2']) {
      expect(parseValue(bounded, text, 'si')).toHaveProperty('value');
    }
    expect(parseValue(bounded, '0.0999', 'si')).toHaveProperty('refused');
  });

  it('knows whole numbers, choices and truth', () => {
    expect(parseValue(info('a', { type: 'integer' }), '1.5', 'si')).toHaveProperty('refused');
    expect(parseValue(info('a', { type: 'integer' }), '4', 'si')).toEqual({ value: 4 });
    const choice = info('a', { type: 'choice', choices: ['off', 'hold'] });
    expect(parseValue(choice, 'hold', 'si')).toEqual({ value: 'hold' });
    expect(parseValue(choice, 'on', 'si')).toEqual({ refused: '"on" is no choice; allowed: off, hold' });
    expect(parseValue(info('a', { type: 'boolean' }), 'true', 'si')).toEqual({ value: true });
    expect(parseValue(info('a', { type: 'boolean' }), '1', 'si')).toHaveProperty('refused');
  });

  it('have units as a person writes them', () => {
    expect(['W', '1_s', 'ohm', 'ohm_m', 'ohm_m_K', 'K_Pa2', ''].map(unitText)).toEqual([
      'W',
      '1/s',
      'Ω',
      'Ω m',
      'Ω m/K',
      'K/Pa²',
      '',
    ]);
  });

  it('have a range in words', () => {
    expect(rangeText(info('a'), 'si')).toBe('0 to 10 W');
    expect(rangeText(info('a', { max: null }), 'si')).toBe('at least 0 W');
    expect(rangeText(info('a', { min: null }), 'si')).toBe('at most 10 W');
    expect(rangeText(info('a', { min: null, max: null }), 'si')).toBe('');
  });
});

describe('UndoHistory', () => {
  it('goes back to any state before, and forward again', () => {
    const random = randomFrom(42);
    const history = new UndoHistory();
    const now: Record<string, Value> = { a: 0, b: 0, c: 0 };
    const states = [{ ...now }];
    for (let step = 0; step < 60; ++step) {
      const names = Object.keys(now).filter(() => random() < 0.5);
      const changes: Change[] = names.map((name) => ({ name, before: now[name]!, after: Math.floor(random() * 3) }));
      if (!changes.some((change) => change.before !== change.after)) {
        continue;
      }
      for (const change of changes) {
        now[change.name] = change.after;
      }
      history.record(changes, 'written', step);
      states.push({ ...now });
    }
    const seen = [{ ...now }];
    for (let back = history.undo(); back; back = history.undo()) {
      Object.assign(now, back);
      history.undid();
      seen.push({ ...now });
    }
    expect(seen.reverse()).toEqual(states);
    for (let again = history.redo(); again; again = history.redo()) {
      Object.assign(now, again);
      history.redid();
    }
    expect(now).toEqual(states.at(-1));
  });

  it('keeps an entry until the servo has taken it back', () => {
    const history = new UndoHistory();
    history.record([{ name: 'a', before: 1, after: 2 }], 'written', 0);
    expect(history.undo()).toEqual({ a: 1 });
    expect(history.undo()).toEqual({ a: 1 });
    expect(history.canRedo).toBe(false);
  });

  it('has no entry that changes nothing, no redo after a change, and an end', () => {
    const history = new UndoHistory();
    history.record([{ name: 'a', before: 0.1, after: Math.fround(0.1) }], 'written', 0);
    expect(history.canUndo).toBe(false);
    history.record([{ name: 'a', before: 1, after: 2 }], 'written', 0);
    history.undid();
    history.record([{ name: 'a', before: 1, after: 3 }], 'written', 0);
    expect(history.canRedo).toBe(false);
    for (let i = 0; i < 300; ++i) {
      history.record([{ name: 'a', before: i, after: i + 1 }], 'written', i);
    }
    expect(history.entries).toHaveLength(100);
    expect(history.entries[0]!.changes[0]!.after).toBe(300);
  });
});
