// bad_clients_test.js TEST_BRIDGE [NAME]: clients that break the protocol, do not read, or are gone. None
// of them slows or ends another one.
'use strict';

const { Bridge, Client, rawSocket } = require('./bridge.js');
const { assertNoneUncounted, collect, main, missing } = require('./test_clients.js');
const assert = require('node:assert/strict');
const net = require('node:net');

const [program, only] = process.argv.slice(2);
const start = (...options) => Bridge.start(program, ...options);

const tests = {
  async 'malformed frames end their own connection only'() {
    const bridge = await start();
    const good = await Client.connect(bridge);
    const masked = (...bytes) => Buffer.from([...bytes, 0, 0, 0, 0]);
    const frames = {
      'a frame without a mask': Buffer.from([0x81, 0x02, 0x7b, 0x7d]),
      'a reserved opcode': masked(0x83, 0x80),
      'a reserved bit': masked(0xf1, 0x80),
      'a length of 2^63': masked(0x82, 0xff, 0x80, 0, 0, 0, 0, 0, 0, 0),
      'a length of 2^62': Buffer.concat([masked(0x82, 0xff, 0x40, 0, 0, 0, 0, 0, 0, 0), Buffer.alloc(400000)]),
      'a ping of 126 bytes': masked(0x89, 0xfe, 0, 126),
      'a continuation of nothing': masked(0x80, 0x80),
      'a fragmented ping': masked(0x09, 0x80),
    };
    for (const [name, frame] of Object.entries(frames)) {
      const socket = await rawSocket(bridge);
      socket.write(frame);
      // What the server waits for more of, it is not sent.
      socket.end();
      await socket.gone;
      assert.deepEqual(await good.call('echo', { name }), { name });
    }
    for (const [code, send] of [
      [1009, (ws) => ws.send('x'.repeat(300 * 1024))],
      [1009, (ws) => ws.send(Buffer.alloc(300 * 1024, 2))],
      [1007, (ws) => ws.send(Buffer.from([0xff, 0xfe]), { binary: false })],
    ]) {
      const client = await Client.connect(bridge);
      send(client.ws);
      assert.equal((await client.closed).code, code);
    }
    // No HTTP at all, half of it, and a header without an end.
    for (const bytes of ['\x16\x03\x01\x02\x00\x01', 'GET / HT', 'GET / HTTP/1.1\r\nX: ' + 'x'.repeat(100000)]) {
      const socket = net.connect(bridge.port, '127.0.0.1');
      socket.on('error', () => {});
      socket.resume();
      socket.end(bytes);
      await new Promise((done) => socket.on('close', done));
    }
    // What is malformed within good frames is answered, and the connection goes on.
    good.ws.send('{"op":');
    assert.match((await good.heard('status')).message, /no JSON/);
    good.ws.send(Buffer.from([7, 7, 7]));
    assert.match((await good.heard('status')).message, /no such binary operation/);
    await assertNoneUncounted(good, await collect(good, 100));
    assert.equal(await bridge.stop(), 0);
  },

  async 'a client that does not read loses the oldest, and slows nobody'() {
    const bridge = await start('--rate', '2000');
    const [good, slow] = await Promise.all([1, 2].map(() => Client.connect(bridge)));
    const number = Number(slow.info.metadata.client);
    const numbers = [];
    slow.subscribe('/node1/live', (value) => numbers.push(value.number));
    await slow.call('echo');
    slow.ws._socket.pause();
    // It says that it lives, as one that is only slow.
    const alive = setInterval(() => slow.ws.pong(), 500);
    const flow = collect(good, 8000);
    const me = (state) => {
      const found = state.clients.find((one) => one.client === number);
      assert.ok(found, `client ${number} was closed, as if it were dead`);
      return found;
    };
    await good.until('/bridge', (state) => me(state).dropped > 2000);
    await assertNoneUncounted(good, await flow);
    await good.call('end_sending');
    slow.ws._socket.resume();
    const state = await good.until('/bridge', (value) => me(value).queued === 0);
    await slow.call('echo');
    clearInterval(alive);
    const { sent } = await good.call('counts');
    // The newest is there, and what is missing between is what was counted.
    assert.equal(numbers.at(-1), sent - 1);
    assert.equal(missing(numbers), me(state).dropped);
    await bridge.stop();
  },

  async 'a client that is dead is closed, as one that leaves answers unread'() {
    const bridge = await start('--rate', '250');
    const [good, dead, greedy] = await Promise.all([1, 2, 3].map(() => Client.connect(bridge)));
    const numbers = collect(good, 1500);
    dead.subscribe('/node1/live', () => {});
    await dead.call('echo');
    dead.ws._socket.pause();
    const alone = (client) => (state) =>
      !state.clients.some((one) => one.client === Number(client.info.metadata.client));
    greedy.ws._socket.pause();
    const alive = setInterval(() => greedy.ws.pong(), 500);
    // 40 MB, of which the first may be on its way.
    for (let i = 0; i < 9; ++i) {
      greedy.call('big', { bytes: 5e6 }).catch(() => {});
    }
    await good.until('/bridge', alone(greedy));
    clearInterval(alive);
    await good.until('/bridge', alone(dead));
    const counts = await good.call('counts');
    for (const one of [dead, greedy]) {
      assert.ok(counts.left.includes(Number(one.info.metadata.client)));
      one.ws.terminate();
    }
    await assertNoneUncounted(good, await numbers);
    await bridge.stop();
  },
};

main(tests, only).then((failed) => process.exit(failed === 0 ? 0 : 1));
