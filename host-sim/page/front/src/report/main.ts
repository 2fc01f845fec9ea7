// Makes the panels of a report interactive: puts a plot in the place of each picture whose data the page has.
// In print, and where this does not run, the pictures stay.

import uplotCss from 'uplot/dist/uPlot.min.css?inline';
import plotCss from '../plot/plot.css?inline';
import { PlotGroup } from '../plot';
import { AlongPlot } from './along_plot';
import { ascends, type Panel, parsed, pieces } from './data';
import { LoopPlot } from './loop_plot';
import reportCss from './report.css?inline';

/** Whether the panel goes along its x axis, so that a cursor has one value there in each curve. */
function goesAlong(panel: Panel): boolean {
  if (panel.link) {
    return true;
  }
  if (panel.follows || panel.equal) {
    return false;
  }
  return panel.series.every(
    (series) => series.kind === 'spans' || pieces(series.x).every((piece) => ascends(series.x, piece)),
  );
}

/** First and last x of these panels, or what their axes state. */
function extentOf(panels: Panel[]): [number, number] | null {
  let low = Infinity;
  let high = -Infinity;
  for (const panel of panels) {
    for (const series of panel.series) {
      for (const column of series.kind === 'spans' ? [series.x, series.y] : [series.x]) {
        for (const x of column) {
          if (x < low) {
            low = x;
          }
          if (x > high) {
            high = x;
          }
        }
      }
    }
  }
  const { min, max } = panels[0]!.x;
  low = min ?? low;
  high = max ?? high;
  return low <= high ? [low, high] : null;
}

function groupOf(panels: Panel[]): PlotGroup {
  const { x } = panels[0]!;
  const extent = extentOf(panels);
  return new PlotGroup({
    x: x.label?.endsWith(' in s') ? 'seconds' : 'number',
    log: x.log ?? false,
    extent: () => extent,
  });
}

class Groups {
  private readonly named = new Map<string, PlotGroup>();
  readonly all: PlotGroup[] = [];

  constructor(private readonly panels: Panel[]) {}

  of(panel: Panel): PlotGroup {
    const name = panel.link ?? panel.follows;
    const known = name === undefined ? undefined : this.named.get(name);
    if (known) {
      return known;
    }
    const members = this.panels.filter((other) => other.link !== undefined && other.link === name);
    const made = groupOf(members.length > 0 ? members : [panel]);
    if (name !== undefined) {
      this.named.set(name, made);
    }
    this.all.push(made);
    return made;
  }
}

function replace(picture: HTMLImageElement, id: string, panel: Panel, group: PlotGroup): void {
  const place = document.createElement('div');
  place.className = 'interactive';
  picture.after(place);
  picture.parentElement!.classList.add('live');
  try {
    if (goesAlong(panel)) {
      new AlongPlot(place, id, panel, group);
    } else {
      new LoopPlot(place, id, panel, group);
    }
  } catch (error) {
    // The picture shows it as well.
    picture.parentElement!.classList.remove('live');
    place.remove();
    console.error(error);
  }
}

/** How it is used, and the way back. */
function toolbar(groups: PlotGroup[]): HTMLElement {
  const bar = document.createElement('p');
  bar.className = 'hint screen';
  const button = document.createElement('button');
  button.type = 'button';
  button.textContent = 'Show all';
  button.disabled = true;
  button.addEventListener('click', () => groups.forEach((group) => group.reset()));
  for (const group of groups) {
    group.onChange(() => {
      button.disabled = !groups.some((other) => other.zoomed);
    });
  }
  const how = matchMedia('(pointer: coarse)').matches
    ? 'Two fingers zoom, one moves; a double tap shows all.'
    : 'Drag to zoom, double click for all, Shift and drag to move. A click on a name takes a curve off.';
  bar.append(button, how);
  return bar;
}

function start(): void {
  const style = document.createElement('style');
  style.textContent = uplotCss + plotCss + reportCss;
  document.head.append(style);
  document.querySelectorAll<HTMLScriptElement>('script.panels').forEach((element, block) => {
    const panels = parsed(element.textContent ?? '');
    const plots = element.parentElement!;
    const groups = new Groups(panels.filter((panel) => panel !== null));
    plots.querySelectorAll<HTMLElement>(':scope > section').forEach((section, k) => {
      const panel = panels[k];
      const picture = section.querySelector('img');
      if (panel && picture) {
        replace(picture, `${block}-${k}`, panel, groups.of(panel));
      }
    });
    if (groups.all.length > 0 && block === 0) {
      plots.prepend(toolbar(groups.all));
    }
    groups.all.forEach((group) => group.invalidate());
  });
}

start();
