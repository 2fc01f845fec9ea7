import { signal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { shownAs } from '../../live/display';
import { formatNumber } from '../../numbers/format';
import { type Quantity, scaleOf, type Shown, tidy, toShown } from '../../numbers/units';
import { readText } from '../../parameters/values';
import { PlotGroup } from '../../plot/group';
import { otherRole, theme } from '../../plot/theme';
import { type SeriesSpec, TimePlot } from '../../plot/time_plot';
import type { Recording, StepFigures, Value } from '../../protocol/bridge';
import { say, sayError } from '../../session/notices';
import { isNumber, saved } from '../../session/saved';
import { bridge, call, mayWrite, node, state } from '../../session/session';
import { infos, nameOf } from '../../session/tuning';
import { units } from '../../session/units';
import { inSeconds, SignalField } from '../fields/number_field';
import { FavouritesCard } from '../live/favourites_card';
import { RecorderCard } from './recorder_card';
import { addRun, overlay, removeRun, type Run, runs, showRun, tellingGains } from './runs';
import { SaveButtons } from './save_buttons';

const amplitude = saved<number>('step_um', 500, isNumber);
const seconds = saved<number>('step_s', 2, isNumber);
const running = signal(false);

export function StepView() {
  return (
    <div class="two-columns">
      <section aria-label="Step test">
        <Form />
        <Overlay />
        <Table />
        <RecorderCard />
      </section>
      <aside class="side" aria-label="Gains">
        <FavouritesCard explained />
      </aside>
    </div>
  );
}

/** The scale of ways that are sent and kept in µm. */
function ofMicrometres(): Shown {
  const scale = scaleOf('m', units.value);
  return { ...scale, factor: tidy(1e-6 * scale.factor) };
}

async function run(): Promise<void> {
  running.value = true;
  try {
    const answer = await call('step', { node: node.value, amplitude_um: amplitude.value, seconds: seconds.value });
    addRun({
      id: Date.now().toString(36),
      at_ms: Date.now(),
      node: node.value ?? 0,
      amplitude_um: amplitude.value,
      seconds: seconds.value,
      recording: answer['recording'] as Recording,
      figures: answer['figures'] as StepFigures,
      gains: (answer['gains'] ?? {}) as Record<string, Value>,
      shown: true,
      thinned: false,
    });
    say('The step test is done.');
  } catch (error) {
    sayError(error, 'Step test');
  }
  running.value = false;
}

function Form() {
  const activity = bridge.value?.activity;
  const mine = activity && activity.node === node.value && activity.service === 'step' ? activity : null;
  const busy = running.value || (activity !== null && activity !== undefined);
  return (
    <form
      class="card"
      onSubmit={(event) => {
        event.preventDefault();
        void run();
      }}>
      <h2>Step test</h2>
      <p class="soft">
        A step of the set-point there and back, from where the wire is. A servo that is off is enabled for the time of
        the test, and heated.
      </p>
      <div class="bar wrap ends">
        <SignalField title="Amplitude" scale={ofMicrometres()} number={amplitude} testid="step-amplitude" />
        <SignalField title="Time of each step" scale={inSeconds} number={seconds} testid="step-seconds" />
        <button
          type="submit"
          class="big primary"
          data-testid="step-run"
          disabled={!mayWrite.value || busy || (state.value?.latched.length ?? 0) > 0}>
          {busy ? 'Running …' : 'Run the step'}
        </button>
      </div>
      {mine && <progress class="progress" max={1} value={mine.progress} aria-label="Progress of the step test" />}
    </form>
  );
}

/** A run keeps its colour: it depends on its place among all, counted from the oldest. */
function roleOfRun(run: Run): ReturnType<typeof otherRole> {
  const ordered = [...runs.value].reverse();
  return otherRole(ordered.findIndex((one) => one.id === run.id));
}

function numberOf(run: Run): number {
  return runs.value.length - runs.value.findIndex((one) => one.id === run.id);
}

const timeLabel = 'time since the step in s';
const pictures = [
  { name: 'position_m', title: 'Contraction', height: 230 },
  { name: 'wire_temperature_K', title: 'Temperature', height: 140 },
  { name: 'drive_current_A', title: 'Current', height: 140 },
];

function Overlay() {
  const place = useRef<HTMLDivElement>(null);
  const shown = runs.value.filter((run) => run.shown);
  const choice = units.value;
  const key = shown.map((run) => run.id).join() + choice;
  useEffect(() => {
    if (shown.length === 0) {
      return undefined;
    }
    const samples = overlay(shown);
    const extent: [number, number] = [samples.x(0), samples.x(samples.end - 1)];
    const group = new PlotGroup({ x: 'seconds', extent: () => extent });
    const plots = pictures.map(({ name, title, height }, n) => {
      const { unit, ...scale } = shownAs(name, choice);
      const lines: SeriesSpec[] = shown.map((run) => ({
        key: `${run.id}/${name}`,
        label: `run ${numberOf(run)}`,
        role: roleOfRun(run),
        ...scale,
        width: run.id === shown[0]!.id ? 2.2 : 1.4,
      }));
      if (name === 'position_m') {
        lines.unshift({
          key: `${shown[0]!.id}/setpoint`,
          label: 'set-point',
          role: 'setpoint',
          style: 'steps',
          ...scale,
        });
      }
      return new TimePlot(
        place.current!,
        group,
        {
          id: `step-${name}`,
          title,
          unit,
          height,
          series: lines,
          ...(n === pictures.length - 1 ? { xLabel: timeLabel } : {}),
        },
        samples,
      );
    });
    return () => plots.forEach((plot) => plot.destroy());
  }, [key]);
  if (runs.value.length === 0) {
    return (
      <p class="empty" data-testid="no-runs">
        No step test has been run yet. Its response is drawn here, over earlier ones.
      </p>
    );
  }
  return <div class="card plots" ref={place} data-testid="step-plots" />;
}

const figures: { title: string; kind: Quantity; of(figures: StepFigures): number | null }[] = [
  { title: 'Rise', kind: 'response_s', of: ({ rise_s }) => rise_s },
  { title: 'Settling', kind: 'response_s', of: ({ settling_s }) => settling_s },
  { title: 'Overshoot', kind: 'share', of: ({ overshoot_percent }) => share(overshoot_percent) },
  { title: 'Error', kind: 'share', of: ({ error_percent }) => share(error_percent) },
  { title: 'Wire at most', kind: 'K', of: ({ peak_K }) => peak_K },
];

function share(percent: number | null): number | null {
  return typeof percent === 'number' ? percent / 100 : null;
}

/** The group above the name. */
function GainName({ name }: { name: string }) {
  const dot = name.lastIndexOf('.') + 1;
  return (
    <>
      <span class="soft">{name.slice(0, dot)}</span>
      <br />
      {name.slice(dot)}
    </>
  );
}

/** What the columns of gains are. */
function gainsText(shown: readonly Run[], gains: readonly string[]): string {
  if (shown.length > 1) {
    return gains.length > 0
      ? 'The columns on the right are the gains and limits in which the shown runs differ. Each file has all of them.'
      : 'All shown runs had the same gains and limits. Each file has them.';
  }
  if (shown.length === 0) {
    return 'No run is shown.';
  }
  return gains.length > 0
    ? 'The columns on the right are the gains of the shown run that are not the default. Each file has all of them.'
    : 'The shown run had the default gains. Each file has them.';
}

function Table() {
  const all = runs.value;
  if (all.length === 0) {
    return null;
  }
  const shown = all.filter((run) => run.shown);
  const gains = tellingGains(shown, infos.value);
  const choice = units.value;
  const columns = figures.map(({ title, kind, of }) => {
    const scale = scaleOf(kind, choice);
    const text = (run: Run): string => {
      const value = of(run.figures);
      return typeof value === 'number' ? formatNumber(toShown(scale, value), 3) : 'never';
    };
    return { title, unit: scale.unit, text };
  });
  const way = ofMicrometres();
  return (
    <section class="card">
      <div class="scroll-x">
        <table class="figures" data-testid="runs">
          <thead>
            <tr>
              <th>Run</th>
              <th>At</th>
              <th>
                Step<small>{way.unit}</small>
              </th>
              {columns.map(({ title, unit }) => (
                <th key={title}>
                  {title}
                  {unit && <small>{unit}</small>}
                </th>
              ))}
              {gains.map((name) => (
                <th key={name} data-testid={`gain-${name}`}>
                  <GainName name={nameOf(name)} />
                </th>
              ))}
              <th>
                <span class="hidden">Save, remove</span>
              </th>
            </tr>
          </thead>
          <tbody>
            {all.map((run) => (
              <tr key={run.id} data-testid="run">
                <td>
                  <button
                    type="button"
                    class="run-key"
                    aria-pressed={run.shown}
                    onClick={() => showRun(run.id, !run.shown)}
                    title={run.shown ? 'Hide this run' : 'Show this run'}>
                    <i
                      style={{
                        background: run.shown ? theme()[roleOfRun(run)] : 'transparent',
                        borderColor: theme()[roleOfRun(run)],
                      }}
                    />
                    {numberOf(run)}
                  </button>
                </td>
                <td class="soft">{new Date(run.at_ms).toLocaleTimeString('en-GB')}</td>
                <td>{formatNumber(toShown(way, run.amplitude_um))}</td>
                {columns.map(({ title, text }) => (
                  <td key={title}>{text(run)}</td>
                ))}
                {gains.map((name) => (
                  <td key={name}>{readText(infos.value.get(name), run.gains[name], choice) || '–'}</td>
                ))}
                <td class="row-buttons">
                  <SaveButtons recording={run.recording} disabled={run.thinned} />
                  <button
                    type="button"
                    class="small"
                    aria-label={`Remove run ${numberOf(run)}`}
                    onClick={() => removeRun(run.id)}>
                    ×
                  </button>
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <p class="soft small-text" data-testid="gains-of-runs">
        {gainsText(shown, gains)}
      </p>
    </section>
  );
}
