// The client against the server of the protocol's authors, over a socket in memory.

import { FoxgloveServer } from '@foxglove/ws-protocol';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { Connection, type Events, type NamedValue, type Socket } from '../../src/protocol/connection';

type ServerSocket = Parameters<FoxgloveServer['handleConnection']>[0];

/** Two ends; what one sends, the other gets in a later task. */
class Pipe {
  readonly client: Socket;
  readonly server: ServerSocket;
  closed = false;
  sent: (string | ArrayBuffer)[] = [];

  constructor() {
    const pipe = this;
    this.client = {
      binaryType: '',
      onopen: null,
      onclose: null,
      onmessage: null,
      send(data) {
        pipe.sent.push(data);
        if (!pipe.closed) {
          setTimeout(() => pipe.server.onmessage?.({ data }), 0);
        }
      },
      close: () => this.close(''),
    };
    this.server = {
      binaryType: '',
      protocol: 'foxglove.websocket.v1',
      onerror: null,
      onopen: null,
      onclose: null,
      onmessage: null,
      send(data) {
        const copy =
          typeof data === 'string'
            ? data
            : data instanceof ArrayBuffer
              ? data.slice(0)
              : new Uint8Array(data.buffer, data.byteOffset, data.byteLength).slice().buffer;
        if (!pipe.closed) {
          setTimeout(() => {
            if (!pipe.closed) {
              pipe.client.onmessage?.({ data: copy });
            }
          }, 0);
        }
      },
      close: () => this.close(''),
    };
  }

  close(reason: string): void {
    if (this.closed) {
      return;
    }
    this.closed = true;
    this.client.onclose?.({ code: 1006, reason });
    this.server.onclose?.({ code: 1006, reason, wasClean: false });
  }
}

interface Bench {
  server: FoxgloveServer;
  pipes: Pipe[];
  connection: Connection;
  events: { [K in keyof Events]: ReturnType<typeof vi.fn> };
}

let bench: Bench;
const run = (ms = 50): Promise<unknown> => vi.advanceTimersByTimeAsync(ms);
const bytes = (value: unknown): Uint8Array<ArrayBuffer> =>
  new TextEncoder().encode(JSON.stringify(value)) as Uint8Array<ArrayBuffer>;

beforeEach(() => {
  vi.useFakeTimers();
  const server = new FoxgloveServer({
    name: 'test',
    capabilities: ['parameters', 'services'],
    supportedEncodings: ['json'],
    metadata: { client: '7' },
  });
  const pipes: Pipe[] = [];
  const events = {
    opened: vi.fn(),
    lost: vi.fn(),
    services: vi.fn(),
    parameters: vi.fn(),
    status: vi.fn(),
  };
  const open = (): Socket => {
    const pipe = new Pipe();
    pipes.push(pipe);
    setTimeout(() => {
      pipe.client.onopen?.();
      server.handleConnection(pipe.server, 'page');
    }, 0);
    return pipe.client;
  };
  bench = { server, pipes, events, connection: new Connection(open, events as unknown as Events) };
});

afterEach(() => {
  bench.connection.close();
  vi.useRealTimers();
});

describe('Connection', () => {
  it('opens with the metadata of the server', async () => {
    await run();
    expect(bench.events.opened).toHaveBeenCalledWith({ client: '7' });
  });

  it('gets the messages of a topic, whether it is advertised before or after', async () => {
    const heard: unknown[] = [];
    bench.connection.on('/late', (data, time_s) => heard.push([JSON.parse(new TextDecoder().decode(data)), time_s]));
    await run();
    const channel = bench.server.addChannel({ topic: '/late', encoding: 'json', schemaName: '', schema: '' });
    await run();
    bench.server.sendMessage(channel, 1_500_000_000n, bytes({ a: 1 }));
    await run();
    expect(heard).toEqual([[{ a: 1 }, 1.5]]);
    bench.connection.on('/late', null);
    await run();
    bench.server.sendMessage(channel, 2_000_000_000n, bytes({ a: 2 }));
    await run();
    expect(heard).toHaveLength(1);
  });

  function addService(answer: (request: unknown) => unknown): void {
    const id = bench.server.addService({ name: 'ask', type: 'ask', requestSchema: '', responseSchema: '' });
    bench.server.on('serviceCallRequest', (request, socket) => {
      const { callId } = request;
      try {
        const data = bytes(answer(JSON.parse(new TextDecoder().decode(request.data as Uint8Array))));
        bench.server.sendServiceCallResponse(
          { serviceId: id, callId, encoding: 'json', data: new DataView(data.buffer) },
          socket,
        );
      } catch (error) {
        const { message } = error as Error;
        bench.server.sendServiceCallFailure({ op: 'serviceCallFailure', serviceId: id, callId, message }, socket);
      }
    });
  }

  it('calls services, each call with its own answer', async () => {
    addService((request) => ({ twice: 2 * (request as { n: number }).n }));
    await run();
    const answers = Promise.all([1, 2, 3].map((n) => bench.connection.call('ask', { n })));
    await run();
    expect(await answers).toEqual([{ twice: 2 }, { twice: 4 }, { twice: 6 }]);
  });

  it('fails a call with the text of the server, and one of a service that is not there', async () => {
    addService(() => {
      throw new Error('limits.current_A = 99: refused');
    });
    await run();
    const refused = expect(bench.connection.call('ask')).rejects.toThrow('limits.current_A = 99: refused');
    await run();
    await refused;
    await expect(bench.connection.call('other')).rejects.toThrow('no service "other"');
  });

  it('reads and writes parameters', async () => {
    const store: Record<string, unknown> = { 'node1.a': 1 };
    const all = (): { name: string; value: number }[] =>
      Object.entries(store).map(([name, value]) => ({ name, value: value as number }));
    bench.server.on('getParameters', (request, socket) =>
      bench.server.publishParameterValues(all(), request.id, socket),
    );
    bench.server.on('setParameters', (request, socket) => {
      for (const { name, value } of request.parameters) {
        if ((value as number) < 10) {
          store[name] = value;
        }
      }
      bench.server.publishParameterValues(all(), request.id, socket);
    });
    await run();
    bench.connection.getParameters();
    await run();
    expect(bench.events.parameters).toHaveBeenLastCalledWith([{ name: 'node1.a', value: 1 }]);
    let inForce: NamedValue[] = [];
    void bench.connection.setParameters([{ name: 'node1.a', value: 99 }]).then((values) => {
      inForce = values;
    });
    await run();
    expect(inForce).toEqual([{ name: 'node1.a', value: 1 }]);
  });

  it('fails a write whose connection is lost', async () => {
    await run();
    const lost = expect(bench.connection.setParameters([{ name: 'node1.a', value: 2 }])).rejects.toThrow(
      'connection was lost',
    );
    bench.pipes[0]!.close('the bridge has ended');
    await lost;
  });

  it('comes back by itself, subscribes again, and repeats no command', async () => {
    addService(() => ({}));
    const channel = bench.server.addChannel({ topic: '/live', encoding: 'json', schemaName: '', schema: '' });
    let heard = 0;
    bench.connection.on('/live', () => ++heard);
    await run();
    await Promise.all([bench.connection.call('ask'), run()]);
    const lost = expect(bench.connection.call('ask', { second: true })).rejects.toThrow('connection was lost');
    bench.pipes[0]!.close('the bridge has ended');
    await lost;
    expect(bench.events.lost).toHaveBeenCalledWith('the bridge has ended');
    await expect(bench.connection.call('ask')).rejects.toThrow('no connection');
    await run(600);
    expect(bench.pipes).toHaveLength(2);
    bench.server.sendMessage(channel, 1n, bytes({}));
    await run();
    expect(heard).toBe(1);
    expect(bench.pipes[1]!.sent.filter((data) => typeof data !== 'string')).toHaveLength(0);
  });

  it('takes a server that has gone silent for lost', async () => {
    await run();
    await run(5000);
    expect(bench.events.lost).toHaveBeenCalledWith('the bridge has said nothing for 4 s');
    expect(bench.pipes.length).toBeGreaterThan(1);
  });

  it('takes its own sleep for no silence of the server', async () => {
    await run();
    vi.setSystemTime(Date.now() + 60_000);
    await run(1000);
    expect(bench.events.lost).not.toHaveBeenCalled();
    await run(4000);
    expect(bench.events.lost).toHaveBeenCalled();
  });

  it('takes no harm from what no server should send', async () => {
    await run();
    const { client } = bench.pipes[0]!;
    const odd = [
      '',
      '[]',
      '{"op":"advertise"}',
      '{"op":"advertise","channels":[3,null]}',
      '{"op":"parameterValues"}',
      '{"op":"serviceCallFailure","callId":"x"}',
      new ArrayBuffer(0),
      new ArrayBuffer(13),
      5,
      null,
    ];
    for (const data of odd) {
      expect(() => client.onmessage?.({ data })).not.toThrow();
    }
  });
});
