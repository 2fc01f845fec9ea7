// A plot of the live view.

import { effect } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { plain, shownAs } from '../../live/display';
import type { Feed } from '../../live/feed';
import { toShown, type Units } from '../../numbers/units';
import { type Flag, type Line, TimePlot } from '../../plot/time_plot';
import { XYPlot } from '../../plot/xy_plot';
import { description, feed, liveGroup, own } from '../../session/session';
import { units } from '../../session/units';
import { hiddenSeries, type LoopPanel, type Panel, type TimePanel } from './panels';

const trail_s = 20;

export function PlotPanel({ panel, half }: { panel: Panel; half: boolean }) {
  const place = useRef<HTMLDivElement>(null);
  const current = feed.value;
  useEffect(() => {
    const parent = place.current!;
    return panel.kind === 'time' ? timePlot(parent, panel, current) : loopPlot(parent, panel, current, units.peek());
  }, [panel.id, signature(panel), current, units.value]);
  return <div class={`panel${half ? ' half' : ''}`} ref={place} data-testid={`panel-${panel.id}`} />;
}

/** Plots are made anew only when what they show is another thing. */
function signature(panel: Panel): string {
  return panel.kind === 'time'
    ? panel.series.map((series) => `${series.key}/${series.label}/${series.axis}/${series.factor}`).join() + panel.title
    : '';
}

function timePlot(parent: HTMLElement, panel: TimePanel, source: Feed): () => void {
  const known = hiddenSeries.peek();
  const plot = new TimePlot(
    parent,
    liveGroup,
    {
      id: panel.id,
      title: panel.title,
      ...(panel.unit === undefined ? {} : { unit: panel.unit }),
      series: panel.series.map((series) => {
        const hidden = known[`${panel.id}/${series.key}`] ?? series.hidden;
        return hidden === undefined ? series : { ...series, hidden };
      }),
      ...(panel.range ? { range: panel.range } : {}),
      ...(panel.limits ? { flags: () => actingLimits(source) } : {}),
      onToggle: (key, hidden) => {
        hiddenSeries.value = { ...hiddenSeries.peek(), [`${panel.id}/${key}`]: hidden };
      },
    },
    source.ring,
  );
  const end = effect(() => {
    plot.lines = limitLines(panel.id, units.value);
    plot.changed();
  });
  return () => {
    end();
    plot.destroy();
  };
}

function loopPlot(parent: HTMLElement, panel: LoopPanel, source: Feed, choice: Units): () => void {
  const x = shownAs(panel.x, choice);
  const y = shownAs(panel.y, choice);
  const plot = new XYPlot(
    parent,
    liveGroup,
    {
      id: panel.id,
      title: panel.title,
      unit: panel.unit,
      xLabel: panel.xLabel,
      smallest: panel.smallest,
      trail_s,
      xFactor: x.factor,
      xOffset: x.offset,
      yFactor: y.factor,
      yOffset: y.offset,
      loops: [{ key: panel.id, label: panel.title, x: panel.x, y: panel.y, role: 'estimate' }],
    },
    source.ring,
  );
  return () => plot.destroy();
}

function actingLimits(source: Feed): Flag[] {
  const reasons = description.peek()?.signals.find((signal) => signal.name === 'limit_reasons');
  return (reasons?.bits ?? [])
    .map((name) => ({ column: `limit:${name}`, label: `limit: ${plain(name)}` }))
    .filter((flag) => source.ring.column(flag.column) !== undefined);
}

/** Limits of the servo across the plots that they bound. */
function limitLines(id: string, choice: Units): Line[] {
  const line = (name: string, label = 'limit'): Line[] => {
    const y = toShown(shownAs(name, choice), Number(own.value[name] ?? NaN));
    return Number.isNaN(y) ? [] : [{ y, label, role: 'limit' }];
  };
  switch (id) {
    case 'temperature':
      return line('limits.temperature_K', 'limit of the hot spot');
    case 'current':
      return line('limits.current_A');
    case 'power':
      return line('limits.power_W');
    case 'stress':
      return line('limits.stress_Pa');
    default:
      return [];
  }
}
