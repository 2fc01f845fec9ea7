// The optional step of the guide that makes a wire file from a guided run and a person's readings.

import { signal } from '@preact/signals';
import { useEffect, useRef, useState } from 'preact/hooks';
import type { Commission, Commissioned } from '../../protocol/bridge';
import { sameValue } from '../../parameters/tree';
import { saveBase64 } from '../../session/download';
import { sayError, sentence } from '../../session/notices';
import { isNumber, saved } from '../../session/saved';
import { act, call, client, commission, mayWrite, node, own, state } from '../../session/session';
import { named, write } from '../../session/tuning';
import { units } from '../../session/units';
import { above0, NumberField } from '../fields/number_field';
import { heated, isRunning, progressText, readingCounts, resultRows } from './commissioning';
import { amount, found, Read } from './findings';

const readings = saved<number>('commission.readings', 2, (value): value is number =>
  (readingCounts as readonly unknown[]).includes(value),
);
const sd_mm = saved<number>('commission.sd_mm', 0.1, isNumber);
const pace = saved<number>('commission.pace', 1, isNumber);

/** The run whose result was put aside for another one. */
const asideText = signal('');

export function CommissionStep() {
  const run = commission.value;
  const { least_s, most_s } = heated(pace.value, readings.value);
  const ended = run !== null && run.node === node.value;
  const result = ended && run.stage === 'done' && run.result?.text !== asideText.value ? run.result : null;
  const failed = ended && run.stage === 'failed' ? run.error : '';
  return (
    <>
      <p>
        The servo heats the wire in three cycles, {least_s} s in all, and records what it reads; in the first one at
        most 70{'\u00a0'}% of {named('limits.current_A')} flow. You read where the wire's end is, with a caliper or a
        ruler: once while it is cold, then while it is hot and the heat is held for at most 20 s each time. Any scale
        will do: only the distance from the cold reading counts. From the recording and your readings the bridge makes a
        wire file for this piece of wire.
      </p>
      {failed && (
        <>
          <p class="refused" data-testid="commission-error">
            {sentence(failed)}
          </p>
          <Files run={run!} />
        </>
      )}
      {isRunning(run) ? (
        <Running run={run} />
      ) : result ? (
        <Result run={run!} result={result} />
      ) : (
        <Start most_s={most_s} failed={failed} />
      )}
    </>
  );
}

function Start({ most_s, failed }: { most_s: number; failed: string }) {
  const [refused, setRefused] = useState('');
  const enabled = state.value?.drive === 'operation_enabled';
  const start = (): void => {
    setRefused('');
    call('commission', {
      node: node.value,
      readings: readings.value,
      reading_sd_m: sd_mm.value / 1000,
      pace: pace.value,
    }).catch((error: unknown) => setRefused(error instanceof Error ? error.message : String(error)));
  };
  return (
    <form
      onSubmit={(event) => {
        event.preventDefault();
        start();
      }}>
      <div class="bar wrap ends">
        <label class="field narrow">
          <span>Readings of the hot wire</span>
          <select
            value={readings.value}
            data-testid="commission-readings"
            onChange={(event) => {
              readings.value = Number(event.currentTarget.value);
            }}>
            {readingCounts.map((count) => (
              <option key={count} value={count}>
                {count === 0 ? 'none' : count}
              </option>
            ))}
          </select>
        </label>
        <NumberField
          title="Standard deviation of a reading"
          unit="mm"
          value={sd_mm.value}
          set={(value) => {
            sd_mm.value = value;
          }}
          least={above0}
          testid="commission-sd"
        />
        <NumberField
          title="Factor on the durations"
          unit="0.05 to 2"
          value={pace.value}
          set={(value) => {
            pace.value = value;
          }}
          least={above0}
          testid="commission-pace"
        />
      </div>
      <p class="soft">
        {readings.value === 0
          ? 'Without readings the wire file is hardly better than the settings. '
          : `With the readings the heating takes ${most_s} s at most. Before it you have 300 s for the reading of the ` +
            'cold wire; without that one no other is asked for. '}
        A thick wire follows slowly: double the durations for it. Meanwhile no other servo can be commanded. The wire
        becomes hot enough to burn. Escape switches all servos off: keep a finger on it.
      </p>
      {refused && refused !== failed && (
        <p class="refused" data-testid="commission-refused">
          {sentence(refused)}
        </p>
      )}
      <div class="bar wrap">
        {enabled && (
          <button type="button" disabled={!mayWrite.value} onClick={() => void act('disable', { node: node.value })}>
            Disable
          </button>
        )}
        <button type="submit" class="primary" disabled={!mayWrite.value || enabled} data-testid="commission-start">
          Heat and record
        </button>
        <button
          type="button"
          data-testid="guide-commission-left-out"
          onClick={() => found('commission', "Left out: the servo's settings of the wire stay as they are.")}>
          Leave it out
        </button>
      </div>
    </form>
  );
}

function Running({ run }: { run: Commission }) {
  const mine = run.client === client.value;
  return (
    <>
      {run.node !== node.value && <p>The run that goes on is of node {run.node}.</p>}
      <p class="commission-line" role="status" data-testid="commission-line">
        {progressText(run)}
      </p>
      {run.stage === 'asking' && (
        <>
          <p data-testid="commission-said">{sentence(run.said.at(-1) ?? '')}</p>
          {mine && <Question />}
        </>
      )}
      <div class="bar wrap">
        {mine ? (
          <button type="button" data-testid="commission-cancel" onClick={() => void act('commission_cancel')}>
            Cancel
          </button>
        ) : (
          <p class="soft" data-testid="commission-other">
            Client {run.client} leads this run and is asked for the readings. Stop ends it.
          </p>
        )}
      </div>
    </>
  );
}

function Question() {
  const [text, setText] = useState('');
  const [refused, setRefused] = useState('');
  const [busy, setBusy] = useState(false);
  const field = useRef<HTMLInputElement>(null);
  useEffect(() => field.current?.focus(), []);
  const answer = async (request: Record<string, unknown>): Promise<void> => {
    setBusy(true);
    setRefused('');
    try {
      await call('commission_answer', request);
      setText('');
    } catch (error) {
      setRefused(error instanceof Error ? error.message : String(error));
    }
    setBusy(false);
  };
  return (
    <form
      onSubmit={(event) => {
        event.preventDefault();
        if (text.trim() !== '') {
          void answer({ reading: text.trim() });
        }
      }}>
      <div class="bar wrap ends">
        <label class="field narrow">
          <span>
            Displacement <small>mm</small>
          </span>
          <input
            ref={field}
            type="text"
            inputMode="decimal"
            autocomplete="off"
            maxLength={40}
            value={text}
            data-testid="commission-reading"
            onInput={(event) => setText(event.currentTarget.value)}
          />
        </label>
        <button type="submit" class="primary" disabled={busy || text.trim() === ''} data-testid="commission-take">
          Take
        </button>
        <button type="button" disabled={busy} data-testid="commission-skip" onClick={() => void answer({})}>
          Skip
        </button>
      </div>
      {refused && (
        <p class="refused" data-testid="commission-refused">
          {sentence(refused)}
        </p>
      )}
    </form>
  );
}

const fileTitles = { wire: 'Wire file', run: 'Run (CSV)', readings: 'Readings (CSV)' } as const;

function Files({ run }: { run: Commission }) {
  const save = async (as: string): Promise<void> => {
    try {
      const answer = await call('commission_file', { as });
      saveBase64(String(answer['name']), String(answer['base64']));
    } catch (error) {
      sayError(error);
    }
  };
  return run.files.length === 0 ? null : (
    <div class="bar wrap">
      {run.files.map((as) => (
        <button key={as} type="button" data-testid={`commission-file-${as}`} onClick={() => void save(as)}>
          {fileTitles[as]}
        </button>
      ))}
    </div>
  );
}

function Result({ run, result }: { run: Commission; result: Commissioned }) {
  const changed = Object.fromEntries(result.differences.map((one) => [one.name, one.file]));
  const written = Object.entries(changed).every(([name, value]) => sameValue(own.value[name], value));
  const after = result.numbers.expected_error_of_stroke.after.stroke;
  return (
    <>
      <Read rows={resultRows(result, units.value)} />
      {result.notes.length > 0 && (
        <ul data-testid="commission-notes">
          {result.notes.map((note) => (
            <li key={note}>{sentence(note)}.</li>
          ))}
        </ul>
      )}
      <pre class="printed" data-testid="commission-text">
        {result.text}
      </pre>
      <Files run={run} />
      <div class="bar wrap">
        <button
          type="button"
          class={written ? '' : 'primary'}
          disabled={written || !mayWrite.value}
          data-testid="commission-write"
          onClick={() => void write(changed, 'commissioned')}>
          {written
            ? "The servo's settings are this wire file's"
            : `Write ${result.differences.length} parameters to the servo`}
        </button>
        <button
          type="button"
          class={written ? 'primary' : ''}
          data-testid="guide-commission-done"
          onClick={() =>
            found('commission', [
              written ? 'The servo has the wire of this run' : 'A wire file was made',
              ': the expected error of the stroke is ',
              amount('share', after, 2),
              '.',
            ])
          }>
          Go on
        </button>
        <button
          type="button"
          data-testid="commission-again"
          onClick={() => {
            asideText.value = result.text;
          }}>
          Another run
        </button>
      </div>
    </>
  );
}
