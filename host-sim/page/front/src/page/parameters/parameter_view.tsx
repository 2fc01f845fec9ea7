import { signal } from '@preact/signals';
import { countOf, find, type Group, isChanged, treeOf } from '../../parameters/tree';
import type { ParameterInfo } from '../../protocol/bridge';
import { description, own } from '../../session/session';
import { drafted, favourites, nameOf, trySeconds } from '../../session/tuning';
import { isStrings, saved } from '../../session/saved';
import { EditBar } from './edit_bar';
import { FilesCard } from './files_card';
import { HistoryCard } from './history_card';
import { ParameterRow } from './parameter_row';

type Only = 'all' | 'changed' | 'favourites' | 'edited';
const search = signal('');
const only = signal<Only>('all');
const opened = saved<string[]>('groups', ['strain'], isStrings);

const filters: [Only, string][] = [
  ['all', 'All'],
  ['changed', 'Changed'],
  ['favourites', 'Favourites'],
  ['edited', 'Edited'],
];

export function ParameterView() {
  const all = description.value?.parameters ?? [];
  if (all.length === 0) {
    return <p class="soft pad">The parameters have not been read yet.</p>;
  }
  const filtered = search.value.trim() !== '' || only.value !== 'all';
  const found = find(all, { text: search.value, shown: (info) => nameOf(info.name), only: chosen(only.value) });
  return (
    <div class="two-columns">
      <section aria-label="Parameters">
        <div class="bar wrap">
          <input
            type="search"
            class="search"
            placeholder="Search name, meaning, unit"
            aria-label="Search parameters"
            data-testid="search"
            value={search.value}
            onInput={(event) => {
              search.value = event.currentTarget.value;
            }}
          />
          <div class="segments" role="group" aria-label="Show">
            {filters.map(([which, text]) => (
              <button
                type="button"
                key={which}
                aria-pressed={only.value === which}
                data-testid={`only-${which}`}
                onClick={() => {
                  only.value = which;
                }}>
                {text}
              </button>
            ))}
          </div>
          <span class="soft" data-testid="found">
            {found.length} of {all.length}
          </span>
        </div>
        <div class="tree" data-testid="tree">
          {treeOf(found).groups.map((group) => (
            <Branch key={group.path} group={group} open={filtered} />
          ))}
          {found.length === 0 && <p class="soft pad">No parameter fits.</p>}
        </div>
      </section>
      <aside class="side" aria-label="Edits">
        <section class="card sticky">
          <h2>Edits</h2>
          <p class="soft small-text">Enter tries an edit, Ctrl Enter writes it. A trial reverts by itself.</p>
          <label class="field">
            <span>Try for</span>
            <select
              value={String(trySeconds.value)}
              data-testid="try-seconds"
              onChange={(event) => {
                trySeconds.value = Number(event.currentTarget.value);
              }}>
              {[10, 30, 60, 300].map((seconds) => (
                <option key={seconds} value={String(seconds)}>
                  {seconds} s
                </option>
              ))}
            </select>
          </label>
          <EditBar />
        </section>
        <HistoryCard />
        <FilesCard />
      </aside>
    </div>
  );
}

function chosen(which: Only): (info: ParameterInfo) => boolean {
  switch (which) {
    case 'changed':
      return (info) => isChanged(info, own.value[info.name]);
    case 'favourites':
      return (info) => favourites.value.includes(info.name);
    case 'edited':
      return (info) => info.name in drafted.value.values || info.name in drafted.value.refused;
    default:
      return () => true;
  }
}

/** A filter opens all branches. */
function Branch({ group, open }: { group: Group; open: boolean }) {
  const isOpen = open || opened.value.includes(group.path);
  const changed = changedIn(group);
  const toggle = (): void => {
    opened.value = isOpen ? opened.value.filter((path) => path !== group.path) : [...opened.value, group.path];
  };
  return (
    <div class="branch">
      <button
        type="button"
        class="branch-head"
        aria-expanded={isOpen}
        data-testid={`group-${group.path}`}
        disabled={open}
        onClick={toggle}>
        <span class="chevron" aria-hidden="true">
          {isOpen ? '▾' : '▸'}
        </span>
        <span class="branch-name">{group.path}</span>
        <span class="soft">{countOf(group)}</span>
        {changed > 0 && <span class="mark">{changed} changed</span>}
      </button>
      {isOpen && (
        <div class="branch-body">
          {group.parameters.map((info) => (
            <ParameterRow key={info.name} info={info} />
          ))}
          {group.groups.map((child) => (
            <Branch key={child.path} group={child} open={open} />
          ))}
        </div>
      )}
    </div>
  );
}

function changedIn(group: Group): number {
  const here = group.parameters.filter((info) => isChanged(info, own.value[info.name])).length;
  return group.groups.reduce((sum, child) => sum + changedIn(child), here);
}
