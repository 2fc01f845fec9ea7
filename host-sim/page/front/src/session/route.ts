// Which view the page shows: the end of its address.

import { signal } from '@preact/signals';

export const at = signal(location.hash.slice(1));

export function go(view: string): void {
  location.hash = view;
}
