// The colours of a report's page: what its pictures have on paper, and others on a dark screen.

import { onTheme } from '../plot';

const known = new Map<string, string>();
onTheme(() => known.clear());

/** #rrggbb of a role, which the page has as a property, or of a colour itself. */
export function colourOf(name: string): string {
  if (name.startsWith('#')) {
    return name;
  }
  let colour = known.get(name);
  if (colour === undefined) {
    colour = getComputedStyle(document.documentElement).getPropertyValue(`--plot-${name}`).trim() || '#888888';
    known.set(name, colour);
  }
  return colour;
}
