// The servo's recorder: up to eight signals at the rate of its loop, around a trigger.

import { signal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { plain, roleOf, shownIn } from '../../live/display';
import { ArraySamples } from '../../numbers/columns';
import { fromShown, isUnits, quantityText, type Shown, toShown, tidy, type Units } from '../../numbers/units';
import { PlotGroup } from '../../plot/group';
import { TimePlot } from '../../plot/time_plot';
import type { Recording } from '../../protocol/bridge';
import { sayError, sentence } from '../../session/notices';
import { isNumber, isString, isStrings, saved } from '../../session/saved';
import { bridge, call, description, link, node, readOnly, state } from '../../session/session';
import { units } from '../../session/units';
import { inSeconds, NumberField, SignalField } from '../fields/number_field';
import { column } from './runs';
import { SaveButtons } from './save_buttons';

const most = 8;
const patience_s = 60; // for the trigger
const chosen = saved<string[]>(
  'recorded',
  ['position_m', 'setpoint', 'drive_current_A', 'wire_temperature_K'],
  isStrings,
);
const seconds = saved<number>('record_s', 2, isNumber);
const before = saved<number>('record_before_s', 0.2, isNumber);
const triggerSignal = saved<string>('trigger', '', isString);
const triggerSign = saved<string>('trigger_sign', '>', isString);
/** The level as it was typed, and the units in which it was. */
const triggerValue = saved<number>('trigger_value', 0, isNumber);
const triggerUnits = saved<Units>('trigger_units', 'bench', isUnits);
/** Set-points are in the unit of the mode that there was. */
const recording = signal<{ recording: Recording; mode: number } | null>(null);
/** What this page records at present. */
const running = signal<{ node: number | null; trigger: string } | null>(null);

const triggerScale = (choice: Units): Shown => shownIn(state.value?.mode ?? 0, triggerSignal.value, choice);

/** The bridge takes SI units, the person those of the plots. */
function triggerLevel_SI(): number {
  return fromShown(triggerScale(triggerUnits.value), triggerValue.value);
}

function triggerText(): string {
  return `${triggerSignal.value}${triggerSign.value}${triggerLevel_SI()}`;
}

function TriggerLevel() {
  const scale = triggerScale(units.value);
  const value = triggerUnits.value === units.value ? triggerValue.value : tidy(toShown(scale, triggerLevel_SI()));
  return (
    <NumberField
      key={units.value}
      title="Level"
      unit={scale.unit}
      value={value}
      testid="trigger-value"
      set={(typed) => {
        triggerValue.value = typed;
        triggerUnits.value = units.value;
      }}
    />
  );
}

/** What the button says while a recording runs. A crossing of the level counts from "Waiting" on. */
function stageText({ node: recorded, trigger }: { node: number | null; trigger: string }): string {
  const stage = bridge.value?.recordings.find((one) => one.node === recorded)?.stage;
  if (trigger === '' || stage === 'recording') {
    return 'Recording …';
  }
  return stage === 'waiting' ? 'Waiting for the trigger …' : 'Arming …';
}

async function record(): Promise<void> {
  const trigger = triggerSignal.value === '' ? '' : triggerText();
  running.value = { node: node.value, trigger };
  try {
    const answer = await call('record', {
      node: node.value,
      signals: chosen.value,
      seconds: seconds.value,
      before_s: trigger === '' ? 0 : before.value,
      trigger,
      patience_s,
    });
    recording.value = { recording: answer['recording'] as Recording, mode: state.value?.mode ?? 0 };
  } catch (error) {
    sayError(error, 'Recorder');
  }
  running.value = null;
}

export function RecorderCard() {
  const names = (description.value?.signals ?? []).map((one) => one.name);
  const activity = bridge.value?.activity;
  const toggle = (name: string): void => {
    chosen.value = chosen.value.includes(name)
      ? chosen.value.filter((one) => one !== name)
      : [...chosen.value, name].slice(0, most);
  };
  return (
    <section class="card" data-testid="recorder">
      <h2>Recorder</h2>
      <p class="soft">Up to eight signals, each step of the servo's loop. {chosen.value.length} chosen.</p>
      <div class="chips" role="group" aria-label="Signals to record">
        {names.map((name) => (
          <button
            type="button"
            key={name}
            class="toggle"
            aria-pressed={chosen.value.includes(name)}
            disabled={!chosen.value.includes(name) && chosen.value.length >= most}
            data-testid={`record-${name}`}
            onClick={() => toggle(name)}>
            {plain(name)}
          </button>
        ))}
      </div>
      <div class="bar wrap ends">
        <SignalField title="Duration" scale={inSeconds} number={seconds} testid="record-seconds" />
        <label class="field narrow">
          <span>Trigger</span>
          <select
            value={triggerSignal.value}
            data-testid="trigger"
            onChange={(event) => {
              triggerSignal.value = event.currentTarget.value;
            }}>
            <option value="">at once</option>
            {names.map((name) => (
              <option key={name} value={name}>
                {plain(name)}
              </option>
            ))}
          </select>
        </label>
        {triggerSignal.value !== '' && (
          <>
            <label class="field tiny">
              <span>is</span>
              <select
                value={triggerSign.value}
                onChange={(event) => {
                  triggerSign.value = event.currentTarget.value;
                }}>
                <option value=">">above</option>
                <option value="<">below</option>
              </select>
            </label>
            <TriggerLevel />
            <SignalField title="Before it" scale={inSeconds} number={before} testid="record-before" />
          </>
        )}
        <button
          type="button"
          class="big"
          data-testid="record"
          onClick={() => void record()}
          disabled={
            link.value !== 'open' || readOnly.value || running.value !== null || chosen.value.length === 0 || !!activity
          }>
          {running.value ? stageText(running.value) : 'Record'}
        </button>
      </div>
      {recording.value && <Recorded {...recording.value} />}
    </section>
  );
}

function Recorded({ recording: shown, mode }: { recording: Recording; mode: number }) {
  const place = useRef<HTMLDivElement>(null);
  const choice = units.value;
  useEffect(() => {
    const times = shown.rows.map((_, row) => row * shown.period_s);
    const samples = new ArraySamples(
      times,
      Object.fromEntries(shown.signals.map((name) => [name, column(shown, name)])),
    );
    const extent: [number, number] = [0, Math.max(shown.period_s, times.at(-1) ?? 0)];
    const group = new PlotGroup({ x: 'seconds', extent: () => extent });
    const scales = new Map(shown.signals.map((name) => [name, shownIn(mode, name, choice)]));
    const all = [...new Set(shown.signals.map((name) => scales.get(name)!.unit))];
    const plots = all.map((unit, n) => {
      const names = shown.signals.filter((name) => scales.get(name)!.unit === unit);
      return new TimePlot(
        place.current!,
        group,
        {
          id: `record-${unit || 'none'}`,
          title: sentence(names.map(plain).join(', ')),
          unit,
          height: 130,
          ...(n === all.length - 1 ? { xLabel: 'time in s' } : {}),
          series: names.map((name, k) => ({
            key: name,
            label: plain(name),
            role: roleOf(name, k),
            ...scales.get(name)!,
            unit: '',
          })),
        },
        samples,
      );
    });
    return () => plots.forEach((plot) => plot.destroy());
  }, [shown, choice]);
  return (
    <div data-testid="recorded">
      <div class="bar">
        <span>
          {shown.rows.length} rows, one each {quantityText('response_s', shown.period_s, choice)}
        </span>
        <span class="spring" />
        <SaveButtons recording={shown} />
      </div>
      <div class="plots" ref={place} />
    </div>
  );
}
