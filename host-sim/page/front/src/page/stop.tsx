// The stop: a button that is always in sight, the space bar, and Escape.

import { signal } from '@preact/signals';
import { stop } from '../session/session';

const pressed = signal(false);

export function pressStop(): void {
  pressed.value = true;
  setTimeout(() => {
    pressed.value = false;
  }, 400);
  void stop();
}

function isTyping(target: EventTarget | null): boolean {
  if (!(target instanceof HTMLElement)) {
    return false;
  }
  if (target.isContentEditable || target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement) {
    return true;
  }
  return target instanceof HTMLInputElement && !['range', 'checkbox', 'radio', 'button', 'file'].includes(target.type);
}

/** Escape stops wherever it is pressed; the space bar, too, on a button as well, but where somebody types. */
export function listenForStop(): void {
  addEventListener(
    'keydown',
    (event) => {
      if (event.repeat || event.ctrlKey || event.metaKey || event.altKey) {
        return;
      }
      if (event.key !== 'Escape' && (event.key !== ' ' || isTyping(event.target))) {
        return;
      }
      event.preventDefault();
      event.stopPropagation();
      pressStop();
    },
    true,
  );
  // A button acts when the space bar is let go.
  addEventListener(
    'keyup',
    (event) => {
      if (event.key === ' ' && !isTyping(event.target)) {
        event.preventDefault();
      }
    },
    true,
  );
}

export function StopButton() {
  return (
    <button
      type="button"
      class={`stop${pressed.value ? ' pressed' : ''}`}
      onClick={pressStop}
      data-testid="stop"
      aria-label="Stop: switch all servos off"
      aria-keyshortcuts="Space Escape">
      <span class="stop-sign" aria-hidden="true" />
      <span>Stop</span>
      <kbd>space</kbd>
    </button>
  );
}
