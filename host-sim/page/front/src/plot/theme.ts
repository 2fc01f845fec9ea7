// Colours of what is drawn, light and dark. They can be told apart with the common kinds of colour
// blindness (after Okabe and Ito); lines that matter together also differ in dash and width.

const light = {
  ink: '#1b2430',
  soft: '#5b6673',
  grid: '#e3e7ec',
  axis: '#b4bcc6',
  ground: '#ffffff',
  estimate: '#0067b1',
  band: '#0067b1',
  reference: '#c44e00',
  setpoint: '#6c7683',
  measured: '#00805b',
  model: '#a8488f',
  error: '#c44e00',
  limit: '#c1121f',
  current: '#0067b1',
  power: '#b07400',
  wanted: '#6c7683',
  temperature: '#c44e00',
  hot_spot: '#c1121f',
  ambient: '#2c8fc9',
  stress: '#a8488f',
  martensite: '#2c8fc9',
  r_phase: '#e8b400',
  austenite: '#d9541e',
  other1: '#0067b1',
  other2: '#c44e00',
  other3: '#00805b',
  other4: '#a8488f',
  other5: '#b07400',
  other6: '#2c8fc9',
  other7: '#6c7683',
  other8: '#1b2430',
};
export type Role = keyof typeof light;
export type Theme = Record<Role, string>;

const dark: Theme = {
  ink: '#e8edf3',
  soft: '#9aa7b5',
  grid: '#2a333e',
  axis: '#4a5665',
  ground: '#161c23',
  estimate: '#58b4ff',
  band: '#58b4ff',
  reference: '#ff9a4d',
  setpoint: '#98a4b2',
  measured: '#35c997',
  model: '#e58fcb',
  error: '#ff9a4d',
  limit: '#ff6b6b',
  current: '#58b4ff',
  power: '#f2c14e',
  wanted: '#98a4b2',
  temperature: '#ff9a4d',
  hot_spot: '#ff6b6b',
  ambient: '#7fd0ff',
  stress: '#e58fcb',
  martensite: '#58b4ff',
  r_phase: '#f2c14e',
  austenite: '#ff8552',
  other1: '#58b4ff',
  other2: '#ff9a4d',
  other3: '#35c997',
  other4: '#e58fcb',
  other5: '#f2c14e',
  other6: '#7fd0ff',
  other7: '#98a4b2',
  other8: '#e8edf3',
};

let prints = false;
let forced: 'light' | 'dark' | null = null;
const listeners = new Set<() => void>();
const system = typeof matchMedia === 'undefined' ? null : matchMedia('(prefers-color-scheme: dark)');
const tell = (): void => listeners.forEach((listener) => listener());
system?.addEventListener('change', tell);
if (typeof addEventListener !== 'undefined') {
  const printing = (now: boolean) => (): void => {
    prints = now;
    if (isDark(false)) {
      tell();
    }
  };
  addEventListener('beforeprint', printing(true));
  addEventListener('afterprint', printing(false));
}

function isDark(onPaper: boolean): boolean {
  if (onPaper) {
    return false;
  }
  return forced ? forced === 'dark' : (system?.matches ?? false);
}

/** The colours now: as the system prefers; paper is always light. */
export const theme = (): Theme => (isDark(prints) ? dark : light);

/** Light or dark whatever the system prefers, until null. */
export function forceTheme(choice: 'light' | 'dark' | null): void {
  forced = choice;
  tell();
}

/** Calls `changed` when the colours have become others; returns what ends that. */
export function onTheme(changed: () => void): () => void {
  listeners.add(changed);
  return () => listeners.delete(changed);
}

/** The colour with an opacity, for areas. */
export function translucent(colour: string, opacity: number): string {
  const part = (at: number): number => parseInt(colour.slice(at, at + 2), 16);
  return `rgba(${part(1)},${part(3)},${part(5)},${opacity})`;
}

/** A colour for the n-th of several alike, where no role fits. */
export function otherRole(n: number): Role {
  return `other${(n % 8) + 1}` as Role;
}
