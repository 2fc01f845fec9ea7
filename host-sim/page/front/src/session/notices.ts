// What is said to the person in front of the page.

import { signal } from '@preact/signals';

export interface Notice {
  id: number;
  kind: 'error' | 'info';
  text: string;
  times: number;
}

export const notices = signal<Notice[]>([]);

const most = 4;
const shown_ms = 6000;
let last = 0;
const ends = new Map<number, ReturnType<typeof setTimeout>>();

/** An error stays until it is dismissed, other notices for some seconds after they were last said. */
export function say(text: string, kind: 'error' | 'info' = 'info'): void {
  const same = notices.value.find((notice) => notice.text === text && notice.kind === kind);
  if (same) {
    notices.value = notices.value.map((notice) => (notice === same ? { ...same, times: same.times + 1 } : notice));
    if (kind === 'info') {
      endLater(same.id);
    }
    return;
  }
  const id = ++last;
  notices.value = [...notices.value, { id, kind, text, times: 1 }].slice(-most);
  if (kind === 'info') {
    endLater(id);
  }
}

function endLater(id: number): void {
  clearTimeout(ends.get(id));
  ends.set(
    id,
    setTimeout(() => dismiss(id), shown_ms),
  );
}

export function sayError(error: unknown, before = ''): void {
  const text = error instanceof Error ? error.message : String(error);
  say(before ? `${before}: ${text}` : sentence(text), 'error');
}

/** The bridge calls what it was sent "the file"; the person knows its name. */
export function sayFileError(error: unknown, file: string): void {
  const text = error instanceof Error ? error.message : String(error);
  say(text.startsWith('the file:') ? file + text.slice('the file'.length) : `${file}: ${text}`, 'error');
}

export function dismiss(id: number): void {
  clearTimeout(ends.get(id));
  ends.delete(id);
  notices.value = notices.value.filter((notice) => notice.id !== id);
}

export function sentence(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
