// The steps of the guide in which a current flows.

import { useState } from 'preact/hooks';
import { hotSpotText } from '../../live/display';
import { formatNumber } from '../../numbers/format';
import { lowerBound } from '../../numbers/samples';
import { type Quantity, quantityText } from '../../numbers/units';
import { defaultGainsText } from '../../parameters/gains';
import { sayError } from '../../session/notices';
import { act, call, feed, hotSpotMargin_K, mayWrite, node, own, state } from '../../session/session';
import { units } from '../../session/units';
import { NumberField } from '../fields/number_field';
import { allowed } from '../state/drive';
import { column as columnOf, type Run, runs } from '../step/runs';
import { cold_ohm, statistics, type Statistics, stroke_m } from './checks';
import { amount, found, Read, saidText, type Said } from './findings';

const readIn = (quantity: Quantity, value: number, digits = 4): string =>
  quantityText(quantity, value, units.value, digits);

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
  const error = read ? read.mean / ohm - 1 : NaN;
  return (
    <>
      <p>
        A resistor in the place of the wire shows whether the readings are right before anything can be overheated. It
        must bear the current, and be between {formatNumber(low, 3)} and {formatNumber(high, 3)} Ω, or the servo refuses
        it as a wrong wire. It is measured with the minimum current, {readIn('A', least_A)}.
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
              ['Noise', `${readIn('share', read.sd / read.mean, 2)} of it (standard deviation)`],
              ['Against the ohmmeter', readIn('share', error, 2)],
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
            found('resistor', [
              'Read ',
              amount('ohm', read!.mean),
              ' with ',
              amount('ohm', ohm),
              ' connected: ',
              amount('share', error, 2),
              ' off.',
            ])
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
  moved_m: number;
  asked_m: number;
  hottest_K: number;
}

/** A tenth of the stroke, for two seconds, and back. */
export function HeatStep() {
  const asked_um = Math.round(0.1e6 * stroke_m(own.value));
  const asked = readIn('m', asked_um * 1e-6);
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
      await call('target', { node: which, value: asked_um });
      await wait(2500);
      const { ring } = feed.peek();
      const range = { low: NaN, high: NaN };
      ring.column('hot_spot_K')?.range(lowerBound(ring, (ring.last_s ?? 0) - 2.5), ring.end, range);
      setHeated({
        cold_ohm: before.ohm,
        hot_ohm: recent('resistance_ohm', 0.5).mean,
        moved_m: recent('position_m', 0.5).mean - before.m,
        asked_m: asked_um * 1e-6,
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
        Mount the wire with its load. It is heated for the first time: a tenth of its stroke, {asked}, for two and a
        half seconds. Watch it, with a finger at the space bar.
      </p>
      <div class="bar wrap">
        <EnableButton />
        <button
          type="button"
          disabled={!enabled || busy || !mayWrite.value || !(asked_um > 0)}
          data-testid="heat"
          onClick={() => void heat()}>
          {busy ? 'Heating …' : `Move by ${asked}`}
        </button>
      </div>
      <WhyNot />
      {heated && (
        <>
          <Read
            rows={[
              ['Resistance', `${formatNumber(heated.cold_ohm)} Ω before, ${formatNumber(heated.hot_ohm)} Ω warm`],
              ['Contraction, estimated', `${readIn('m', heated.moved_m, 3)} of ${readIn('m', heated.asked_m)}`],
              ['Hot spot, estimated', `${readIn('K', heated.hottest_K)} at most; limit ${readIn('K', limit)}`],
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
            found('heat', [
              'Asked ',
              amount('m', heated!.asked_m),
              ', estimated ',
              amount('m', heated!.moved_m, 3),
              ', hot spot up to ',
              amount('K', heated!.hottest_K),
              '. You said that the wire moved.',
            ])
          }>
          It moved
        </button>
      </div>
    </>
  );
}

export function TuneStep() {
  const last = runs.value.find((run) => run.node === node.value);
  const said = (quantity: Quantity, value: number | null | undefined): Said[number] =>
    value === null || value === undefined ? 'not reached' : amount(quantity, value, 3);
  const text = (quantity: Quantity, value: number | null | undefined): string => saidText([said(quantity, value)]);
  const overshoot = (run: Run): number | null =>
    run.figures.overshoot_percent === null ? null : run.figures.overshoot_percent / 100;
  const about = defaultGainsText(own.value);
  return (
    <>
      <p>
        Run a step test, try other gains, run it again: the runs are laid over each other. <code>host-sim tune</code>{' '}
        proposes gains for a wire.
      </p>
      {about && <p>{about}</p>}
      {last ? (
        <Read
          rows={[
            [
              'Last step test',
              `${new Date(last.at_ms).toLocaleTimeString('en-GB')}, ${readIn('m', last.amplitude_um * 1e-6)}, ${columnOf(last.recording, 'setpoint').length} samples`,
            ],
            ['Rise', text('response_s', last.figures.rise_s)],
            ['Settling', text('response_s', last.figures.settling_s)],
            ['Overshoot', text('share', overshoot(last))],
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
            found('tune', [
              'Last step: rise ',
              said('response_s', last!.figures.rise_s),
              ', overshoot ',
              said('share', overshoot(last!)),
              '.',
            ])
          }>
          Good enough
        </button>
      </div>
    </>
  );
}
