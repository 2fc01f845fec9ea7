// From an unknown servo to a tuned one, step by step. A step is done when what it read says so, or when the
// person has looked and says so; it can be left at any time, and taken up again after a reload.

import type { JSX } from 'preact';
import { node } from '../../session/session';
import { CommissionStep } from './commission_step';
import { findingOf, forget, opened, saidText, type StepId, steps } from './findings';
import { BusStep, KeepStep, LimitsStep, WireStep } from './settings_steps';
import { HeatStep, ResistorStep, TuneStep } from './heated_steps';

const views: Record<StepId, () => JSX.Element> = {
  bus: BusStep,
  wire: WireStep,
  limits: LimitsStep,
  resistor: ResistorStep,
  heat: HeatStep,
  commission: CommissionStep,
  tune: TuneStep,
  keep: KeepStep,
};

export function GuideView() {
  const first = steps.find((step) => !findingOf(step.id));
  const current = opened.value ?? first?.id ?? null;
  const done = steps.filter((step) => findingOf(step.id)).length;
  if (node.value === null) {
    return <p class="empty">The guide begins when a servo answers on the bus.</p>;
  }
  return (
    <div class="guide" data-testid="guide">
      <div class="guide-head">
        <h1>First run of servo {node.value}</h1>
        <p class="soft">
          {done === steps.length
            ? 'All steps are done. Each can be opened and done again.'
            : `${done} of ${steps.length} steps done. Leave at any time; the page remembers where you were.`}
        </p>
        <progress max={steps.length} value={done} aria-label="Steps done" />
      </div>
      <ol class="steps">
        {steps.map((step, number) => {
          const finding = findingOf(step.id);
          const open = step.id === current;
          const View = views[step.id];
          return (
            <li
              key={step.id}
              class={`step${finding ? ' done' : ''}${open ? ' open' : ''}`}
              data-testid={`guide-${step.id}`}>
              <button
                type="button"
                class="step-head"
                aria-expanded={open}
                onClick={() => {
                  opened.value = open ? null : step.id;
                }}>
                <span class="step-number" aria-hidden="true">
                  {finding ? '✓' : number + 1}
                </span>
                <span class="step-title">{step.title}</span>
                {finding && (
                  <span class="soft">
                    {new Date(finding.at_ms).toLocaleDateString('en-GB', {
                      day: 'numeric',
                      month: 'short',
                      year: 'numeric',
                    })}
                  </span>
                )}
              </button>
              {finding && (
                <p class="finding" data-testid={`finding-${step.id}`}>
                  {saidText(finding.text)}{' '}
                  <button type="button" class="link" onClick={() => forget(step.id)}>
                    Do it again
                  </button>
                </p>
              )}
              {open && !finding && (
                <div class="step-body">
                  <View />
                </div>
              )}
            </li>
          );
        })}
      </ol>
    </div>
  );
}
