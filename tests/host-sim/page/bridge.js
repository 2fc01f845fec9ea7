// What the tests and the measurement need: a bridge as a process, and clients of it by others:
// @foxglove/ws-protocol over ws, both of npm.
'use strict';

const { FoxgloveClient } = require('@foxglove/ws-protocol');
const WebSocket = require('ws');
const { spawn } = require('node:child_process');
const { once } = require('node:events');
const http = require('node:http');
const net = require('node:net');

const protocol = FoxgloveClient.SUPPORTED_SUBPROTOCOL;
const text = (bytes) => new TextDecoder().decode(bytes);

const running = new Set();
process.on('exit', () => {
  for (const one of running) {
    one.kill('SIGKILL');
  }
});

class Bridge {
  // The first line that it prints is its address.
  static async start(program, ...options) {
    const bridge = new Bridge();
    bridge.process = spawn(program, ['--listen', '127.0.0.1:0', ...options]);
    running.add(bridge.process);
    bridge.said = '';
    bridge.process.stderr.on('data', (bytes) => (bridge.said += bytes));
    bridge.ended = new Promise((done) => {
      bridge.process.on('exit', (code, signal) => {
        running.delete(bridge.process);
        done(code ?? signal);
      });
    });
    const line = await Promise.race([once(bridge.process.stdout, 'data'), bridge.ended]);
    if (!Array.isArray(line)) {
      bridge.status = line;
      return bridge;
    }
    bridge.url = new URL(String(line[0]).trim());
    bridge.port = Number(bridge.url.port);
    bridge.pid = bridge.process.pid;
    return bridge;
  }

  get socketUrl() {
    const url = new URL('/ws' + this.url.search, this.url);
    url.protocol = this.url.protocol.replace('http', 'ws');
    return url.href;
  }

  async stop() {
    this.process.kill('SIGTERM');
    return this.ended;
  }
}

// Foxglove's client with what it has heard.
class Client {
  static async connect(bridge, options = {}) {
    const client = new Client();
    const url = options.url ?? bridge.socketUrl;
    client.ws = new WebSocket(url, [options.protocol ?? protocol], options);
    client.closed = new Promise((done) => {
      client.ws.on('close', (code, reason) => done({ code, reason: String(reason) }));
    });
    client.fox = new FoxgloveClient({ ws: client.ws });
    client.channels = new Map();
    client.services = new Map();
    client.statuses = [];
    client.listeners = new Map();
    client.fox.on('error', () => {});
    client.fox.on('status', (status) => client.statuses.push(status));
    client.fox.on('advertise', (channels) => {
      for (const one of channels) {
        client.channels.set(one.topic, one);
      }
    });
    client.fox.on('unadvertise', (ids) => {
      for (const [topic, one] of client.channels) {
        if (ids.includes(one.id)) {
          client.channels.delete(topic);
        }
      }
    });
    client.fox.on('message', (message) => client.listeners.get(message.subscriptionId)?.(message));
    const greeted = new Promise((done) => {
      client.fox.on('serverInfo', (info) => (client.info = info));
      client.fox.on('advertiseServices', (services) => {
        for (const one of services) {
          client.services.set(one.name, one);
        }
        done();
      });
    });
    await Promise.race([
      greeted,
      client.closed.then(({ code }) => {
        throw new Error(`refused: ${code}`);
      }),
    ]);
    return client;
  }

  heard(event) {
    return new Promise((done) => {
      const listener = (what) => {
        this.fox.off(event, listener);
        done(what);
      };
      this.fox.on(event, listener);
    });
  }

  subscribe(topic, listener, read = (bytes) => JSON.parse(text(bytes))) {
    const id = this.fox.subscribe(this.channels.get(topic).id);
    this.listeners.set(id, (message) => listener(read(message.data), message));
    return id;
  }

  // The next message of a topic that fulfils a condition.
  until(topic, condition) {
    return new Promise((done) => {
      const id = this.subscribe(topic, (value) => {
        if (!condition(value)) {
          return;
        }
        this.fox.unsubscribe(id);
        this.listeners.delete(id);
        done(value);
      });
    });
  }

  call(name, request = {}) {
    this.lastCall = (this.lastCall ?? 0) + 1;
    const callId = this.lastCall;
    const serviceId = this.services.get(name).id;
    const answered = new Promise((done, failed) => {
      const good = (answer) => {
        if (answer.callId !== callId) {
          return;
        }
        forget();
        done(JSON.parse(text(answer.data)));
      };
      const bad = (failure) => {
        if (failure.callId !== callId) {
          return;
        }
        forget();
        failed(new Error(failure.message));
      };
      const forget = () => {
        this.fox.off('serviceCallResponse', good);
        this.fox.off('serviceCallFailure', bad);
      };
      this.fox.on('serviceCallResponse', good);
      this.fox.on('serviceCallFailure', bad);
    });
    this.fox.sendServiceCallRequest({
      serviceId,
      callId,
      encoding: 'json',
      data: new TextEncoder().encode(JSON.stringify(request)),
    });
    return answered;
  }

  async close() {
    this.ws.close();
    await this.closed;
  }
}

// The status of a plain request, its headers and its text.
function get(bridge, path, headers = {}, method = 'GET') {
  return new Promise((done, failed) => {
    const request = http.request(
      { host: '127.0.0.1', port: bridge.port, path, method, headers, agent: false },
      (answer) => {
        let body = '';
        answer.setEncoding('utf8');
        answer.on('data', (part) => (body += part));
        answer.on('end', () => done({ status: answer.statusCode, headers: answer.headers, body }));
      },
    );
    request.on('error', failed);
    request.end();
  });
}

// The status of a request to speak WebSocket, with these headers beside the necessary ones.
function upgrade(bridge, path, headers = {}) {
  return new Promise((done) => {
    const request = http.request({
      host: '127.0.0.1',
      port: bridge.port,
      path,
      agent: false,
      headers: {
        Connection: 'Upgrade',
        Upgrade: 'websocket',
        'Sec-WebSocket-Version': '13',
        'Sec-WebSocket-Key': 'dGhlIHNhbXBsZSBub25jZQ==',
        'Sec-WebSocket-Protocol': protocol,
        ...headers,
      },
    });
    request.on('upgrade', (_answer, socket) => {
      socket.destroy();
      done(101);
    });
    request.on('response', (answer) => {
      answer.resume();
      done(answer.statusCode);
    });
    request.on('error', (error) => done(error.code));
    request.end();
  });
}

// A socket that has said the opening words of a WebSocket.
async function rawSocket(bridge) {
  const socket = net.connect(bridge.port, '127.0.0.1');
  socket.on('error', () => {});
  socket.gone = new Promise((done) => socket.on('close', done));
  socket.write(
    `GET /ws HTTP/1.1\r\nHost: 127.0.0.1:${bridge.port}\r\nConnection: Upgrade\r\n` +
      'Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n' +
      `Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: ${protocol}\r\n\r\n`,
  );
  await once(socket, 'data');
  socket.on('data', () => {});
  return socket;
}

module.exports = { Bridge, Client, WebSocket, get, upgrade, rawSocket, protocol };
