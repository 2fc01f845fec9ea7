// What was written, so that it can be taken back: one entry for each set that was written together.

import type { Value } from '../protocol/bridge';
import { sameValue } from './tree';

export interface Change {
  name: string;
  before: Value;
  after: Value;
}

export interface Entry {
  changes: Change[];
  at_ms: number;
  how: string; ///< written, kept after a trial, restored
}

const most = 100;

export class UndoHistory {
  private readonly done: Entry[] = [];
  private readonly undone: Entry[] = [];

  /** Newest first. */
  get entries(): readonly Entry[] {
    return [...this.done].reverse();
  }
  get canUndo(): boolean {
    return this.done.length > 0;
  }
  get canRedo(): boolean {
    return this.undone.length > 0;
  }

  /** Changes that change nothing are left out; a new entry ends what could be done again. */
  record(changes: readonly Change[], how: string, at_ms: number): void {
    const real = changes.filter((change) => !sameValue(change.before, change.after));
    if (real.length === 0) {
      return;
    }
    this.done.push({ changes: real, how, at_ms });
    if (this.done.length > most) {
      this.done.shift();
    }
    this.undone.length = 0;
  }

  /** What must be written to take the last entry back; null: nothing. */
  undo(): Record<string, Value> | null {
    const entry = this.done.at(-1);
    return entry ? Object.fromEntries(entry.changes.map((change) => [change.name, change.before])) : null;
  }
  redo(): Record<string, Value> | null {
    const entry = this.undone.at(-1);
    return entry ? Object.fromEntries(entry.changes.map((change) => [change.name, change.after])) : null;
  }

  /** The servo has taken what undo() said. */
  undid(): void {
    const entry = this.done.pop();
    if (entry) {
      this.undone.push(entry);
    }
  }
  redid(): void {
    const entry = this.undone.pop();
    if (entry) {
      this.done.push(entry);
    }
  }
}
