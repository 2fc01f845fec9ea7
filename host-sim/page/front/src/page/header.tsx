import { act, bridge, choose, client, control, link, node, nodes, readOnly, state } from '../session/session';
import { signal } from '@preact/signals';
import type { Units } from '../numbers/units';
import { chooseUnits, units } from '../session/units';
import { StopButton } from './stop';
import { driveWords } from './state/drive';

export function Header() {
  return (
    <header class="header">
      <span class="brand">
        <svg viewBox="0 0 16 16" width="20" height="20" aria-hidden="true">
          <path
            d="M1 11c3 0 3-6 7-6s4 6 7 6"
            fill="none"
            stroke="currentColor"
            stroke-width="2.2"
            stroke-linecap="round"
          />
        </svg>
        <span class="brand-name">smaservo</span>
      </span>
      <ServoChoice />
      <DrivePill />
      <span class="spring" />
      {!narrow.value && <UnitsChoice />}
      <Control />
      <StopButton />
    </header>
  );
}

function ServoChoice() {
  const there = nodes.value;
  if (there.length === 0) {
    return null;
  }
  if (there.length === 1) {
    return (
      <span class="servo" data-testid="servo">
        Servo {there[0]!.node} <span class="soft">{bridge.value?.bus}</span>
      </span>
    );
  }
  return (
    <label class="servo">
      <span class="hidden">Servo</span>
      <select
        value={String(node.value)}
        data-testid="servo-choice"
        onChange={(event) => choose(Number(event.currentTarget.value))}>
        {there.map((info) => (
          <option key={info.node} value={info.node}>
            Servo {info.node}
            {info.duplicate ? ' (twice!)' : info.online ? '' : ' (offline)'}
          </option>
        ))}
      </select>
      <span class="soft">{bridge.value?.bus}</span>
    </label>
  );
}

/** Whether the header has no room for the choice of units, which then stands above the view. */
const narrowest = matchMedia('(max-width: 900px)');
export const narrow = signal(narrowest.matches);
narrowest.addEventListener('change', () => {
  narrow.value = narrowest.matches;
});

const unitChoices: { which: Units; text: string; title: string }[] = [
  { which: 'bench', text: 'bench', title: 'Units of the bench: °C, MPa, mA, mW, µm, mm/s, %' },
  { which: 'si', text: 'SI', title: 'Units of SI: K, Pa, A, W, m, m/s, 1' },
];

export function UnitsChoice() {
  return (
    <div class="segments units" role="group" aria-label="Units">
      {unitChoices.map(({ which, text, title }) => (
        <button
          type="button"
          key={which}
          title={title}
          aria-pressed={units.value === which}
          data-testid={`units-${which}`}
          onClick={() => chooseUnits(which)}>
          {text}
        </button>
      ))}
    </div>
  );
}

function DrivePill() {
  const now = state.value;
  if (!now || link.value !== 'open') {
    return (
      <span class="pill unknown" data-testid="drive">
        not connected
      </span>
    );
  }
  const words = driveWords(now);
  return (
    <span class={`pill ${words.kind}`} data-testid="drive">
      {words.text}
    </span>
  );
}

function Control() {
  if (link.value !== 'open') {
    return null;
  }
  if (readOnly.value) {
    return (
      <span class="chip" data-testid="read-only">
        View only
      </span>
    );
  }
  const holder = bridge.value?.control ?? null;
  switch (control.value) {
    case 'mine':
      return (
        <span class="chip" data-testid="control">
          You have control
          <button type="button" class="plain" data-testid="release-control" onClick={() => void act('release_control')}>
            Release
          </button>
        </span>
      );
    case 'other': {
      const who = bridge.value?.clients.find((one) => one.client === holder);
      return (
        <span class="chip" data-testid="control" title={`You are client ${client.value}`}>
          Client {holder}
          {who?.address ? ` (${who.address})` : ''} has control
          <button
            type="button"
            class="plain"
            data-testid="take-control"
            onClick={() => void act('take_control')}
            title="Stops the servos of that client">
            Take
          </button>
        </span>
      );
    }
    default:
      return (
        <span class="chip" data-testid="control">
          Nobody has control
          <button type="button" class="plain" data-testid="take-control" onClick={() => void act('take_control')}>
            Take
          </button>
        </span>
      );
  }
}
