import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import {
  bridge,
  client,
  description,
  feed,
  hotSpotMargin_K,
  link,
  liveGroup,
  node,
  state,
} from '../../session/session';
import { isNumber, saved } from '../../session/saved';
import { units } from '../../session/units';
import { Arrange } from './arrange';
import { DriveCard } from './drive_card';
import { FavouritesCard } from './favourites_card';
import { arranging, ownPanels, panels, places } from './panels';
import { PlotPanel } from './plot_panel';

const spans: [number, string][] = [
  [5, '5 s'],
  [10, '10 s'],
  [30, '30 s'],
  [120, '2 min'],
  [600, '10 min'],
];
const span = saved<number>('span_s', 30, isNumber);
const follows = signal(true);

export function LiveView() {
  useEffect(() => {
    liveGroup.follow(span.peek());
    follows.value = true;
    return liveGroup.onChange(() => {
      follows.value = liveGroup.following;
    });
  }, []);
  const all = panels(state.value?.mode ?? 1, ownPanels.value, hotSpotMargin_K.value, units.value);
  const shown = places(all).filter((place) => place.shown);
  return (
    <div class="live">
      <section class="plots-side" aria-label="Plots">
        <div class="bar">
          <TimeControls />
          <span class="spring" />
          <Rate />
          <button
            type="button"
            aria-expanded={arranging.value}
            data-testid="arrange"
            onClick={() => {
              arranging.value = !arranging.value;
            }}>
            Arrange plots
          </button>
        </div>
        {arranging.value && <Arrange all={all} />}
        <div class="plots" data-testid="plots">
          {shown.map((place) => {
            const panel = all.find((one) => one.id === place.id)!;
            return <PlotPanel key={`${node.value}/${place.id}`} panel={panel} half={place.half} />;
          })}
          {shown.length === 0 && <p class="soft">No plot is chosen. “Arrange plots” has them all.</p>}
        </div>
      </section>
      <aside class="side" aria-label="Servo">
        <DriveCard />
        <FavouritesCard />
      </aside>
    </div>
  );
}

function TimeControls() {
  const choose = (seconds: number): void => {
    span.value = seconds;
    liveGroup.follow(seconds);
  };
  return (
    <div class="segments" role="group" aria-label="Time shown">
      {spans.map(([seconds, text]) => (
        <button
          type="button"
          key={seconds}
          data-testid={`span-${seconds}`}
          aria-pressed={follows.value && span.value === seconds}
          onClick={() => choose(seconds)}>
          {text}
        </button>
      ))}
      <button
        type="button"
        class="pause"
        data-testid="pause"
        aria-pressed={!follows.value}
        onClick={() => (follows.value ? liveGroup.pause() : liveGroup.reset())}>
        {follows.value ? 'Pause' : 'Go on'}
      </button>
    </div>
  );
}

/** How much comes, and what is known to be missing. */
function Rate() {
  const now = state.value;
  if (!now || link.value !== 'open' || !description.value) {
    return null;
  }
  const mine = bridge.value?.clients.find((one) => one.client === client.value);
  const lost = [
    now.gaps > 0 ? `${now.gaps} samples missing on the bus` : '',
    mine && mine.dropped > 0 ? `${mine.dropped} left out for this browser` : '',
  ].filter((text) => text !== '');
  const rate = feed.value.rate_hz || now.rate_hz;
  return (
    <span
      class="soft rate"
      data-testid="rate"
      data-received={feed.value.received}
      title={lost.length > 0 ? lost.join('; ') : 'No sample is known to be missing'}>
      {Math.round(rate)} samples/s{lost.length > 0 && <span class="warn">, {lost.join(', ')}</span>}
    </span>
  );
}
