// From an unknown servo to a tuned one, step by step. A step is done when what it read says so, or when the
// person has looked and says so; it can be left at any time, and taken up again after a reload.

import { signal } from '@preact/signals';
import type { ComponentChildren } from 'preact';
import { node } from '../../session/session';
import { isObject, saved } from '../../session/saved';
import { BusStep, KeepStep, LimitsStep, WireStep } from './settings_steps';
import { HeatStep, ResistorStep, TuneStep } from './heated_steps';

export interface Finding {
  at_ms: number;
  text: string;
}

const isFindings = (value: unknown): value is Record<string, Finding> => isObject(value);
const findings = saved<Record<string, Finding>>('guide', {}, isFindings);

const steps = [
  { id: 'bus', title: 'Bus and node', view: BusStep },
  { id: 'wire', title: 'The wire', view: WireStep },
  { id: 'limits', title: 'Limits', view: LimitsStep },
  { id: 'resistor', title: 'A resistor first', view: ResistorStep },
  { id: 'heat', title: 'First heating', view: HeatStep },
  { id: 'tune', title: 'Tune', view: TuneStep },
  { id: 'keep', title: 'Keep', view: KeepStep },
] as const;
export type StepId = (typeof steps)[number]['id'];

const opened = signal<StepId | null>(null);
const key = (id: string): string => `${node.value}/${id}`;

export function findingOf(id: StepId): Finding | undefined {
  return findings.value[key(id)];
}

/** What was read, in words: it stands beside the step from then on. */
export function found(id: StepId, text: string): void {
  findings.value = { ...findings.value, [key(id)]: { at_ms: Date.now(), text } };
  const next = steps[steps.findIndex((step) => step.id === id) + 1];
  opened.value = next && !findings.value[key(next.id)] ? next.id : null;
}

function forget(id: StepId): void {
  const { [key(id)]: _, ...rest } = findings.value;
  findings.value = rest;
  opened.value = id;
}

export function GuideView() {
  const first = steps.find((step) => !findingOf(step.id));
  const current = opened.value ?? first?.id ?? null;
  const done = steps.filter((step) => findingOf(step.id)).length;
  if (node.value === null) return <p class="empty">The guide begins when a servo answers on the bus.</p>;
  return (
    <div class="guide" data-testid="guide">
      <div class="guide-head">
        <h1>First run of servo {node.value}</h1>
        <p class="soft">{done === steps.length ? 'All steps are done. Each can be opened and done again.'
          : `${done} of ${steps.length} steps done. Leave at any time; the page remembers where you were.`}</p>
        <progress max={steps.length} value={done} aria-label="Steps done" />
      </div>
      <ol class="steps">
        {steps.map((step, number) => {
          const finding = findingOf(step.id);
          const open = step.id === current;
          return (
            <li key={step.id} class={`step${finding ? ' done' : ''}${open ? ' open' : ''}`} data-testid={`guide-${step.id}`}>
              <button type="button" class="step-head" aria-expanded={open}
                onClick={() => { opened.value = open ? null : step.id; }}>
                <span class="step-number" aria-hidden="true">{finding ? '✓' : number + 1}</span>
                <span class="step-title">{step.title}</span>
                {finding && <span class="soft">{new Date(finding.at_ms).toLocaleDateString('en-GB', { day: 'numeric', month: 'short', year: 'numeric' })}</span>}
              </button>
              {finding && <p class="finding" data-testid={`finding-${step.id}`}>{finding.text}{' '}
                <button type="button" class="link" onClick={() => forget(step.id)}>Do it again</button></p>}
              {open && !finding && <div class="step-body"><step.view /></div>}
            </li>
          );
        })}
      </ol>
    </div>
  );
}

export function Read({ rows }: { rows: [string, ComponentChildren][] }) {
  return (
    <dl class="read">
      {rows.map(([title, value]) => <div key={title}><dt>{title}</dt><dd>{value}</dd></div>)}
    </dl>
  );
}
