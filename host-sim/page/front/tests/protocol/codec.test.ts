// The codec against the one of the protocol's authors.

import { parseClientMessage, parseServerMessage } from '@foxglove/ws-protocol/dist/cjs/src/parse';
import { describe, expect, it } from 'vitest';
import { parseFrame, parseJson, serviceRequest } from '../../src/protocol/codec';
import { randomFrom } from '../random';

function messageFrame(subscription: number, time_ns: bigint, payload: string): ArrayBuffer {
  const data = new TextEncoder().encode(payload);
  const bytes = new Uint8Array(13 + data.length);
  const view = new DataView(bytes.buffer);
  view.setUint8(0, 1);
  view.setUint32(1, subscription, true);
  view.setBigUint64(5, time_ns, true);
  bytes.set(data, 13);
  return bytes.buffer;
}

function responseFrame(service: number, call: number, payload: string): ArrayBuffer {
  const data = new TextEncoder().encode(payload);
  const bytes = new Uint8Array(17 + data.length);
  const view = new DataView(bytes.buffer);
  view.setUint8(0, 3);
  view.setUint32(1, service, true);
  view.setUint32(5, call, true);
  view.setUint32(9, 4, true);
  bytes.set(new TextEncoder().encode('json'), 13);
  bytes.set(data, 17);
  return bytes.buffer;
}

const text = (data: unknown): string => new TextDecoder().decode(data as Uint8Array);

describe('parseFrame', () => {
  it('reads messages as the independent codec does', () => {
    const random = randomFrom(20);
    for (let i = 0; i < 500; ++i) {
      const subscription = Math.floor(random() * 2 ** 32);
      const time_ns = BigInt(Math.floor(random() * 2 ** 31)) * 1_000_000_000n + BigInt(Math.floor(random() * 1e9));
      const payload = JSON.stringify({ strain: random(), text: 'ä€' });
      const frame = messageFrame(subscription, time_ns, payload);
      const theirs = parseServerMessage(frame);
      const ours = parseFrame(frame);
      if (theirs.op !== 1 || ours?.kind !== 'message') {
        throw new Error('not a message');
      }
      expect(ours.subscription).toBe(theirs.subscriptionId);
      expect(Math.abs(ours.time_s - Number(theirs.timestamp) / 1e9)).toBeLessThan(1e-6);
      expect(text(ours.data)).toBe(text(theirs.data));
    }
  });

  it('reads answers of services as the independent codec does', () => {
    const frame = responseFrame(7, 4_000_000_000, '{"a": [1, null]}');
    const theirs = parseServerMessage(frame);
    const ours = parseFrame(frame);
    if (theirs.op !== 3 || ours?.kind !== 'response') {
      throw new Error('not an answer');
    }
    expect([ours.service, ours.call, ours.encoding]).toEqual([theirs.serviceId, theirs.callId, theirs.encoding]);
    expect(text(ours.data)).toBe(text(theirs.data));
  });

  it('leaves out what is cut short or of another kind, at whatever length', () => {
    const whole = responseFrame(1, 2, '{}');
    for (let length = 0; length < 17; ++length) {
      expect(parseFrame(whole.slice(0, length))).toBeNull();
    }
    const message = messageFrame(1, 2n, '');
    for (let length = 0; length < 13; ++length) {
      expect(parseFrame(message.slice(0, length))).toBeNull();
    }
    const random = randomFrom(21);
    for (let i = 0; i < 5000; ++i) {
      const bytes = Uint8Array.from({ length: Math.floor(random() * 40) }, () => Math.floor(random() * 256));
      expect(() => parseFrame(bytes.buffer)).not.toThrow();
      if (bytes.length > 0 && bytes[0] !== 1 && bytes[0] !== 3) {
        expect(parseFrame(bytes.buffer)).toBeNull();
      }
    }
  });
});

describe('serviceRequest', () => {
  it('is what the independent codec reads', () => {
    const request = { node: 1, values: { 'strain.proportional_W': 0.5 }, text: 'µm' };
    const theirs = parseClientMessage(serviceRequest(3, 9, request));
    if (theirs.op !== 2) {
      throw new Error('not a request');
    }
    expect([theirs.serviceId, theirs.callId, theirs.encoding]).toEqual([3, 9, 'json']);
    expect(JSON.parse(text(theirs.data))).toEqual(request);
  });
});

describe('parseJson', () => {
  it('gives objects only', () => {
    expect(parseJson('{"a": 1}')).toEqual({ a: 1 });
    for (const other of ['', '[]', '1', 'null', '{', '"text"', '{"a": NaN}']) {
      expect(parseJson(other)).toBeNull();
    }
  });
});
