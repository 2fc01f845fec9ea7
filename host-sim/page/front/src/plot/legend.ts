// The head of a plot: its title, and a button for each series with its value under the cursor, which takes
// the series off and puts it back.

import { formatNumber } from '../numbers/format';
import { type Role, theme, translucent } from './theme';

export type Style = 'line' | 'dashed' | 'steps' | 'points' | 'band' | 'stack';

export interface LegendItem {
  key: string;
  label: string;
  role: Role;
  colour?: () => string; ///< instead of the role's
  style: Style;
  unit?: string;
  hidden?: boolean;
}

export type Toggled = (key: string, hidden: boolean) => void;

export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  className: string,
  text = '',
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  made.className = className;
  if (text) {
    made.textContent = text;
  }
  return made;
}

export class Legend {
  readonly root = element('div', 'plot-head');
  readonly hidden = new Set<string>();
  private readonly values = new Map<string, HTMLElement>();
  private readonly swatches: [HTMLElement, LegendItem][] = [];

  constructor(title: string, unit: string | undefined, items: LegendItem[], toggled: Toggled) {
    const heading = element('div', 'plot-title', title);
    if (unit) {
      heading.append(element('span', 'plot-unit', unit));
    }
    const keys = element('div', 'plot-keys');
    for (const item of items) {
      keys.append(this.button(item, toggled));
    }
    this.root.append(heading, keys);
    this.colour();
  }

  /** Writes a value; NaN as nothing. */
  show(key: string, value: number | string): void {
    const place = this.values.get(key);
    if (!place) {
      return;
    }
    const text = typeof value === 'string' ? value : Number.isNaN(value) ? '' : formatNumber(value);
    if (place.textContent !== text) {
      place.textContent = text;
    }
  }

  colour(): void {
    for (const [swatch, item] of this.swatches) {
      const colour = item.colour?.() ?? theme()[item.role];
      const area = item.style === 'band' || item.style === 'stack';
      swatch.style.background =
        item.style === 'dashed'
          ? `repeating-linear-gradient(90deg, ${colour} 0 4px, transparent 4px 6px)`
          : area
            ? translucent(colour, item.style === 'band' ? 0.28 : 0.75)
            : colour;
    }
  }

  private button(item: LegendItem, toggled: Toggled): HTMLElement {
    const button = element('button', 'plot-key');
    button.type = 'button';
    button.dataset['key'] = item.key;
    const swatch = element('span', `plot-swatch plot-swatch-${item.style}`);
    this.swatches.push([swatch, item]);
    const value = element('span', 'plot-value');
    this.values.set(item.key, value);
    button.append(swatch, element('span', 'plot-label', item.label), value);
    if (item.unit) {
      button.append(element('span', 'plot-unit', item.unit));
    }
    const set = (off: boolean): void => {
      if (off) {
        this.hidden.add(item.key);
      } else {
        this.hidden.delete(item.key);
      }
      button.setAttribute('aria-pressed', String(!off));
      button.title = off ? `Show ${item.label}` : `Hide ${item.label}`;
    };
    set(item.hidden ?? false);
    button.addEventListener('click', () => {
      set(!this.hidden.has(item.key));
      toggled(item.key, this.hidden.has(item.key));
    });
    return button;
  }
}
