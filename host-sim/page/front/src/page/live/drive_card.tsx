// What the servo does now, and what it is asked: enable, mode, target.

import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks';
import { hotSpotText, shownAs } from '../../live/display';
import { formatNumber } from '../../numbers/format';
import { fromShown, scaleOf, type Shown, tidy, toShown, type Units, zero_degC_K } from '../../numbers/units';
import type { State } from '../../protocol/bridge';
import { sayError } from '../../session/notices';
import { go } from '../../session/route';
import { act, call, description, feed, hotSpotMargin_K, mayWrite, node, own, state } from '../../session/session';
import { units } from '../../session/units';
import { Why } from '../fields/why';
import { allowed, driveNames } from '../state/drive';

export function DriveCard() {
  const now = state.value;
  if (!now) {
    return (
      <section class="card">
        <h2>Servo</h2>
        <p class="soft">No state has been read yet.</p>
      </section>
    );
  }
  const may = allowed(now);
  const enabled = now.drive === 'operation_enabled';
  return (
    <section class="card" aria-label="Drive">
      <div class="card-head">
        <h2>{driveNames[now.drive]}</h2>
        <span class="soft">{now.nmt}</span>
      </div>
      <Readings />
      <Blocked now={now} />
      <div class="bar">
        {enabled ? (
          <button
            type="button"
            class="big"
            data-testid="disable"
            disabled={!mayWrite.value}
            onClick={() => void act('disable', { node: node.value })}>
            Disable
          </button>
        ) : (
          <button
            type="button"
            class="big primary"
            data-testid="enable"
            disabled={!mayWrite.value || !may.enable}
            onClick={() => void act('enable', { node: node.value })}>
            Enable
          </button>
        )}
        {may.reset && (
          <button
            type="button"
            class="big"
            data-testid="reset-faults"
            disabled={!mayWrite.value}
            onClick={() => void act('reset_faults', { node: node.value })}>
            Reset faults
          </button>
        )}
      </div>
      <Mode now={now} />
      <Target now={now} />
    </section>
  );
}

function Blocked({ now }: { now: State }) {
  const faults = now.latched.length > 0 ? now.latched : now.blocking;
  if (faults.length === 0) {
    return null;
  }
  return (
    <p class="blocked" data-testid="blocked">
      {now.latched.length > 0 ? 'Fault: ' : 'Cannot be enabled: '}
      {faults.join(', ')}.{' '}
      <button type="button" class="link" onClick={() => go('state')}>
        What to check
      </button>
    </p>
  );
}

const readings = [
  ['position_m', 'Position'],
  ['strain', 'Strain'],
  ['hot_spot_K', 'Hot spot'],
  ['drive_current_A', 'Current'],
] as const;

/** Written ten times a second, past the virtual DOM. */
function Readings() {
  const places = useRef<Record<string, HTMLElement | null>>({});
  const [explained, setExplained] = useState(false);
  useEffect(() => {
    const timer = setInterval(() => {
      const { ring } = feed.peek();
      for (const [signal] of readings) {
        const shown = shownAs(signal, units.peek());
        const value = ring.end > ring.first ? (ring.column(signal)?.at(ring.end - 1) ?? NaN) : NaN;
        const element = places.current[signal];
        // Small numbers of SI have zeros enough.
        const number = toShown(shown, value);
        const text = formatNumber(number, Math.abs(number) < 1e-3 ? 3 : 4);
        if (element && element.textContent !== text) {
          element.textContent = text;
        }
      }
    }, 100);
    return () => clearInterval(timer);
  }, []);
  return (
    <>
      <dl class="readings">
        {readings.map(([signal, title]) => (
          <div key={signal}>
            <dt>
              {title}
              {signal === 'hot_spot_K' && (
                <Why about={title} open={explained} set={setExplained} testid="why-hot-spot" />
              )}
            </dt>
            <dd>
              <span
                ref={(element) => {
                  places.current[signal] = element;
                }}
                data-testid={`reading-${signal}`}>
                –
              </span>
              <small>{shownAs(signal, units.value).unit}</small>
            </dd>
          </div>
        ))}
      </dl>
      {explained && (
        <p class="soft small-text" data-testid="hot-spot-text">
          {hotSpotText(hotSpotMargin_K.value)}
        </p>
      )}
    </>
  );
}

function Mode({ now }: { now: State }) {
  const modes = description.value?.modes ?? [];
  return (
    <label class="field">
      <span>Mode</span>
      <select
        value={String(now.mode)}
        disabled={!mayWrite.value}
        data-testid="mode"
        onChange={(event) => void act('mode', { node: node.value, mode: Number(event.currentTarget.value) })}>
        {!modes.some((one) => one.mode === now.mode) && (
          <option value={String(now.mode)}>{now.mode_name || 'none'}</option>
        )}
        {modes.map((one) => (
          <option key={one.mode} value={String(one.mode)}>
            {one.name}
          </option>
        ))}
      </select>
    </label>
  );
}

/** Of targets, as they are sent. */
interface Bounds {
  scale: Shown; ///< in which a person reads them
  low: number;
  high: number;
}

function boundsText({ scale, low, high }: Bounds): string {
  const text = (value: number): string => formatNumber(toShown(scale, value), 5);
  return `${text(low)} to ${text(high)} ${scale.unit}`.trimEnd();
}

/** A scale of numbers that are sent in another unit than that of SI, of `unit` times it. */
function sentIn(unit: number, scale: Shown): Shown {
  return { ...scale, factor: tidy(scale.factor * unit) };
}

const coolest_K = zero_degC_K + 20; // that the slider asks for: no wire is colder than the air

/** What the limits of the servo allow to ask for. */
function boundsOf(mode: number, choice: Units): Bounds | null {
  const of = (name: string): number => Number(own.value[name] ?? NaN);
  switch (mode) {
    case 1:
    case 8: {
      const um = (strain: number): number => (of('axis.zero_strain') - strain) * of('wire.length_m') * 1e6;
      return {
        scale: sentIn(1e-6, scaleOf('m', choice)),
        low: Math.min(0, um(of('limits.max_strain'))),
        high: um(of('limits.min_strain')),
      };
    }
    case 4:
    case 10:
      return { scale: sentIn(1e-3, scaleOf('share', choice)), low: 0, high: 1000 };
    case -1:
      return { scale: scaleOf('A', choice), low: 0, high: of('limits.current_A') };
    case -2:
      return { scale: scaleOf('W', choice), low: 0, high: of('limits.power_W') };
    case -3:
      // Of the wire's middle: its hottest spot is to stay below the limit.
      return {
        scale: scaleOf('K', choice),
        low: coolest_K,
        high: of('limits.temperature_K') - hotSpotMargin_K.value,
      };
    default:
      return null;
  }
}

const homing = 6; // mode of operation
const pause_ms = 60; // between the targets of a slider that is moved

function Target({ now }: { now: State }) {
  const bounds = boundsOf(now.mode, units.value);
  const [typed, setTyped] = useState<string | null>(null);
  const [dragged, setDragged] = useState<number | null>(null);
  const sent = useRef(0);
  // A number that is being typed is of this unit; it is not taken away by a mode that has the same.
  const unit = bounds?.scale.unit;
  useLayoutEffect(() => {
    setTyped(null);
    setDragged(null);
  }, [unit, now.node]);
  if (now.mode === homing) {
    return (
      <button
        type="button"
        data-testid="home"
        disabled={!mayWrite.value || now.drive !== 'operation_enabled'}
        onClick={() => void act('target', { node: now.node, value: 0 })}>
        Begin homing
      </button>
    );
  }
  if (!bounds) {
    return (
      <p class="soft small-text" data-testid="no-target">
        This mode takes no target. Profile position moves the wire.
      </p>
    );
  }
  const send = (value: number): void => {
    sent.current = Date.now();
    call('target', { node: now.node, value }).catch((error) => sayError(error));
  };
  const slider = Number.isFinite(bounds.low) && bounds.high > bounds.low;
  const { scale } = bounds;
  const number = typed === null || typed.trim() === '' ? NaN : fromShown(scale, Number(typed.replace(',', '.')));
  const step = slider ? 10 ** Math.floor(Math.log10((bounds.high - bounds.low) / 200)) : 1;
  const ready = mayWrite.value && now.drive === 'operation_enabled';
  return (
    // The slider may stand beside its steps, which Firefox takes for a reason not to submit.
    <form
      class="target"
      noValidate
      onSubmit={(event) => {
        event.preventDefault();
        if (!Number.isFinite(number)) {
          return;
        }
        send(number);
        setTyped(null);
      }}>
      <label class="field">
        <span>
          Target <small>{scale.unit}</small>
        </span>
        <span class="with-button">
          <input
            type="text"
            inputMode="decimal"
            data-testid="target"
            disabled={!ready}
            value={typed ?? formatPlain(scale, dragged ?? now.target)}
            aria-invalid={typed !== null && !Number.isFinite(number)}
            onInput={(event) => setTyped(event.currentTarget.value)}
          />
          <button type="submit" data-testid="go" disabled={!ready || !Number.isFinite(number)}>
            Go
          </button>
        </span>
      </label>
      {slider && (
        <input
          type="range"
          aria-label={scale.unit ? `Target in ${scale.unit}` : 'Target'}
          aria-valuetext={`${formatPlain(scale, dragged ?? now.target)} ${scale.unit}`}
          data-testid="target-slider"
          disabled={!ready}
          min={bounds.low}
          max={bounds.high}
          step={step}
          value={dragged ?? now.target ?? 0}
          onInput={(event) => {
            const value = Number(event.currentTarget.value);
            setTyped(null);
            setDragged(value);
            if (Date.now() - sent.current > pause_ms) {
              send(value);
            }
          }}
          onChange={(event) => {
            send(Number(event.currentTarget.value));
            setTimeout(() => setDragged(null), 600);
          }}
        />
      )}
      <p class="soft small-text">
        {slider && `Within the limits: ${boundsText(bounds)}. `}
        {now.drive !== 'operation_enabled'
          ? 'Enable the servo first.'
          : now.target_reached
            ? 'Reached.'
            : 'On the way.'}
      </p>
    </form>
  );
}

function formatPlain(scale: Shown, value: number | null): string {
  return value === null ? '' : formatNumber(toShown(scale, value), 6).replace('−', '-');
}
