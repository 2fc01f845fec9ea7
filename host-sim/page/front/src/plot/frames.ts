// One animation frame for everything that wants to be drawn.

export interface Drawn {
  draw(): void;
}

const dirty = new Set<Drawn>();
const late: Drawn[] = [];
let pending = 0;

/** Draws it in the next frame, once however often it is asked for. */
export function requestDraw(drawn: Drawn): void {
  dirty.add(drawn);
  if (pending === 0) {
    pending = requestAnimationFrame(drawAll);
  }
}

export function cancelDraw(drawn: Drawn): void {
  dirty.delete(drawn);
}

function drawAll(): void {
  pending = 0;
  late.push(...dirty);
  dirty.clear();
  for (const drawn of late) {
    drawn.draw();
  }
  late.length = 0;
}

/** At once: before a page is printed. */
export function drawNow(): void {
  if (pending !== 0) {
    cancelAnimationFrame(pending);
  }
  drawAll();
}
