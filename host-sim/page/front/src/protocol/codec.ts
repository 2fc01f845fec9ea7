// Binary frames of foxglove.websocket.v1, as far as a client of this bridge needs them. All numbers are
// little-endian. A frame that is too short or of another kind is null: it is left out, never guessed at.

export interface MessageFrame {
  kind: 'message';
  subscription: number;
  time_s: number; ///< since 1970; to about 0.2 us, as much as a double holds
  data: Uint8Array;
}
export interface ResponseFrame {
  kind: 'response';
  service: number;
  call: number;
  encoding: string;
  data: Uint8Array;
}
export type ServerFrame = MessageFrame | ResponseFrame;

const message = 1;
const response = 3;
const request = 2;

const decoder = new TextDecoder();
const encoder = new TextEncoder();

export function parseFrame(buffer: ArrayBuffer): ServerFrame | null {
  const view = new DataView(buffer);
  if (buffer.byteLength < 1) {
    return null;
  }
  switch (view.getUint8(0)) {
    case message: {
      if (buffer.byteLength < 13) {
        return null;
      }
      const nanoseconds = view.getUint32(9, true) * 2 ** 32 + view.getUint32(5, true);
      return {
        kind: 'message',
        subscription: view.getUint32(1, true),
        time_s: nanoseconds / 1e9,
        data: new Uint8Array(buffer, 13),
      };
    }
    case response: {
      if (buffer.byteLength < 13) {
        return null;
      }
      const length = view.getUint32(9, true);
      if (buffer.byteLength < 13 + length) {
        return null;
      }
      return {
        kind: 'response',
        service: view.getUint32(1, true),
        call: view.getUint32(5, true),
        encoding: decoder.decode(new Uint8Array(buffer, 13, length)),
        data: new Uint8Array(buffer, 13 + length),
      };
    }
    default:
      return null;
  }
}

export function serviceRequest(service: number, call: number, json: unknown): ArrayBuffer {
  const encoding = encoder.encode('json');
  const payload = encoder.encode(JSON.stringify(json));
  const bytes = new Uint8Array(13 + encoding.length + payload.length);
  const view = new DataView(bytes.buffer);
  view.setUint8(0, request);
  view.setUint32(1, service, true);
  view.setUint32(5, call, true);
  view.setUint32(9, encoding.length, true);
  bytes.set(encoding, 13);
  bytes.set(payload, 13 + encoding.length);
  return bytes.buffer;
}

/** The object in a payload, or null. */
export function parseJson(data: Uint8Array | string): Record<string, unknown> | null {
  try {
    const parsed: unknown = JSON.parse(typeof data === 'string' ? data : decoder.decode(data));
    return typeof parsed === 'object' && parsed !== null && !Array.isArray(parsed)
      ? (parsed as Record<string, unknown>)
      : null;
  } catch {
    return null;
  }
}
