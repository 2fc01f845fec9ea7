// A WebSocket to the bridge that comes back by itself. What is subscribed to stays so over a new connection;
// nothing else is sent again: a command whose answer was lost is reported as failed, never repeated.

import { parseFrame, parseJson, serviceRequest } from './codec';

export interface Socket {
  binaryType: string;
  onopen: (() => void) | null;
  onclose: ((event: { code: number; reason: string }) => void) | null;
  onmessage: ((event: { data: unknown }) => void) | null;
  send(data: string | ArrayBuffer): void;
  close(): void;
}

export interface NamedValue {
  name: string;
  value: unknown;
}

export interface Events {
  /** A new connection, with the server's metadata. */
  opened(metadata: Record<string, string>): void;
  /** No connection, with the reason where there is one. */
  lost(reason: string): void;
  /** The services are there, or others than before. */
  services(): void;
  parameters(values: NamedValue[]): void;
  status(level: number, text: string): void;
}

export type Handler = (data: Uint8Array, time_s: number) => void;
type Json = Record<string, unknown>;

interface Waiting<T> {
  resolve(answer: T): void;
  reject(error: Error): void;
}

export const subprotocol = 'foxglove.websocket.v1';
const silence_ms = 4000; // the bridge says something four times a second
const look_ms = 500;
const retry_ms = [250, 500, 1000, 2000];

export class Connection {
  private socket: Socket | null = null;
  private tries = 0;
  private heard = 0;
  private calls = 0;
  private requests = 0;
  private ended = false;
  private readonly channels = new Map<string, number>();
  private readonly services = new Map<string, number>();
  private readonly handlers = new Map<string, Handler>();
  private readonly subscriptions = new Map<number, string>();
  private readonly waiting = new Map<number, Waiting<Json>>();
  private readonly reads = new Map<string, Waiting<NamedValue[]>>();
  private subscribed = 0;

  constructor(
    private readonly open: () => Socket,
    private readonly events: Events,
  ) {
    this.connect();
    this.watch();
  }

  /** One handler for each topic; null ends the subscription. */
  on(topic: string, handler: Handler | null): void {
    const had = this.handlers.has(topic);
    if (handler) {
      this.handlers.set(topic, handler);
    } else {
      this.handlers.delete(topic);
    }
    if (handler && !had) {
      this.subscribe(topic);
    }
    if (!handler && had) {
      this.unsubscribe(topic);
    }
  }

  hasService(name: string): boolean {
    return this.services.has(name);
  }

  /** Fails with a text for a person. */
  call(name: string, request: Json = {}): Promise<Json> {
    const service = this.services.get(name);
    if (!this.socket) {
      return Promise.reject(new Error('there is no connection to the bridge'));
    }
    if (service === undefined) {
      return Promise.reject(new Error(`the bridge has no service "${name}"`));
    }
    const call = ++this.calls;
    return new Promise((resolve, reject) => {
      this.waiting.set(call, { resolve, reject });
      this.socket!.send(serviceRequest(service, call, request));
    });
  }

  /** All parameters, where no name is given. */
  getParameters(names: string[] = []): void {
    this.say({ op: 'getParameters', parameterNames: names, id: this.nextId() });
  }

  /** Resolves with the values in force, which are the old ones after a refusal. */
  setParameters(values: NamedValue[]): Promise<NamedValue[]> {
    if (!this.socket) {
      return Promise.reject(new Error('there is no connection to the bridge'));
    }
    const id = this.nextId();
    return new Promise((resolve, reject) => {
      this.reads.set(id, { resolve, reject });
      this.say({ op: 'setParameters', parameters: values, id });
    });
  }

  close(): void {
    this.ended = true;
    this.drop('');
  }

  private nextId(): string {
    return `p${++this.requests}`;
  }

  private connect(): void {
    const socket = this.open();
    socket.binaryType = 'arraybuffer';
    this.heard = Date.now();
    let current = true;
    socket.onmessage = (event) => {
      this.heard = Date.now();
      if (current) {
        this.receive(event.data);
      }
    };
    socket.onopen = () => {
      this.socket = socket;
    };
    socket.onclose = (event) => {
      if (!current) {
        return;
      }
      current = false;
      this.drop(event.reason);
      if (!this.ended) {
        setTimeout(() => this.connect(), retry_ms[Math.min(this.tries++, retry_ms.length - 1)]);
      }
    };
  }

  /** A connection that says nothing is none, whatever TCP believes. Where the page itself did not run, what came
   * meanwhile still waits to be read. */
  private watch(): void {
    let looked = Date.now();
    const timer = setInterval(() => {
      const late_ms = Date.now() - looked - look_ms;
      looked = Date.now();
      if (late_ms > look_ms) {
        this.heard += late_ms;
      }
      if (this.ended) {
        clearInterval(timer);
      } else if (this.socket && Date.now() - this.heard > silence_ms) {
        const silent = this.socket;
        const closed = silent.onclose;
        silent.onclose = null;
        silent.close();
        closed?.({ code: 1006, reason: 'the bridge has said nothing for 4 s' });
      }
    }, look_ms);
  }

  private drop(reason: string): void {
    const socket = this.socket;
    this.socket = null;
    this.channels.clear();
    this.services.clear();
    this.subscriptions.clear();
    for (const { reject } of [...this.waiting.values(), ...this.reads.values()]) {
      reject(new Error('the connection was lost before the answer came'));
    }
    this.waiting.clear();
    this.reads.clear();
    socket?.close();
    this.events.lost(reason);
  }

  private say(message: Json): void {
    this.socket?.send(JSON.stringify(message));
  }

  private subscribe(topic: string): void {
    const channel = this.channels.get(topic);
    if (channel === undefined) {
      return;
    }
    const id = ++this.subscribed;
    this.subscriptions.set(id, topic);
    this.say({ op: 'subscribe', subscriptions: [{ id, channelId: channel }] });
  }

  private unsubscribe(topic: string): void {
    for (const [id, name] of this.subscriptions) {
      if (name !== topic) {
        continue;
      }
      this.subscriptions.delete(id);
      this.say({ op: 'unsubscribe', subscriptionIds: [id] });
    }
  }

  private receive(data: unknown): void {
    if (typeof data === 'string') {
      const message = parseJson(data);
      if (message) {
        this.text(message);
      }
      return;
    }
    if (!(data instanceof ArrayBuffer)) {
      return;
    }
    const frame = parseFrame(data);
    if (frame?.kind === 'message') {
      const topic = this.subscriptions.get(frame.subscription);
      if (topic !== undefined) {
        this.handlers.get(topic)?.(frame.data, frame.time_s);
      }
    } else if (frame?.kind === 'response') {
      const waiting = this.waiting.get(frame.call);
      this.waiting.delete(frame.call);
      const answer = parseJson(frame.data);
      if (answer) {
        waiting?.resolve(answer);
      } else {
        waiting?.reject(new Error('the answer of the bridge is not a JSON object'));
      }
    }
  }

  private text(message: Json): void {
    switch (message['op']) {
      case 'serverInfo':
        this.tries = 0;
        this.events.opened((message['metadata'] ?? {}) as Record<string, string>);
        this.say({ op: 'subscribeParameterUpdates', parameterNames: [] });
        break;
      case 'advertise':
        for (const channel of list(message['channels'])) {
          const topic = String(channel['topic']);
          this.channels.set(topic, Number(channel['id']));
          if (this.handlers.has(topic)) {
            this.subscribe(topic);
          }
        }
        break;
      case 'unadvertise':
        for (const id of numbers(message['channelIds'])) {
          this.gone(id);
        }
        break;
      case 'advertiseServices':
        for (const service of list(message['services'])) {
          this.services.set(String(service['name']), Number(service['id']));
        }
        this.events.services();
        break;
      case 'serviceCallFailure': {
        const call = Number(message['callId']);
        this.waiting.get(call)?.reject(new Error(String(message['message'])));
        this.waiting.delete(call);
        break;
      }
      case 'parameterValues': {
        const values = list(message['parameters']) as unknown as NamedValue[];
        this.events.parameters(values);
        const id = String(message['id'] ?? '');
        this.reads.get(id)?.resolve(values);
        this.reads.delete(id);
        break;
      }
      case 'status':
        this.events.status(Number(message['level']), String(message['message']));
        break;
    }
  }

  private gone(channel: number): void {
    for (const [topic, id] of this.channels) {
      if (id !== channel) {
        continue;
      }
      this.channels.delete(topic);
      for (const [subscription, name] of this.subscriptions) {
        if (name === topic) {
          this.subscriptions.delete(subscription);
        }
      }
    }
  }
}

function list(value: unknown): Json[] {
  return Array.isArray(value) ? value.filter((item): item is Json => typeof item === 'object' && item !== null) : [];
}

function numbers(value: unknown): number[] {
  return Array.isArray(value) ? value.map(Number) : [];
}
