// Parameters as a tree of their groups, and what a search finds of them.

import type { ParameterInfo, Value } from '../protocol/bridge';

export interface Group {
  name: string; ///< the last part
  path: string; ///< of all parts, such as wire.m2a
  groups: Group[];
  parameters: ParameterInfo[];
}

/** In the order of the parameters. A group may hold both parameters and groups. */
export function treeOf(parameters: readonly ParameterInfo[]): Group {
  const root: Group = { name: '', path: '', groups: [], parameters: [] };
  for (const parameter of parameters) {
    const parts = parameter.name.split('.');
    let group = root;
    for (const part of parts.slice(0, -1)) {
      let next = group.groups.find((child) => child.name === part);
      if (!next) {
        next = { name: part, path: group.path ? `${group.path}.${part}` : part, groups: [], parameters: [] };
        group.groups.push(next);
      }
      group = next;
    }
    group.parameters.push(parameter);
  }
  return root;
}

/** How many parameters are in the group and those below it. */
export function countOf(group: Group): number {
  return group.groups.reduce((sum, child) => sum + countOf(child), group.parameters.length);
}

export interface Filter {
  text: string;
  /** Another name under which a parameter is shown. */
  shown?: (parameter: ParameterInfo) => string;
  only?: (parameter: ParameterInfo) => boolean;
}

/** All words must occur in name, meaning or unit; underscores and points count as spaces as well. */
export function find(parameters: readonly ParameterInfo[], filter: Filter): ParameterInfo[] {
  const words = filter.text
    .toLowerCase()
    .split(/\s+/)
    .filter((word) => word !== '');
  return parameters.filter((parameter) => {
    if (filter.only && !filter.only(parameter)) {
      return false;
    }
    const name = `${parameter.name} ${filter.shown?.(parameter) ?? ''}`.toLowerCase();
    const text =
      `${name} ${name.replace(/[._]/g, ' ')} ${parameter.meaning.toLowerCase()} ` + parameter.unit.toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

/** A REAL32 comes back from the bus as the float next to what was written. */
export function sameValue(a: Value | null | undefined, b: Value | null | undefined): boolean {
  if (typeof a === 'number' && typeof b === 'number') {
    return Math.fround(a) === Math.fround(b);
  }
  return a === b;
}

/** Whether it differs from its default; what has none never does. */
export function isChanged(parameter: ParameterInfo, value: Value | undefined): boolean {
  return value !== undefined && parameter.default !== null && !sameValue(value, parameter.default);
}
