// What the servo does now, and what it is asked: enable, mode, target.

import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks';
import { hotSpotText, shownAs } from '../../live/display';
import { formatNumber } from '../../numbers/format';
import { formatCelsius, zero_degC_K } from '../../numbers/temperature';
import type { State } from '../../protocol/bridge';
import { sayError } from '../../session/notices';
import { go } from '../../session/route';
import { act, call, description, feed, hotSpotMargin_K, mayWrite, node, own, state } from '../../session/session';
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
        const shown = shownAs(signal);
        const value = ring.end > ring.first ? (ring.column(signal)?.at(ring.end - 1) ?? NaN) : NaN;
        const element = places.current[signal];
        const text = formatNumber(shown.factor * value + shown.offset);
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
              <small>{shownAs(signal).unit}</small>
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

interface Bounds {
  unit: string;
  low: number;
  high: number;
  /** How a person reads it, where that is not in this unit. */
  also?: (value: number) => string;
}

/** Of a range: as it is sent, and as it is read. */
function boundsText({ unit, low, high, also }: Bounds): string {
  const text = `${formatNumber(low, 5)} to ${formatNumber(high, 5)} ${unit}`;
  return also ? `${text} (${also(low)} to ${also(high)})` : text;
}

const coolest_K = zero_degC_K + 20; // that the slider asks for: no wire is colder than the air

/** What the limits of the servo allow to ask for. */
function boundsOf(mode: number): Bounds | null {
  const of = (name: string): number => Number(own.value[name] ?? NaN);
  switch (mode) {
    case 1:
    case 8: {
      const um = (strain: number): number => (of('axis.zero_strain') - strain) * of('wire.length_m') * 1e6;
      return { unit: 'µm', low: Math.min(0, um(of('limits.max_strain'))), high: um(of('limits.min_strain')) };
    }
    case 4:
    case 10:
      return { unit: '0.1 %', low: 0, high: 1000 };
    case -1:
      return { unit: 'A', low: 0, high: of('limits.current_A') };
    case -2:
      return { unit: 'W', low: 0, high: of('limits.power_W') };
    case -3:
      // Of the wire's middle: its hottest spot is to stay below the limit.
      return {
        unit: 'K',
        low: coolest_K,
        high: of('limits.temperature_K') - hotSpotMargin_K.value,
        also: formatCelsius,
      };
    default:
      return null;
  }
}

const homing = 6; // mode of operation
const pause_ms = 60; // between the targets of a slider that is moved

function Target({ now }: { now: State }) {
  const bounds = boundsOf(now.mode);
  const [typed, setTyped] = useState<string | null>(null);
  const [dragged, setDragged] = useState<number | null>(null);
  const sent = useRef(0);
  // A number that is being typed is of this unit; it is not taken away by a mode that has the same.
  useLayoutEffect(() => {
    setTyped(null);
    setDragged(null);
  }, [bounds?.unit, now.node]);
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
        This mode takes no target. Profile position moves the wire by µm.
      </p>
    );
  }
  const send = (value: number): void => {
    sent.current = Date.now();
    call('target', { node: now.node, value }).catch((error) => sayError(error));
  };
  const slider = Number.isFinite(bounds.low) && bounds.high > bounds.low;
  const number = typed === null ? NaN : Number(typed.replace(',', '.'));
  const step = slider ? 10 ** Math.floor(Math.log10((bounds.high - bounds.low) / 200)) : 1;
  const asked = typed === null ? (dragged ?? now.target ?? NaN) : number;
  const also = asked >= bounds.low ? bounds.also?.(asked) : undefined;
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
          Target <small>{bounds.unit}</small>
        </span>
        <span class="with-button">
          <input
            type="text"
            inputMode="decimal"
            data-testid="target"
            disabled={!ready}
            value={typed ?? (dragged !== null ? formatPlain(dragged) : formatPlain(now.target))}
            aria-invalid={typed !== null && !Number.isFinite(number)}
            onInput={(event) => setTyped(event.currentTarget.value)}
          />
          <button type="submit" data-testid="go" disabled={!ready || !Number.isFinite(number)}>
            Go
          </button>
        </span>
      </label>
      {also && (
        <span class="also" data-testid="target-also">
          = {also}
        </span>
      )}
      {slider && (
        <input
          type="range"
          aria-label={`Target in ${bounds.unit}`}
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

function formatPlain(value: number | null): string {
  return value === null ? '' : formatNumber(value, 6).replace('−', '-');
}
