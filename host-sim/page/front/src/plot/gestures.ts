// What mouse, fingers and keys do to a plot. Drag: zoom; Shift and drag, or one finger: move; wheel with
// Ctrl, or after a click into the plot, or two fingers: zoom; double click or tap: all. A wheel over a plot
// that nobody has clicked scrolls the page, as everywhere.

export interface GestureTarget {
  readonly over: HTMLElement; ///< area inside the axes
  /** Moves by pixels. */
  pan(dx: number, dy: number): void;
  /** Closer by a factor below 1 around a place in pixels. */
  zoomAt(left: number, top: number, factor: number): void;
  reset(): void;
  pointAt(left: number | null, top: number): void;
  /** Moves the cursor by a share of the width. */
  step(share: number): void;
  active(): boolean;
}

export function listen(root: HTMLElement, target: GestureTarget): void {
  wheel(target);
  touch(target);
  shiftDrag(target);
  target.over.addEventListener('dblclick', () => target.reset());
  root.addEventListener('keydown', (event) => {
    if (event.target === root && key(event, target)) {
      event.preventDefault();
    }
  });
}

function key(event: KeyboardEvent, target: GestureTarget): boolean {
  if (event.ctrlKey || event.altKey || event.metaKey) {
    return false;
  }
  const box = target.over.getBoundingClientRect();
  switch (event.key) {
    case 'ArrowLeft':
    case 'ArrowRight': {
      const sign = event.key === 'ArrowLeft' ? -1 : 1;
      if (event.shiftKey) {
        target.pan(-sign * box.width * 0.1, 0);
      } else {
        target.step(sign * 0.01);
      }
      return true;
    }
    case '+':
    case '=':
      target.zoomAt(box.width / 2, box.height / 2, 0.7);
      return true;
    case '-':
      target.zoomAt(box.width / 2, box.height / 2, 1 / 0.7);
      return true;
    case '0':
    case 'Home':
      target.reset();
      return true;
    default:
      return false;
  }
}

function wheel(target: GestureTarget): void {
  target.over.addEventListener(
    'wheel',
    (event) => {
      if (!event.ctrlKey && !target.active()) {
        return;
      }
      event.preventDefault();
      const box = target.over.getBoundingClientRect();
      const lines = event.deltaMode === 1 ? event.deltaY * 16 : event.deltaY;
      if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
        target.pan(-(event.deltaX || lines), 0);
      } else {
        const factor = Math.exp(Math.max(-120, Math.min(120, lines)) * 0.0025);
        target.zoomAt(event.clientX - box.left, event.clientY - box.top, factor);
      }
    },
    { passive: false },
  );
}

function shiftDrag(target: GestureTarget): void {
  let last: PointerEvent | null = null;
  target.over.addEventListener('pointerdown', (event) => {
    if (event.pointerType !== 'mouse' || !event.shiftKey || event.button !== 0) {
      return;
    }
    last = event;
    target.over.setPointerCapture(event.pointerId);
  });
  target.over.addEventListener('pointermove', (event) => {
    if (!last) {
      return;
    }
    target.pan(event.clientX - last.clientX, event.clientY - last.clientY);
    last = event;
  });
  const end = (): void => {
    last = null;
  };
  target.over.addEventListener('pointerup', end);
  target.over.addEventListener('pointercancel', end);
}

interface Finger {
  x: number;
  y: number;
}

/** The style of the area is `touch-action: pan-y`: the page still scrolls by a finger that moves up. */
function touch(target: GestureTarget): void {
  const fingers = new Map<number, Finger>();
  let tapped = 0;
  let moved = false;
  const place = (event: PointerEvent): Finger => ({ x: event.clientX, y: event.clientY });
  target.over.addEventListener('pointerdown', (event) => {
    if (event.pointerType !== 'touch') {
      return;
    }
    fingers.set(event.pointerId, place(event));
    moved = false;
  });
  target.over.addEventListener('pointermove', (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) {
      return;
    }
    const now = place(event);
    if (Math.hypot(now.x - before.x, now.y - before.y) > 3) {
      moved = true;
    }
    const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
    if (other) {
      const box = target.over.getBoundingClientRect();
      const distance = (finger: Finger): number => Math.max(20, Math.abs(finger.x - other.x));
      const middle = (now.x + other.x) / 2 - box.left;
      target.zoomAt(middle, (now.y + other.y) / 2 - box.top, distance(before) / distance(now));
    } else if (moved) {
      target.pan(now.x - before.x, 0);
    }
    if (moved) {
      fingers.set(event.pointerId, now);
    }
  });
  const end = (event: PointerEvent): void => {
    const finger = fingers.get(event.pointerId);
    if (!finger) {
      return;
    }
    fingers.delete(event.pointerId);
    if (moved || event.type === 'pointercancel') {
      return;
    }
    const box = target.over.getBoundingClientRect();
    target.pointAt(finger.x - box.left, finger.y - box.top);
    if (event.timeStamp - tapped < 300) {
      target.reset();
    }
    tapped = event.timeStamp;
  };
  target.over.addEventListener('pointerup', end);
  target.over.addEventListener('pointercancel', end);
}
