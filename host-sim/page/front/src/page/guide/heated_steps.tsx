// The steps of the guide in which a current flows.

import { useState } from 'preact/hooks';
import { hotSpotText } from '../../live/display';
import { formatNumber } from '../../numbers/format';
import { lowerBound } from '../../numbers/samples';
import { formatCelsius } from '../../numbers/temperature';
import { sayError } from '../../session/notices';
import { act, call, feed, hotSpotMargin_K, mayWrite, node, own, state } from '../../session/session';
import { NumberField } from '../fields/number_field';
import { allowed } from '../state/drive';
import { column as columnOf, runs } from '../step/runs';
import { cold_ohm, statistics, type Statistics, stroke_m } from './checks';
import { found, Read } from './findings';

/** The samples of the last seconds that were really received. */
function recent(signal: string, seconds: number): Statistics {
  const { ring } = feed.peek();
  const last = ring.last_s;
  const column = ring.column(signal);
  if (last === null || !column) {
    return { mean: NaN, sd: NaN, count: 0 };
  }
  const values: number[] = [];
  for (let row = lowerBound(ring, last - seconds); row < ring.end; ++row) {
    values.push(column.at(row));
  }
  return statistics(values);
}

const wait = (ms: number): Promise<void> => new Promise((resolve) => setTimeout(resolve, ms));

function EnableButton() {
  const now = state.value;
  const may = allowed(now);
  if (now?.drive === 'operation_enabled') {
    return (
      <button type="button" disabled={!mayWrite.value} onClick={() => void act('disable', { node: node.value })}>
        Disable
      </button>
    );
  }
  return (
    <button
      type="button"
      class="primary"
      disabled={!mayWrite.value || !may.enable}
      onClick={() => void act('enable', { node: node.value })}>
      Enable
    </button>
  );
}

function WhyNot() {
  const now = state.value;
  const faults = now && (now.latched.length > 0 ? now.latched : now.blocking);
  if (!faults || faults.length === 0) {
    return null;
  }
  return (
    <p class="refused">
      Cannot be enabled: {faults.join(', ')}. <a href="#state">What to check</a>
    </p>
  );
}

const currentMode = -1; // mode of operation

export function ResistorStep() {
  const expected = cold_ohm(own.value);
  const low = expected * Number(own.value['trips.resistance_low'] ?? NaN);
  const high = expected * Number(own.value['trips.resistance_high'] ?? NaN);
  const [ohm, setOhm] = useState(Number(formatNumber(expected, 2)) || 20);
  const [read, setRead] = useState<Statistics | null>(null);
  const [busy, setBusy] = useState(false);
  const least_A = Number(own.value['limits.min_current_A'] ?? NaN);
  const enabled = state.value?.drive === 'operation_enabled';
  const measure = async (): Promise<void> => {
    setRead(null);
    setBusy(true);
    try {
      // Of a servo that has no mode yet no current flows; of one in the mode of current the least that is asked for.
      if (state.value?.mode !== currentMode) {
        await call('mode', { node: node.value, mode: currentMode });
      }
      await call('target', { node: node.value, value: 0 });
      await wait(1600);
      setRead(recent('resistance_ohm', 1));
    } catch (error) {
      sayError(error, 'Measuring');
    }
    setBusy(false);
  };
  const error = read ? 100 * (read.mean / ohm - 1) : NaN;
  return (
    <>
      <p>
        A resistor in the place of the wire shows whether the readings are right before anything can be overheated. It
        must bear the current, and be between {formatNumber(low, 3)} and {formatNumber(high, 3)} Ω, or the servo refuses
        it as a wrong wire. It is measured with the minimum current, {formatNumber(1e3 * least_A)} mA.
      </p>
      <div class="bar wrap ends">
        <NumberField title="By an ohmmeter" unit="Ω" value={ohm} set={setOhm} testid="resistor-ohm" />
        <EnableButton />
        <button
          type="button"
          disabled={!enabled || busy || !mayWrite.value}
          data-testid="measure"
          onClick={() => void measure()}>
          {busy ? 'Measuring …' : 'Measure for 1 s'}
        </button>
      </div>
      <WhyNot />
      {read &&
        (read.count === 0 ? (
          <p class="refused">No resistance was read in that second: too little current flows.</p>
        ) : (
          <Read
            rows={[
              ['Read', `${formatNumber(read.mean)} Ω, mean of ${read.count} samples`],
              ['Noise', `${formatNumber((100 * read.sd) / read.mean, 2)} % of it (standard deviation)`],
              ['Against the ohmmeter', `${formatNumber(error, 2)} %`],
            ]}
          />
        ))}
      <div class="bar wrap">
        <button
          type="button"
          class="primary"
          disabled={!read || !(read.count > 0)}
          data-testid="guide-resistor-done"
          onClick={() =>
            found(
              'resistor',
              `Read ${formatNumber(read!.mean)} Ω with ${formatNumber(ohm)} Ω connected: ${formatNumber(error, 2)} % off.`,
            )
          }>
          Go on
        </button>
        <button
          type="button"
          onClick={() => found('resistor', 'Left out: the readings were not compared with a resistor.')}>
          Leave it out
        </button>
      </div>
    </>
  );
}

interface Heated {
  cold_ohm: number;
  hot_ohm: number;
  moved_um: number;
  asked_um: number;
  hottest_K: number;
}

/** A tenth of the stroke, for two seconds, and back. */
export function HeatStep() {
  const asked = Math.round(0.1e6 * stroke_m(own.value));
  const [busy, setBusy] = useState(false);
  const [heated, setHeated] = useState<Heated | null>(null);
  const enabled = state.value?.drive === 'operation_enabled';
  const heat = async (): Promise<void> => {
    setBusy(true);
    setHeated(null);
    const which = node.value;
    try {
      if (state.value?.mode !== 1) {
        await call('mode', { node: which, mode: 1 });
      }
      await call('target', { node: which, value: 0 });
      await wait(1500);
      const before = { ohm: recent('resistance_ohm', 0.5).mean, m: recent('position_m', 0.5).mean };
      await call('target', { node: which, value: asked });
      await wait(2500);
      const { ring } = feed.peek();
      const range = { low: NaN, high: NaN };
      ring.column('hot_spot_K')?.range(lowerBound(ring, (ring.last_s ?? 0) - 2.5), ring.end, range);
      setHeated({
        cold_ohm: before.ohm,
        hot_ohm: recent('resistance_ohm', 0.5).mean,
        moved_um: 1e6 * (recent('position_m', 0.5).mean - before.m),
        asked_um: asked,
        hottest_K: range.high,
      });
      await call('target', { node: which, value: 0 });
    } catch (error) {
      sayError(error, 'First heating');
    }
    setBusy(false);
  };
  const limit = Number(own.value['limits.temperature_K'] ?? NaN);
  return (
    <>
      <p>
        Mount the wire with its load. It is heated for the first time: a tenth of its stroke, {asked} µm, for two and a
        half seconds. Watch it, with a finger at the space bar.
      </p>
      <div class="bar wrap">
        <EnableButton />
        <button
          type="button"
          disabled={!enabled || busy || !mayWrite.value || !(asked > 0)}
          data-testid="heat"
          onClick={() => void heat()}>
          {busy ? 'Heating …' : `Move by ${asked} µm`}
        </button>
      </div>
      <WhyNot />
      {heated && (
        <>
          <Read
            rows={[
              ['Resistance', `${formatNumber(heated.cold_ohm)} Ω before, ${formatNumber(heated.hot_ohm)} Ω warm`],
              ['Contraction, estimated', `${formatNumber(heated.moved_um, 3)} µm of ${heated.asked_um} µm`],
              [
                'Hot spot, estimated',
                `${formatCelsius(heated.hottest_K, 3)} at most; limit ${formatCelsius(limit, 3)}`,
              ],
            ]}
          />
          <p class="soft">{hotSpotText(hotSpotMargin_K.value)}</p>
          <p>The estimate says so. Did the wire move by about as much? Only you can see that.</p>
        </>
      )}
      <div class="bar">
        <button
          type="button"
          class="primary"
          disabled={!heated}
          data-testid="guide-heat-done"
          onClick={() =>
            found(
              'heat',
              `Asked ${heated!.asked_um} µm, estimated ${formatNumber(heated!.moved_um, 3)} µm, hot spot up to ${formatCelsius(heated!.hottest_K, 3)}. You said that the wire moved.`,
            )
          }>
          It moved
        </button>
      </div>
    </>
  );
}

export function TuneStep() {
  const last = runs.value.find((run) => run.node === node.value);
  const text = (value: number | null, factor: number, unit: string): string =>
    value === null || value === undefined ? 'not reached' : `${formatNumber(factor * value, 3)} ${unit}`;
  return (
    <>
      <p>
        Run a step test, try other gains, run it again: the runs are laid over each other. <code>host-sim tune</code>{' '}
        proposes gains for a wire.
      </p>
      {last ? (
        <Read
          rows={[
            [
              'Last step test',
              `${new Date(last.at_ms).toLocaleTimeString('en-GB')}, ${last.amplitude_um} µm, ${columnOf(last.recording, 'setpoint').length} samples`,
            ],
            ['Rise', text(last.figures.rise_s, 1e3, 'ms')],
            ['Settling', text(last.figures.settling_s, 1e3, 'ms')],
            ['Overshoot', text(last.figures.overshoot_percent, 1, '%')],
          ]}
        />
      ) : (
        <p class="soft">No step test has been run on this servo yet.</p>
      )}
      <div class="bar">
        <a class="button primary" href="#step">
          To the step test
        </a>
        <button
          type="button"
          disabled={!last}
          data-testid="guide-tune-done"
          onClick={() =>
            found(
              'tune',
              `Last step: rise ${text(last!.figures.rise_s, 1e3, 'ms')}, overshoot ${text(last!.figures.overshoot_percent, 1, '%')}.`,
            )
          }>
          Good enough
        </button>
      </div>
    </>
  );
}
