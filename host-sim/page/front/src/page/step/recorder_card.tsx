// The servo's recorder: up to eight signals at the rate of its loop, around a trigger.

import { signal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { plain, roleOf, type Shown, shownIn } from '../../live/display';
import { ArraySamples } from '../../numbers/columns';
import { formatNumber } from '../../numbers/format';
import { PlotGroup } from '../../plot/group';
import { TimePlot } from '../../plot/time_plot';
import type { Recording } from '../../protocol/bridge';
import { sayError, sentence } from '../../session/notices';
import { isNumber, isString, isStrings, saved } from '../../session/saved';
import { bridge, call, description, link, node, readOnly, state } from '../../session/session';
import { SignalField } from '../fields/number_field';
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
const triggerValue = saved<number>('trigger_value', 0, isNumber);
/** Set-points are in the unit of the mode that there was. */
const recording = signal<{ recording: Recording; mode: number } | null>(null);
const waiting = signal(false);

const triggerUnit = (): Shown => shownIn(state.value?.mode ?? 0, triggerSignal.value);

/** The bridge takes SI units, the person those of the plots. */
function triggerText(): string {
  const { factor, offset } = triggerUnit();
  return `${triggerSignal.value}${triggerSign.value}${Number(((triggerValue.value - offset) / factor).toPrecision(9))}`;
}

async function record(): Promise<void> {
  waiting.value = true;
  try {
    const trigger = triggerSignal.value === '' ? '' : triggerText();
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
  waiting.value = false;
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
        <SignalField title="Duration" unit="s" number={seconds} testid="record-seconds" />
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
            <SignalField title="Level" unit={triggerUnit().unit} number={triggerValue} testid="trigger-value" />
            <SignalField title="Before it" unit="s" number={before} testid="record-before" />
          </>
        )}
        <button
          type="button"
          class="big"
          data-testid="record"
          onClick={() => void record()}
          disabled={
            link.value !== 'open' || readOnly.value || waiting.value || chosen.value.length === 0 || !!activity
          }>
          {waiting.value ? (triggerSignal.value === '' ? 'Recording …' : 'Waiting for the trigger …') : 'Record'}
        </button>
      </div>
      {recording.value && <Recorded {...recording.value} />}
    </section>
  );
}

function Recorded({ recording: shown, mode }: { recording: Recording; mode: number }) {
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const times = shown.rows.map((_, row) => row * shown.period_s);
    const samples = new ArraySamples(
      times,
      Object.fromEntries(shown.signals.map((name) => [name, column(shown, name)])),
    );
    const extent: [number, number] = [0, Math.max(shown.period_s, times.at(-1) ?? 0)];
    const group = new PlotGroup({ x: 'seconds', extent: () => extent });
    const units = [...new Set(shown.signals.map((name) => shownIn(mode, name).unit))];
    const plots = units.map((unit, n) => {
      const names = shown.signals.filter((name) => shownIn(mode, name).unit === unit);
      return new TimePlot(
        place.current!,
        group,
        {
          id: `record-${unit || 'none'}`,
          title: sentence(names.map(plain).join(', ')),
          unit,
          height: 130,
          ...(n === units.length - 1 ? { xLabel: 'time in s' } : {}),
          series: names.map((name, k) => ({
            key: name,
            label: plain(name),
            role: roleOf(name, k),
            ...shownIn(mode, name),
            unit: '',
          })),
        },
        samples,
      );
    });
    return () => plots.forEach((plot) => plot.destroy());
  }, [shown]);
  return (
    <div data-testid="recorded">
      <div class="bar">
        <span>
          {shown.rows.length} rows, one each {formatNumber(1e3 * shown.period_s)} ms
        </span>
        <span class="spring" />
        <SaveButtons recording={shown} />
      </div>
      <div class="plots" ref={place} />
    </div>
  );
}
