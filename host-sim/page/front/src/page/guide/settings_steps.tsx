// The steps of the guide that heat nothing.

import { formatNumber } from '../../numbers/format';
import { type Quantity, quantityText } from '../../numbers/units';
import { saveText } from '../../session/download';
import { bridge, call, feed, mayWrite, node, nodes, own, scan, state } from '../../session/session';
import { named, restore, store } from '../../session/tuning';
import { units } from '../../session/units';
import { sayError } from '../../session/notices';
import { type Check, cold_ohm, limitChecks, stroke_m } from './checks';
import { amount, found, Read } from './findings';

export function BusStep() {
  const info = nodes.value.find((one) => one.node === node.value);
  const now = state.value;
  const good = info?.online && !info.duplicate && now !== null && bridge.value?.trouble === '';
  return (
    <>
      <Read
        rows={[
          ['Bus', bridge.value?.bus ?? 'not read'],
          ['Devices', nodes.value.map((one) => `${one.node} (${one.name || 'no name'})`).join(', ') || 'none'],
          ['This servo', info ? `node ${info.node}, ${info.online ? 'answers' : 'does not answer'}` : 'not read'],
          [
            'Samples',
            now ? `${formatNumber(feed.value.rate_hz || now.rate_hz, 3)} a second, ${now.gaps} missing` : 'not read',
          ],
        ]}
      />
      {info?.duplicate && (
        <p class="refused">Two devices answer as node {info.node}. Give one of them another node-id.</p>
      )}
      <div class="bar">
        <button
          type="button"
          class="primary"
          disabled={!good}
          data-testid="guide-bus-done"
          onClick={() => found('bus', `Node ${info!.node} (${info!.name}) answers on ${bridge.value!.bus}.`)}>
          It is this one
        </button>
        <button type="button" onClick={() => void scan()}>
          Scan again
        </button>
      </div>
    </>
  );
}

const has = (name: string): boolean => typeof own.value[name] === 'number';

export function WireStep() {
  const number = (name: string): number => Number(own.value[name] ?? NaN);
  const text = (quantity: Quantity, value: number, digits = 4): string =>
    known ? quantityText(quantity, value, units.value, digits) : 'not configured';
  const known = has('wire.length_m') && has('wire.diameter_m') && !state.value?.blocking.includes('not_configured');
  const load = async (input: HTMLInputElement): Promise<void> => {
    const file = input.files?.[0];
    if (file) {
      await restore(file.name, await file.text());
    }
    input.value = '';
  };
  return (
    <>
      <p>The servo reckons with a certain wire. Compare it with the one that is mounted.</p>
      <Read
        rows={[
          ['Length between the clamps', text('wire_m', number('wire.length_m'))],
          ['Diameter', text('m', number('wire.diameter_m'))],
          ['Nominal stroke', text('m', stroke_m(own.value))],
          ['Nominal stroke, of the length', text('share', number('wire.nominal_stroke'))],
          ['Resistance when cold, by these', text('ohm', cold_ohm(own.value), 3)],
        ]}
      />
      <p class="soft">
        Another wire: make its settings on the PC (<code>host-sim wires</code> lists the built-in ones,{' '}
        <code>host-sim identify</code> measures your own), and write the file here. The servo must be disabled for that.
      </p>
      <div class="bar wrap">
        <button
          type="button"
          class="primary"
          disabled={!known}
          data-testid="guide-wire-done"
          onClick={() =>
            found('wire', [
              'Set for ',
              amount('wire_m', number('wire.length_m')),
              ' of ',
              amount('m', number('wire.diameter_m')),
              ' wire. You said that this is the mounted one.',
            ])
          }>
          This is my wire
        </button>
        <label class="button file-button">
          Write a settings file …
          <input
            type="file"
            accept=".toml,text/plain"
            disabled={!mayWrite.value}
            onChange={(event) => void load(event.currentTarget)}
          />
        </label>
      </div>
    </>
  );
}

export function Checks({ checks }: { checks: Check[] }) {
  return (
    <ul class="checks">
      {checks.map((check) => (
        <li key={check.text} class={check.ok === null ? 'open' : check.ok ? 'yes' : 'no'}>
          <span aria-hidden="true">{check.ok === null ? '?' : check.ok ? '✓' : '✗'}</span>
          <span>
            <span class="hidden">{check.ok === null ? 'Not judged: ' : check.ok ? 'Right: ' : 'Wrong: '}</span>
            {check.text}
          </span>
        </li>
      ))}
    </ul>
  );
}

export function LimitsStep() {
  const { ring } = feed.value;
  const stress = ring.end > ring.first ? (ring.column('stress_Pa')?.at(ring.end - 1) ?? NaN) : NaN;
  const checks = limitChecks(own.value, stress, units.value).map((check) => ({ ...check, text: named(check.text) }));
  const wrong = checks.filter((check) => check.ok === false).length;
  void state.value;
  return (
    <>
      <p>Limits reduce the output; trips are faults. They are compared with each other and with the wire.</p>
      <Checks checks={checks} />
      <div class="bar">
        <button
          type="button"
          class="primary"
          disabled={wrong > 0 || Number.isNaN(stress)}
          data-testid="guide-limits-done"
          onClick={() =>
            found(
              'limits',
              `${checks.filter((check) => check.ok).length} comparisons hold; ${checks.filter((check) => check.ok === null).length} could not be judged by the page.`,
            )
          }>
          Go on
        </button>
        <a class="button" href="#parameters">
          Change limits
        </a>
      </div>
    </>
  );
}

export function KeepStep() {
  const now = state.value;
  const dump = async (): Promise<void> => {
    try {
      saveText(`node${node.value}.toml`, String((await call('dump', { node: node.value, as: 'toml' }))['text']));
    } catch (error) {
      sayError(error);
    }
  };
  return (
    <>
      <p>
        {now?.unsaved
          ? 'The servo has settings that a reset would lose.'
          : 'The servo says that all its settings are stored.'}
      </p>
      <div class="bar wrap">
        {now?.unsaved && (
          <button type="button" class="primary" disabled={!mayWrite.value} onClick={() => void store()}>
            Store
          </button>
        )}
        <button type="button" onClick={() => void dump()}>
          Save a settings file
        </button>
        <button
          type="button"
          class={now?.unsaved ? '' : 'primary'}
          disabled={now === null || now.unsaved}
          data-testid="guide-keep-done"
          onClick={() => found('keep', 'The servo says that its settings are stored.')}>
          Done
        </button>
      </div>
    </>
  );
}
