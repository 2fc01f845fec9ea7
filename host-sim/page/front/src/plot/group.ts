// Plots that show the same stretch of one x axis, and a cursor at the same place.

import { type Drawn, requestDraw } from './frames';

export interface GroupOptions {
  /** How x is written: seconds of a run, Unix seconds as time of day, or any other number. */
  x: 'seconds' | 'clock' | 'number';
  unit?: string; ///< of x where it is a number
  log?: boolean;
  /** First and last x there is, or null. */
  extent: () => [number, number] | null;
  /** Shows the last so many seconds, and moves with the newest sample until somebody zooms. */
  follow_s?: number;
  smallest?: number; ///< shortest stretch that can be zoomed to
}

export type Side = 'left' | 'right';

export interface Member extends Drawn {
  /** The cursor has moved, or has gone (null), by another plot or by this one. */
  cursorMoved(x: number | null): void;
  hasRightAxis(): boolean;
  /** Width that its labels need there. */
  axisSize(side: Side): number;
}

/** What a plot shows of its axes, as gestures change it: the stretch of a group, or a box of its own. */
export interface Zoom {
  readonly options: GroupOptions;
  readonly vertical: boolean; ///< whether gestures change y as well
  zoom(x: [number, number], y: [number, number]): void;
  /** Closer by a factor below 1, around a place that stays where it is. */
  zoomAt(factor: number, x: number, y: number): void;
  /** Moves by shares of what is shown. */
  pan(right: number, up: number): void;
  reset(): void;
  setCursor(x: number | null): void;
  /** Moves the cursor by a share of what is shown, which it does not leave. */
  stepCursor(share: number): void;
  hasRightAxis(): boolean;
  /** Width that all plots with this x axis need for their labels there; 0 where each has its own. */
  axisSize(side: Side): number;
}

export class PlotGroup implements Drawn, Zoom {
  readonly vertical = false;
  readonly members = new Set<Member>();
  cursor: number | null = null;
  private shown: [number, number] | null = null;
  private follows: boolean;
  private readonly listeners = new Set<() => void>();

  constructor(readonly options: GroupOptions) {
    this.follows = options.follow_s !== undefined;
  }

  add(member: Member): void {
    this.members.add(member);
  }
  remove(member: Member): void {
    this.members.delete(member);
  }

  /** Calls `changed` after a zoom, a pan, a reset, or a change of what is followed. */
  onChange(changed: () => void): () => void {
    this.listeners.add(changed);
    return () => this.listeners.delete(changed);
  }

  get following(): boolean {
    return this.follows;
  }
  get zoomed(): boolean {
    return this.shown !== null;
  }
  get follow_s(): number {
    return this.options.follow_s ?? 0;
  }

  /** Another length of the stretch that is followed. */
  follow(seconds: number): void {
    this.options.follow_s = seconds;
    this.follows = true;
    this.shown = null;
    this.changed();
  }

  /** Stands still where it is. */
  pause(): void {
    this.shown = this.range();
    this.follows = false;
    this.changed();
  }

  /** What is shown now. */
  range(): [number, number] {
    if (this.shown) {
      return this.shown;
    }
    const all = this.options.extent() ?? [0, 1];
    if (this.follows) {
      return [all[1] - this.follow_s, all[1]];
    }
    return all[1] > all[0] ? all : [all[0] - 0.5, all[0] + 0.5];
  }

  zoom([from, to]: [number, number]): void {
    const all = this.options.extent();
    const smallest = this.options.smallest ?? 1e-6 * Math.max(Math.abs(from), Math.abs(to), 1e-6);
    if (!(to - from >= smallest) || !Number.isFinite(to - from)) {
      return;
    }
    const live = this.options.follow_s !== undefined;
    if (all && !live) {
      const width = Math.min(to - from, all[1] - all[0]);
      from = Math.min(Math.max(from, all[0]), all[1] - width);
      to = from + width;
    }
    this.shown = [from, to];
    this.follows = false;
    this.changed();
  }

  zoomAt(factor: number, x: number): void {
    const [from, to] = this.range();
    if (this.options.log) {
      const at = Math.log(x);
      const scaled = (end: number): number => Math.exp(at + (Math.log(end) - at) * factor);
      this.zoom([scaled(from), scaled(to)]);
    } else {
      this.zoom([x + (from - x) * factor, x + (to - x) * factor]);
    }
  }

  pan(share: number): void {
    const [from, to] = this.range();
    if (this.options.log) {
      const factor = (to / from) ** share;
      this.zoom([from * factor, to * factor]);
    } else {
      this.zoom([from + (to - from) * share, to + (to - from) * share]);
    }
  }

  reset(): void {
    this.shown = null;
    this.follows = this.options.follow_s !== undefined;
    this.changed();
  }

  setCursor(x: number | null): void {
    if (x === this.cursor) {
      return;
    }
    this.cursor = x;
    for (const member of this.members) {
      member.cursorMoved(x);
    }
  }

  stepCursor(share: number): void {
    const [from, to] = this.range();
    const at = this.cursor ?? (from + to) / 2;
    this.setCursor(Math.min(to, Math.max(from, at + share * (to - from))));
  }

  /** There are new samples, or the picture is another one. */
  invalidate(): void {
    requestDraw(this);
  }

  draw(): void {
    for (const member of this.members) {
      member.draw();
    }
  }

  /** All plots keep room for a right axis when one has it: their x axes stay in line. */
  hasRightAxis(): boolean {
    for (const member of this.members) {
      if (member.hasRightAxis()) {
        return true;
      }
    }
    return false;
  }

  /** All axes on a side are as wide as the widest, for the same reason. */
  axisSize(side: Side): number {
    let most = 0;
    for (const member of this.members) {
      most = Math.max(most, member.axisSize(side));
    }
    return most;
  }

  private changed(): void {
    this.invalidate();
    for (const listener of this.listeners) {
      listener();
    }
  }
}
