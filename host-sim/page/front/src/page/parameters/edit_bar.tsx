// What is done with edits: try them for a time, write them, keep or revert a trial, store.

import { useEffect, useState } from 'preact/hooks';
import { mayWrite, state } from '../../session/session';
import {
  discard,
  drafted,
  drafts,
  history,
  historyVersion,
  keep,
  redo,
  revert,
  store,
  tryDrafts,
  trying,
  trySeconds,
  undo,
  writeDrafts,
} from '../../session/tuning';

export function EditBar() {
  const count = Object.keys(drafted.value.values).length;
  const wrong = Object.keys(drafted.value.refused).length;
  const typed = Object.keys(drafts.value).length;
  const may = mayWrite.value;
  void historyVersion.value;
  return (
    <div class="edit-bar" data-testid="edit-bar">
      {trying.value && <Trial />}
      {typed > 0 && (
        <div class="bar">
          <span class="count">
            {count === 1 ? '1 change' : `${count} changes`}
            {wrong > 0 && `, ${wrong} refused`}
          </span>
          <span class="spring" />
          <button
            type="button"
            class="primary"
            data-testid="try"
            disabled={!may || count === 0 || wrong > 0}
            title="In force at once; reverts by itself. Key: Enter"
            onClick={() => void tryDrafts()}>
            Try {trySeconds.value} s
          </button>
          <button
            type="button"
            data-testid="write"
            disabled={!may || trying.value || count === 0 || wrong > 0}
            title="In force at once, until it is changed again. Key: Ctrl Enter"
            onClick={() => void writeDrafts()}>
            Write
          </button>
          <button type="button" data-testid="discard" onClick={discard}>
            Discard
          </button>
        </div>
      )}
      <div class="bar">
        <button
          type="button"
          class="small"
          data-testid="undo"
          disabled={!may || trying.value || !history.value.canUndo}
          onClick={() => void undo()}>
          Undo
        </button>
        <button
          type="button"
          class="small"
          data-testid="redo"
          disabled={!may || trying.value || !history.value.canRedo}
          onClick={() => void redo()}>
          Redo
        </button>
        <span class="spring" />
        {state.value?.unsaved ? (
          <button
            type="button"
            data-testid="store"
            disabled={!may || trying.value}
            title="Keeps the settings over a reset"
            onClick={() => void store()}>
            Store
          </button>
        ) : (
          state.value && <span class="soft">stored</span>
        )}
      </div>
    </div>
  );
}

/** The count-down goes on between the states that the bridge sends. */
function Trial() {
  const left = state.value?.transaction.seconds_left ?? 0;
  const [since, setSince] = useState(Date.now());
  const [now, setNow] = useState(Date.now());
  useEffect(() => {
    setSince(Date.now());
    setNow(Date.now());
    const timer = setInterval(() => setNow(Date.now()), 200);
    return () => clearInterval(timer);
  }, [left]);
  const seconds = Math.max(0, left - (now - since) / 1000);
  return (
    <div class="trial" role="timer" data-testid="trial">
      <div class="trial-bar" style={{ width: `${Math.min(100, (100 * seconds) / Math.max(1, trySeconds.value))}%` }} />
      <span>
        On trial: reverts in <strong data-testid="trial-left">{Math.ceil(seconds)} s</strong>
      </span>
      <span class="spring" />
      <button type="button" class="primary" data-testid="keep" disabled={!mayWrite.value} onClick={() => void keep()}>
        Keep
      </button>
      <button type="button" data-testid="revert" disabled={!mayWrite.value} onClick={() => void revert()}>
        Revert
      </button>
    </div>
  );
}
