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
let last = 0;

/** An error stays until it is dismissed, other notices for some seconds. */
export function say(text: string, kind: 'error' | 'info' = 'info'): void {
  const same = notices.value.find((notice) => notice.text === text && notice.kind === kind);
  if (same) {
    notices.value = notices.value.map((notice) => (notice === same ? { ...same, times: same.times + 1 } : notice));
    return;
  }
  const id = ++last;
  notices.value = [...notices.value, { id, kind, text, times: 1 }].slice(-most);
  if (kind === 'info') setTimeout(() => dismiss(id), 6000);
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
  notices.value = notices.value.filter((notice) => notice.id !== id);
}

export function sentence(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
