// One parameter: its value to edit, unit, range, meaning, and how it differs from default or file.

import { useState } from 'preact/hooks';
import { gainText } from '../../parameters/gains';
import { isChanged } from '../../parameters/tree';
import { editText, rangeText, readText, unitOf, unitText } from '../../parameters/values';
import type { ParameterInfo } from '../../protocol/bridge';
import { mayWrite, own, state } from '../../session/session';
import {
  draft,
  drafted,
  draftText,
  favourites,
  named,
  nameOf,
  toggleFavourite,
  tryDrafts,
  writeDrafts,
} from '../../session/tuning';
import { units } from '../../session/units';
import { Why } from '../fields/why';

interface RowProps {
  info: ParameterInfo;
  compact?: boolean; ///< an explanation opens by a '?'
  explained?: boolean; ///< it is open at first
}

export function ParameterRow({ info, compact = false, explained = !compact }: RowProps) {
  const [open, setOpen] = useState(explained);
  const value = own.value[info.name];
  const typed = draftText(info);
  const name = nameOf(info.name);
  const { unit } = unitOf(info, units.value);
  const refused = drafted.value.refused[info.name];
  const differs = info.name in drafted.value.values;
  const changed = isChanged(info, value);
  const star = favourites.value.includes(info.name);
  const id = `value-${compact ? 'f-' : ''}${info.name}`;
  const running = state.value?.drive === 'operation_enabled';
  const locked = !mayWrite.value || (info.change === 'not enabled' && running);
  const note = named(gainText(info.name, { ...own.value, ...drafted.value.values }));
  return (
    <div
      class={`parameter${differs ? ' drafted' : ''}${compact ? ' compact' : ''}`}
      data-testid={`parameter-${info.name}`}>
      <div class="parameter-name">
        <button
          type="button"
          class="star"
          aria-pressed={star}
          data-testid={`star-${info.name}`}
          aria-label={`${name}: favourite`}
          onClick={() => toggleFavourite(info.name)}>
          {star ? '★' : '☆'}
        </button>
        <label for={id} title={`${name}: ${named(info.meaning)}`}>
          {compact ? shortName(name, unit) : name.slice(name.lastIndexOf('.') + 1)}
        </label>
        {note && compact && <Why about={name} open={open} set={setOpen} testid={`why-${info.name}`} />}
        {changed && (
          <span
            class="mark"
            title={`default: ${readText(info, info.default, units.value)}`}
            data-testid={`changed-${info.name}`}>
            changed
          </span>
        )}
        {info.change !== 'live' && !compact && (
          <span class="mark quiet" title={changeTitle[info.change]}>
            {info.change}
          </span>
        )}
      </div>
      <div class="parameter-value">
        <Editor
          info={info}
          id={id}
          text={typed ?? editText(info, value, units.value)}
          disabled={locked}
          refused={refused}
        />
        <span class="unit" data-testid={`unit-${info.name}`}>
          {unitText(unit)}
        </span>
      </div>
      {!compact && (
        <div class="parameter-text">
          <p>{named(info.meaning)}</p>
          <p class="soft">
            {rangeText(info, units.value)}
            {info.default !== null && <>; default {readText(info, info.default, units.value)}</>}
            {info.level && <>; level: {info.level}</>}
          </p>
        </div>
      )}
      {note && open && (
        <p class="note" data-testid={`note-${info.name}`}>
          {note}
        </p>
      )}
      {refused && (
        <p class="refused" role="alert" id={`${id}-why`}>
          {refused}
        </p>
      )}
    </div>
  );
}

/** Without the unit, which stands behind the value. */
function shortName(name: string, unit: string): string {
  const bare = unit && name.endsWith(`_${unit}`) ? name.slice(0, -unit.length - 1) : name;
  return bare.replace('.', ': ').replaceAll('_', ' ');
}

const changeTitle = {
  live: '',
  'not enabled': 'Refused while current may flow: disable the servo first',
  'after reset': 'Stored, and in force from the next start',
};

interface EditorProps {
  info: ParameterInfo;
  id: string;
  text: string;
  disabled: boolean;
  refused: string | undefined;
}

function Editor({ info, id, text, disabled, refused }: EditorProps) {
  const choices = info.type === 'boolean' ? ['true', 'false'] : info.type === 'choice' ? (info.choices ?? []) : null;
  if (choices) {
    return (
      <select
        id={id}
        value={text}
        disabled={disabled}
        onChange={(event) => draft(info.name, event.currentTarget.value)}>
        {!choices.includes(text) && <option value={text}>{text || '–'}</option>}
        {choices.map((choice) => (
          <option key={choice} value={choice}>
            {choice}
          </option>
        ))}
      </select>
    );
  }
  return (
    <input
      id={id}
      type="text"
      inputMode="decimal"
      autocomplete="off"
      spellcheck={false}
      value={text}
      disabled={disabled}
      aria-invalid={refused !== undefined}
      aria-describedby={refused !== undefined ? `${id}-why` : undefined}
      onInput={(event) => draft(info.name, event.currentTarget.value)}
      onKeyDown={(event) => {
        if (event.key === 'Enter') {
          void (event.ctrlKey ? writeDrafts() : tryDrafts());
        }
      }}
    />
  );
}
