// The one connection of the page and what it has brought: bridge, servos, descriptions.

import { batch, computed, effect, signal, untracked } from '@preact/signals';
import { Feed } from '../live/feed';
import { isUnits } from '../numbers/units';
import { PlotGroup } from '../plot/group';
import type { Bridge, Commission, Description, NodeInfo, State, Value } from '../protocol/bridge';
import { parseJson } from '../protocol/codec';
import { Connection, type NamedValue, type Socket, subprotocol } from '../protocol/connection';
import { say, sayError } from './notices';
import { isNumber, saved } from './saved';
import { firstUnits } from './units';

export const link = signal<'connecting' | 'open' | 'lost'>('connecting');
export const lostReason = signal('');
export const client = signal<number | null>(null);
export const version = signal('');
const readOnlyClient = signal(false);
export const bridge = signal<Bridge | null>(null);
export const commission = signal<Commission | null>(null);
export const description = signal<Description | null>(null);
export const states = signal<Record<number, State>>({});
/** Of all servos, by their full names such as node1.strain.proportional_W. */
export const values = signal<Record<string, Value>>({});

const chosen = saved<number | null>('node', null, (value): value is number | null => value === null || isNumber(value));

export const nodes = computed<NodeInfo[]>(() => bridge.value?.nodes ?? []);
export const node = computed<number | null>(() => {
  const there = nodes.value;
  const wanted = there.find((info) => info.node === chosen.value);
  return (wanted ?? there.find((info) => info.online) ?? there[0])?.node ?? null;
});
export const state = computed<State | null>(() => (node.value === null ? null : (states.value[node.value] ?? null)));
export const readOnly = computed(() => readOnlyClient.value || (bridge.value?.read_only ?? false));
export const control = computed<'mine' | 'other' | 'nobody'>(() => {
  const holder = bridge.value?.control ?? null;
  if (holder === null) {
    return 'nobody';
  }
  return holder === client.value ? 'mine' : 'other';
});
/** Whether a writing button may be offered. The first write takes control where nobody has it. */
export const mayWrite = computed(() => link.value === 'open' && !readOnly.value && control.value !== 'other');
export const heated = computed(() =>
  Object.values(states.value).some(
    (one) => one.online && ['operation_enabled', 'quick_stop', 'fault_reaction'].includes(one.drive),
  ),
);

export function choose(which: number): void {
  chosen.value = which;
}

/** Parameters of the chosen servo, by their names without node1. */
export const own = computed<Record<string, Value>>(() => {
  const prefix = `node${node.value}.`;
  const found: Record<string, Value> = {};
  for (const [name, value] of Object.entries(values.value)) {
    if (name.startsWith(prefix)) {
      found[name.slice(prefix.length)] = value;
    }
  }
  return found;
});

/** How far the servo takes the hottest place of the wire to be above its estimate; NaN: not read. */
export const hotSpotMargin_K = computed<number>(() => Number(own.value['limits.hot_spot_K'] ?? NaN));

// Samples -------------------------------------------------------------------------------------------------

const feeds = new Map<number, Feed>();
const history_s = 600;
const historyPoints = 6000;
const historyPatience_ms = 4000;

export function feedOf(which: number): Feed {
  let feed = feeds.get(which);
  if (!feed) {
    feed = new Feed();
    feeds.set(which, feed);
  }
  return feed;
}

const emptyFeed = new Feed(1024);
export const feed = computed<Feed>(() => (node.value === null ? emptyFeed : feedOf(node.value)));

/** All live plots. */
export const liveGroup = new PlotGroup({
  x: 'clock',
  extent: () => feed.peek().ring.extent(),
  follow_s: 30,
  smallest: 0.002,
});

// Connection ----------------------------------------------------------------------------------------------

function open(): Socket {
  const secure = location.protocol === 'https:' ? 'wss' : 'ws';
  const token = new URLSearchParams(location.search).get('token');
  const query = token === null ? '' : `?token=${encodeURIComponent(token)}`;
  return new WebSocket(`${secure}://${location.host}/ws${query}`, subprotocol) as unknown as Socket;
}

let connection: Connection | null = null;
const ready = signal(0); // how often this connection has told of services

export function start(): void {
  connection = new Connection(open, {
    opened: (metadata) =>
      batch(() => {
        link.value = 'open';
        lostReason.value = '';
        client.value = metadata['client'] === undefined ? null : Number(metadata['client']);
        version.value = metadata['version'] ?? '';
        readOnlyClient.value = metadata['read_only'] === 'true';
        firstUnits.value = isUnits(metadata['units']) ? metadata['units'] : 'bench';
      }),
    lost: (reason) =>
      batch(() => {
        if (link.value === 'open') {
          for (const one of feeds.values()) {
            one.interrupt();
          }
        }
        link.value = 'lost';
        ready.value = 0;
        lostReason.value = reason;
        client.value = null;
        commission.value = null;
        bridge.value = bridge.value && { ...bridge.value, control: null, activity: null };
      }),
    services: () => {
      if (!connection?.hasService('describe')) {
        return;
      }
      ready.value = ready.peek() + 1;
      setTimeout(() => {
        patient.value = false;
      }, patience_ms);
    },
    parameters: take,
    status: (level, text) => say(text, level >= 1 ? 'error' : 'info'),
  });
  connection.on('/bridge', (data) => {
    const message = parseJson(data);
    if (message) {
      bridge.value = message as unknown as Bridge;
    }
  });
  connection.on('/commission', (data) => {
    const message = parseJson(data);
    if (message) {
      commission.value = message as unknown as Commission;
    }
  });
  effect(follow);
  effect(watchStates);
  effect(describe);
  effect(configureFeed);
}

function take(changed: NamedValue[]): void {
  const next = { ...values.peek() };
  for (const { name, value } of changed) {
    if (value === undefined || value === null) {
      delete next[name];
    } else {
      next[name] = value as Value;
    }
  }
  values.value = next;
}

function describe(): void {
  if (ready.value === 0 || link.value !== 'open') {
    return;
  }
  connection?.getParameters();
  call('describe').then(
    (answer) => {
      description.value = answer as unknown as Description;
    },
    (error) => sayError(error, 'The descriptions of parameters and signals could not be read'),
  );
}

const watched = new Set<string>();

function watchStates(): void {
  for (const info of nodes.value) {
    const topic = `/node${info.node}/state`;
    if (watched.has(topic)) {
      continue;
    }
    watched.add(topic);
    connection?.on(topic, (data) => {
      const message = parseJson(data) as unknown as State | null;
      if (message) {
        states.value = { ...states.peek(), [info.node]: message };
      }
    });
  }
}

/** Mode and geometry say what set-points mean: samples wait for them, but not for ever. */
const understood = computed(
  () => state.value !== null && description.value !== null && Object.keys(own.value).length > 0,
);
const patient = signal(true);
const patience_ms = 3000;

let followed: string | null = null;

/** The chosen servo's samples; before the first of them, what the bridge remembers. */
function follow(): void {
  const which = node.value;
  const connected = ready.value > 0 && link.value === 'open' && (understood.value || !patient.value);
  const topic = which === null || !connected ? null : `/node${which}/live`;
  if (topic === followed) {
    return;
  }
  if (followed !== null) {
    connection?.on(followed, null);
  }
  followed = topic;
  if (topic === null || which === null) {
    return;
  }
  untracked(configureFeed);
  const target = feedOf(which);
  let early: [Uint8Array, number][] | null = [];
  const settled = (): void => {
    const waiting = early ?? [];
    early = null;
    for (const [data, time_s] of waiting) {
      target.message(data, time_s);
    }
    liveGroup.invalidate();
  };
  connection?.on(topic, (data, time_s) => {
    if (early) {
      early.push([data, time_s]);
    } else {
      target.message(data, time_s);
      liveGroup.invalidate();
    }
  });
  const patience = setTimeout(settled, historyPatience_ms);
  call('history', { node: which, seconds: history_s, points: historyPoints }).then(
    (answer) => {
      clearTimeout(patience);
      if (early) {
        target.history(answer);
      }
      settled();
    },
    () => {
      clearTimeout(patience);
      settled();
    },
  );
}

function configureFeed(): void {
  const current = feed.value;
  const reasons = description.value?.signals.find((signal_) => signal_.name === 'limit_reasons');
  current.setLimitNames(reasons?.bits ?? []);
  current.mode = state.value?.mode ?? 0;
  current.geometry = {
    zero_strain: Number(own.value['axis.zero_strain'] ?? NaN),
    length_m: Number(own.value['wire.length_m'] ?? NaN),
  };
}

// Calls ---------------------------------------------------------------------------------------------------

export function call(service: string, request: Record<string, unknown> = {}): Promise<Record<string, unknown>> {
  return connection?.call(service, request) ?? Promise.reject(new Error('there is no connection to the bridge'));
}

export function set(changed: NamedValue[]): Promise<NamedValue[]> {
  return connection?.setParameters(changed) ?? Promise.reject(new Error('there is no connection to the bridge'));
}

/** A call whose failure is said to the person; whether it has worked. */
export async function act(service: string, request: Record<string, unknown> = {}): Promise<boolean> {
  try {
    await call(service, request);
    return true;
  } catch (error) {
    sayError(error);
    return false;
  }
}

/** Looks for devices; new ones appear by themselves. */
export async function scan(): Promise<void> {
  try {
    const answer = await call('scan');
    if (answer['without_id']) {
      say('A device without a node-id is on the bus: give it one by LSS.');
    }
  } catch (error) {
    sayError(error, 'Scan');
  }
}

/** Everything off. Where that is not confirmed, the person must know at once. */
export async function stop(): Promise<void> {
  try {
    await call('stop');
    say('Stopped: all servos are off.');
  } catch (error) {
    sayError(error, 'The stop was NOT confirmed. Cut the supply of the wire if it is hot');
  }
}
