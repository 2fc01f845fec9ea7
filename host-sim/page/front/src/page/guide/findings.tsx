// The steps of the guide, what was found in each, and how a step shows what it read.

import { signal } from '@preact/signals';
import type { ComponentChildren } from 'preact';
import { type Quantity, quantityText } from '../../numbers/units';
import { isObject, saved } from '../../session/saved';
import { node } from '../../session/session';
import { units } from '../../session/units';

/** A number of a finding in SI: it is kept, and may be read in other units later. */
interface Amount {
  quantity: Quantity;
  value: number | null; ///< null: no finite number
  digits: number;
}
export type Said = (string | Amount)[];

interface Finding {
  at_ms: number;
  text: string | Said;
}

const isFindings = (value: unknown): value is Record<string, Finding> => isObject(value);
const findings = saved<Record<string, Finding>>('guide', {}, isFindings);

export const steps = [
  { id: 'bus', title: 'Bus and node' },
  { id: 'wire', title: 'The wire' },
  { id: 'limits', title: 'Limits' },
  { id: 'resistor', title: 'A resistor first' },
  { id: 'heat', title: 'First heating' },
  { id: 'commission', title: 'A wire file without a displacement sensor' },
  { id: 'tune', title: 'Tune' },
  { id: 'keep', title: 'Keep' },
] as const;
export type StepId = (typeof steps)[number]['id'];

export const opened = signal<StepId | null>(null);
const key = (id: string): string => `${node.value}/${id}`;

export function amount(quantity: Quantity, value: number, digits = 4): Amount {
  return { quantity, value: Number.isFinite(value) ? value : null, digits };
}

/** In the units in force. */
export function saidText(text: string | Said): string {
  if (typeof text === 'string') {
    return text;
  }
  return text
    .map((part) =>
      typeof part === 'string' ? part : quantityText(part.quantity, part.value ?? NaN, units.value, part.digits),
    )
    .join('');
}

export function findingOf(id: StepId): Finding | undefined {
  return findings.value[key(id)];
}

/** What was read, in words: it stands beside the step from then on. */
export function found(id: StepId, text: string | Said): void {
  findings.value = { ...findings.value, [key(id)]: { at_ms: Date.now(), text } };
  const next = steps[steps.findIndex((step) => step.id === id) + 1];
  opened.value = next && !findings.value[key(next.id)] ? next.id : null;
}

export function forget(id: StepId): void {
  const { [key(id)]: _, ...rest } = findings.value;
  findings.value = rest;
  opened.value = id;
}

export function Read({ rows }: { rows: [string, ComponentChildren][] }) {
  return (
    <dl class="read">
      {rows.map(([title, value]) => (
        <div key={title}>
          <dt>{title}</dt>
          <dd>{value}</dd>
        </div>
      ))}
    </dl>
  );
}
