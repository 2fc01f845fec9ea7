// Which plots are shown, in which order, and plots of one's own.

import { useState } from 'preact/hooks';
import { plain } from '../../live/display';
import { description } from '../../session/session';
import { arrange, arrangeAsFirst, arranging, ownPanels, type Panel, type Place, places } from './panels';

export function Arrange({ all }: { all: readonly Panel[] }) {
  const now = places(all);
  const put = (id: string, change: Partial<Place>): void =>
    arrange(now.map((place) => (place.id === id ? { ...place, ...change } : place)));
  const move = (at: number, by: number): void => {
    const next = [...now];
    const [moved] = next.splice(at, 1);
    next.splice(at + by, 0, moved!);
    arrange(next);
  };
  return (
    <section class="card arrange" aria-label="Arrange plots" data-testid="arrange-panel">
      <ul class="arrange-list">
        {now.map((place, at) => {
          const title = all.find((panel) => panel.id === place.id)?.title ?? place.id;
          return (
            <li key={place.id}>
              <button
                type="button"
                class="toggle"
                aria-pressed={place.shown}
                data-testid={`show-${place.id}`}
                onClick={() => put(place.id, { shown: !place.shown })}>
                {title}
              </button>
              <button
                type="button"
                class="small"
                aria-pressed={place.half}
                title="Half as wide, beside another plot"
                onClick={() => put(place.id, { half: !place.half })}>
                half
              </button>
              <button
                type="button"
                class="small"
                aria-label={`${title}: up`}
                disabled={at === 0}
                onClick={() => move(at, -1)}>
                ↑
              </button>
              <button
                type="button"
                class="small"
                aria-label={`${title}: down`}
                disabled={at === now.length - 1}
                onClick={() => move(at, 1)}>
                ↓
              </button>
              {place.id.startsWith('own-') && (
                <button
                  type="button"
                  class="small"
                  aria-label={`${title}: delete`}
                  onClick={() => {
                    ownPanels.value = ownPanels.value.filter((one) => one.id !== place.id);
                  }}>
                  ×
                </button>
              )}
            </li>
          );
        })}
      </ul>
      <OwnPlot />
      <div class="bar">
        <button type="button" data-testid="arrange-reset" onClick={arrangeAsFirst}>
          As at first
        </button>
        <span class="spring" />
        <button
          type="button"
          class="primary"
          onClick={() => {
            arranging.value = false;
          }}>
          Done
        </button>
      </div>
    </section>
  );
}

type Axis = 'none' | 'left' | 'right';

function OwnPlot() {
  const [axes, setAxes] = useState<Record<string, Axis>>({});
  const [open, setOpen] = useState(false);
  const names = [...(description.value?.signals ?? []).map((signal) => signal.name), 'contraction', 'austenite'];
  const chosen = (axis: Axis): string[] => names.filter((name) => axes[name] === axis);
  const add = (): void => {
    const left = chosen('left');
    const right = chosen('right');
    const title = [...left, ...right].map(plain).join(', ');
    ownPanels.value = [...ownPanels.value, { id: `own-${Date.now().toString(36)}`, title, left, right }];
    setAxes({});
    setOpen(false);
  };
  if (!open) {
    return (
      <button type="button" data-testid="own-plot" onClick={() => setOpen(true)}>
        Plot of other signals …
      </button>
    );
  }
  return (
    <fieldset class="own-plot">
      <legend>Signals of the new plot, and their axis</legend>
      <div class="own-list">
        {names.map((name) => (
          <label key={name} class="own-signal">
            <span title={description.value?.signals.find((signal) => signal.name === name)?.meaning}>
              {plain(name)}
            </span>
            <select
              value={axes[name] ?? 'none'}
              data-testid={`own-${name}`}
              onChange={(event) => setAxes({ ...axes, [name]: event.currentTarget.value as Axis })}>
              <option value="none">–</option>
              <option value="left">left</option>
              <option value="right">right</option>
            </select>
          </label>
        ))}
      </div>
      <div class="bar">
        <button
          type="button"
          class="primary"
          data-testid="own-add"
          onClick={add}
          disabled={chosen('left').length + chosen('right').length === 0}>
          Add the plot
        </button>
        <button type="button" onClick={() => setOpen(false)}>
          Cancel
        </button>
      </div>
    </fieldset>
  );
}
