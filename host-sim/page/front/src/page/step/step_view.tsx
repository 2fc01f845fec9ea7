import { signal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { shownAs } from '../../live/display';
import { formatNumber } from '../../numbers/format';
import { zero_degC_K } from '../../numbers/temperature';
import { valueText } from '../../parameters/values';
import { PlotGroup } from '../../plot/group';
import { otherRole, theme } from '../../plot/theme';
import { type SeriesSpec, TimePlot } from '../../plot/time_plot';
import type { Recording, StepFigures, Value } from '../../protocol/bridge';
import { say, sayError } from '../../session/notices';
import { isNumber, saved } from '../../session/saved';
import { bridge, call, mayWrite, node, state } from '../../session/session';
import { SignalField } from '../fields/number_field';
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
        <SignalField title="Amplitude" unit="µm" number={amplitude} testid="step-amplitude" />
        <SignalField title="Time of each step" unit="s" number={seconds} testid="step-seconds" />
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
  const key = shown.map((run) => run.id).join();
  useEffect(() => {
    if (shown.length === 0) {
      return undefined;
    }
    const samples = overlay(shown);
    const extent: [number, number] = [samples.x(0), samples.x(samples.end - 1)];
    const group = new PlotGroup({ x: 'seconds', extent: () => extent });
    const plots = pictures.map(({ name, title, height }, n) => {
      const { unit, ...scale } = shownAs(name);
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

function Table() {
  const all = runs.value;
  if (all.length === 0) {
    return null;
  }
  const gains = tellingGains(all);
  const number = (value: number | null | undefined, factor = 1, offset = 0): string =>
    typeof value === 'number' ? formatNumber(factor * value + offset, 3) : 'never';
  return (
    <section class="card">
      <div class="scroll-x">
        <table class="figures" data-testid="runs">
          <thead>
            <tr>
              <th>Run</th>
              <th>At</th>
              <th>
                Step<small>µm</small>
              </th>
              <th>
                Rise<small>ms</small>
              </th>
              <th>
                Settling<small>ms</small>
              </th>
              <th>
                Overshoot<small>%</small>
              </th>
              <th>
                Error<small>%</small>
              </th>
              <th>
                Wire at most<small>°C</small>
              </th>
              {gains.map((name) => (
                <th key={name} title={name}>
                  {name.slice(name.lastIndexOf('.') + 1)}
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
                <td>{formatNumber(run.amplitude_um)}</td>
                <td>{number(run.figures.rise_s, 1e3)}</td>
                <td>{number(run.figures.settling_s, 1e3)}</td>
                <td>{number(run.figures.overshoot_percent)}</td>
                <td>{number(run.figures.error_percent)}</td>
                <td>{number(run.figures.peak_K, 1, -zero_degC_K)}</td>
                {gains.map((name) => (
                  <td key={name}>{valueText(run.gains[name])}</td>
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
    </section>
  );
}
