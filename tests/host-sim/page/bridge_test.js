// bridge_test.js TEST_BRIDGE [NAME]: clients by others talk to the socket half of host-sim page, behind
// which is a source without a bus. NODE_PATH names the folder of the npm packages.
'use strict';

const {Bridge, Client, get, upgrade, rawSocket} = require('./bridge.js');
const assert = require('node:assert/strict');
const {execFileSync} = require('node:child_process');
const fs = require('node:fs');
const net = require('node:net');
const os = require('node:os');
const path = require('node:path');

const [program, only] = process.argv.slice(2);
const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'smaservo-bridge-'));
const start = (...options) => Bridge.start(program, ...options);

// The numbers of messages that stand one after the other.
function consecutive(numbers) {
  return numbers.every((number, i) => i === 0 || number === numbers[i - 1] + 1);
}

// That many messages of the servo, one after the other.
function collect(client, count) {
  return new Promise((done) => {
    const numbers = [];
    const id = client.subscribe('/node1/live', (value) => {
      numbers.push(value.number);
      if (numbers.length !== count) return;
      client.fox.unsubscribe(id);
      done(numbers);
    });
  });
}

const tests = {
  async 'server, channels and services are as the protocol has them'() {
    const bridge = await start();
    for (const protocol of ['foxglove.websocket.v1', 'foxglove.sdk.v1']) {
      const client = await Client.connect(bridge, {protocol});
      assert.equal(client.ws.protocol, protocol);
      assert.deepEqual(client.info.capabilities, ['parameters', 'parametersSubscribe', 'services']);
      assert.deepEqual(client.info.supportedEncodings, ['json']);
      assert.equal(client.info.metadata.read_only, 'false');
      assert.deepEqual([...client.channels.keys()], ['/bridge', '/node1/live']);
      assert.equal(client.channels.get('/node1/live').schemaEncoding, 'jsonschema');
      assert.equal(client.services.get('echo').request.encoding, 'json');
      await client.close();
    }
    // Foxglove's own default is an address without a path.
    const client = await Client.connect(bridge, {url: `ws://127.0.0.1:${bridge.port}`});
    await client.close();
    assert.equal(await bridge.stop(), 0);
  },

  async 'messages at 1 kHz come to three clients without a gap'() {
    const bridge = await start();
    const clients = [];
    for (let i = 0; i < 3; ++i) clients.push(await Client.connect(bridge));
    assert.equal(new Set(clients.map((one) => one.info.metadata.client)).size, 3);
    let last = 0n;
    clients[0].subscribe('/bridge', (value, message) => {
      assert.ok(message.timestamp >= last);
      last = message.timestamp;
    });
    for (const numbers of await Promise.all(clients.map((one) => collect(one, 3000)))) {
      assert.ok(consecutive(numbers));
    }
    assert.ok(last > 0n);
    await Promise.all(clients.map((one) => one.call('echo')));
    assert.equal((await clients[0].call('counts')).live, 0);
    await bridge.stop();
  },

  async 'parameters are read, written, refused, and told to those who want them'() {
    const bridge = await start();
    const [writer, reader, other] = await Promise.all([1, 2, 3].map(() => Client.connect(bridge)));
    const gain = 'node1.strain.proportional_W';
    const asked = async (client, names, id) => {
      const answer = client.heard('parameterValues');
      client.fox.getParameters(names, id);
      return answer;
    };
    const all = await asked(writer, [], 'all');
    assert.equal(all.id, 'all');
    assert.deepEqual(all.parameters.map((one) => [one.name, one.value, one.type]), [
      ['node1.limits.current_A', 4, 'float64'], ['node1.strain.integral_W_s', 20, 'float64'],
      [gain, 8.5, 'float64']]);
    assert.deepEqual((await asked(writer, ['none', gain], 'x')).parameters.length, 1);
    reader.fox.subscribeParameterUpdates([gain]);
    other.fox.subscribeParameterUpdates(['node1.limits.current_A']);
    other.fox.on('parameterValues', () => assert.fail('told what it does not want'));
    await reader.call('echo');
    await other.call('echo');
    let told = reader.heard('parameterValues');
    let written = writer.heard('parameterValues');
    writer.fox.setParameters([{name: gain, value: 9}], 'set');
    assert.deepEqual((await written).parameters, [{name: gain, value: 9, type: 'float64'}]);
    assert.deepEqual((await told).parameters[0].value, 9);
    // Of a set with one that is refused nothing is written.
    written = writer.heard('parameterValues');
    const refused = writer.heard('status');
    writer.fox.setParameters(
      [{name: 'node1.strain.integral_W_s', value: 1}, {name: gain, value: 101}], 'bad');
    assert.deepEqual((await written).parameters.map((one) => one.value), [20, 9]);
    assert.deepEqual([(await refused).level, writer.statuses.at(-1).message],
                     [2, `${gain} 101: must be 0 to 100`]);
    reader.fox.unsubscribeParameterUpdates([gain]);
    await reader.call('echo');
    reader.fox.on('parameterValues', () => assert.fail('told what it no longer wants'));
    written = writer.heard('parameterValues');
    writer.fox.setParameters([{name: gain, value: 7}], 'again');
    await written;
    await Promise.all([reader.call('echo'), other.call('echo')]);
    await bridge.stop();
  },

  async 'services answer, fail, and take their time'() {
    const bridge = await start();
    const client = await Client.connect(bridge);
    const slow = client.call('slow', {seconds: 0.5});
    assert.deepEqual(await client.call('echo', {a: [1, 'ä\u0000', null]}), {a: [1, 'ä\u0000', null]});
    await assert.rejects(client.call('refuse'), /blocked by wire_open/);
    let slowIsBack = false;
    slow.then(() => (slowIsBack = true));
    const many = await Promise.all([...Array(50).keys()].map((i) => client.call('echo', {i})));
    assert.deepEqual(many.map((one) => one.i), [...Array(50).keys()]);
    assert.equal(slowIsBack, false);
    assert.deepEqual(await slow, {slow: true});
    client.services.set('nothing', {id: 99});
    await assert.rejects(client.call('nothing'), /there is no service 99/);
    // A request that comes in many pieces, and one in several frames.
    const text = 'ü'.repeat(100000);
    assert.deepEqual(await client.call('echo', {text}), {text});
    const parts = ['{"op":"getPara', 'meters","para', 'meterNames":[]}'];
    const whole = client.heard('parameterValues');
    parts.forEach((part, i) => client.ws.send(part, {fin: i === parts.length - 1}));
    assert.equal((await whole).parameters.length, 3);
    // A long answer, in the middle of live messages.
    const numbers = collect(client, 1500);
    const long = await client.call('big', {bytes: 5e6});
    assert.equal(long.base64.length, 5e6);
    await numbers;
    // Whoever leaves before the answer is missed by nobody.
    const left = await Client.connect(bridge);
    left.call('slow', {seconds: 0.3});
    await left.call('echo');
    left.ws.terminate();
    await client.call('slow', {seconds: 0.5});
    assert.ok((await client.call('counts')).left.includes(Number(left.info.metadata.client)));
    await bridge.stop();
  },

  async 'servos come and go'() {
    const bridge = await start();
    const client = await Client.connect(bridge);
    await client.call('second_servo', {there: true});
    assert.ok(client.channels.has('/node2/live'));
    client.fox.subscribe(client.channels.get('/node2/live').id);
    await client.call('second_servo', {there: false});
    assert.deepEqual([...client.channels.keys()], ['/bridge', '/node1/live']);
    client.fox.subscribe(3);
    assert.match((await client.heard('status')).message, /channel 3 does not exist/);
    await bridge.stop();
  },

  async 'foreign names, pages and paths are refused'() {
    const page = path.join(folder, 'page.html');
    fs.writeFileSync(page, '<!doctype html>' + 'x'.repeat(700000));
    const bridge = await start('--page', page, '--allow-origin', 'https://app.example');
    const here = `127.0.0.1:${bridge.port}`;
    const cases = [
      [200, 101, {}],
      [200, 101, {Host: `localhost:${bridge.port}`}],
      [200, 101, {Origin: `http://${here}`}],
      [200, 101, {Origin: 'https://app.example'}],
      [403, 403, {Host: `evil.example:${bridge.port}`}],
      [403, 403, {Origin: 'https://evil.example'}],
      [403, 403, {Origin: `http://127.0.0.1:${bridge.port + 1}`}],
      [403, 403, {Origin: 'null'}],
      [400, 400, {Host: 'a b'}],
      [400, 400, {Host: 'x'.repeat(2000)}],
    ];
    for (const [asPage, asSocket, headers] of cases) {
      assert.equal((await get(bridge, '/', headers)).status, asPage, JSON.stringify(headers));
      assert.equal(await upgrade(bridge, '/ws', headers), asSocket, JSON.stringify(headers));
    }
    const answer = await get(bridge, '/');
    assert.equal(answer.body.length, fs.statSync(page).size);
    assert.match(answer.headers['content-security-policy'],
                 new RegExp(`^default-src 'none'; .*connect-src 'self' ws://${here}; .*frame-ancestors 'none'$`));
    assert.equal(answer.headers['x-content-type-options'], 'nosniff');
    assert.equal(answer.headers['referrer-policy'], 'no-referrer');
    assert.equal(answer.headers['cache-control'], 'no-store');
    assert.equal((await get(bridge, '/etc/passwd')).status, 404);
    assert.equal((await get(bridge, '/../../etc/passwd')).status, 404);
    assert.equal((await get(bridge, '/', {}, 'POST')).status, 405);
    assert.equal(await upgrade(bridge, '/other'), 404);
    assert.equal(await upgrade(bridge, '/ws', {'Sec-WebSocket-Protocol': 'other'}), 400);
    await bridge.stop();
    // Without a page it says what is missing.
    const bare = await start();
    assert.match((await get(bare, '/')).body, /without node/);
    await bare.stop();
  },

  async 'a token lets in whoever has it'() {
    const file = path.join(folder, 'token');
    const bridge = await start('--token-file', file);
    const token = bridge.url.searchParams.get('token');
    assert.equal(fs.readFileSync(file, 'utf8'), token + '\n');
    assert.equal(fs.statSync(file).mode & 0o777, 0o600);
    for (const [status, socket, query, headers] of [
      [401, 401, '', {}],
      [401, 401, '?token=', {}],
      [401, 401, '?token=' + token.slice(1), {}],
      [401, 401, '?token=' + '0'.repeat(64), {}],
      [401, 401, '?token=' + 'f'.repeat(3000), {}],
      [401, 401, '', {Authorization: 'Bearer ' + '0'.repeat(64)}],
      [403, 403, '?token=' + token, {Origin: 'https://evil.example'}],
      [200, 101, '?token=' + token, {}],
      [200, 101, '?x=1&token=' + token, {Host: 'pi.local'}],
      [200, 101, '', {Authorization: 'Bearer ' + token}],
    ]) {
      const what = query + JSON.stringify(headers);
      assert.equal((await get(bridge, '/' + query, headers)).status, status, what);
      assert.equal(await upgrade(bridge, '/ws' + query, headers), socket, what);
    }
    await (await Client.connect(bridge)).close();
    await bridge.stop();
    // It survives a restart.
    const again = await start('--token-file', file);
    assert.equal(again.url.searchParams.get('token'), token);
    await again.stop();
  },

  async 'with a certificate all is encrypted'() {
    const [certificate, key] = ['certificate.pem', 'key.pem'].map((name) => path.join(folder, name));
    execFileSync('openssl', ['req', '-x509', '-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:P-256',
      '-nodes', '-keyout', key, '-out', certificate, '-days', '2', '-subj', '/CN=localhost',
      '-addext', 'subjectAltName=IP:127.0.0.1'], {stdio: 'ignore'});
    const bridge = await start('--certificate', certificate, '--key', key);
    assert.equal(bridge.url.protocol, 'https:');
    const client = await Client.connect(bridge, {ca: fs.readFileSync(certificate)});
    assert.ok(consecutive(await collect(client, 500)));
    assert.equal((await client.call('big', {bytes: 1e6})).base64.length, 1e6);
    await assert.rejects(Client.connect(bridge), /refused/, 'an unknown certificate');
    assert.ok(consecutive(await collect(client, 100)));
    assert.equal(await bridge.stop(), 0);
  },

  async 'who only reads writes nothing'() {
    const bridge = await start('--read-only');
    const client = await Client.connect(bridge);
    assert.equal(client.info.metadata.read_only, 'true');
    const refused = client.heard('status');
    client.fox.setParameters([{name: 'node1.limits.current_A', value: 1}], 'x');
    assert.match((await refused).message, /read-only/);
    const state = await client.until('/bridge', (value) => value.clients.length > 0);
    assert.equal(state.clients[0].read_only, true);
    await bridge.stop();
  },

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
      assert.deepEqual(await good.call('echo', {name}), {name});
    }
    for (const [code, send] of [
      [1009, (ws) => ws.send('x'.repeat(300 * 1024))],
      [1009, (ws) => ws.send(Buffer.alloc(300 * 1024, 2))],
      [1007, (ws) => ws.send(Buffer.from([0xff, 0xfe]), {binary: false})],
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
    assert.ok(consecutive(await collect(good, 100)));
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
    const me = (state) => state.clients.find((one) => one.client === number);
    await good.until('/bridge', (state) => me(state).dropped > 2000);
    assert.ok(consecutive(await flow));
    await good.call('end_sending');
    slow.ws._socket.resume();
    const state = await good.until('/bridge', (value) => me(value).queued === 0);
    await slow.call('echo');
    clearInterval(alive);
    const {sent} = await good.call('counts');
    // The newest is there, and what is missing between is what was counted.
    assert.equal(numbers.at(-1), sent - 1);
    assert.equal(numbers.at(-1) - numbers[0] + 1 - numbers.length, me(state).dropped);
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
    for (let i = 0; i < 9; ++i) greedy.call('big', {bytes: 5e6}).catch(() => {});
    await good.until('/bridge', alone(greedy));
    clearInterval(alive);
    await good.until('/bridge', alone(dead));
    const counts = await good.call('counts');
    for (const one of [dead, greedy]) {
      assert.ok(counts.left.includes(Number(one.info.metadata.client)));
      one.ws.terminate();
    }
    assert.ok(consecutive(await numbers));
    await bridge.stop();
  },

  async 'one client too many is refused'() {
    const bridge = await start('--clients', '2');
    const clients = [await Client.connect(bridge), await Client.connect(bridge)];
    assert.equal(await upgrade(bridge, '/ws'), 503);
    await clients[0].close();
    await clients[1].until('/bridge', (state) => state.clients.length === 1);
    await (await Client.connect(bridge)).close();
    await bridge.stop();
  },

  async 'what cannot be served ends with a message'() {
    const first = await start();
    const bad = async (...options) => {
      const bridge = await Bridge.start(program, ...options);
      assert.equal(bridge.status, 1, options.join(' '));
      return bridge.said;
    };
    assert.match(await bad('--listen', `127.0.0.1:${first.port}`), /another program listens there/);
    assert.match(await bad('--listen', '192.0.2.1:8765', '--token-file', path.join(folder, 'token')),
                 /192.0.2.1:8765: is no address of this machine/);
    assert.match(await bad('--listen', 'here'), /must be ADDRESS:PORT/);
    const no = path.join(folder, 'none.pem');
    assert.match(await bad('--certificate', no, '--key', no), /none.pem: No such file/);
    assert.match(await bad('--certificate', no), /one needs the other/);
    const junk = path.join(folder, 'junk.pem');
    fs.writeFileSync(junk, 'junk');
    assert.match(await bad('--certificate', junk, '--key', junk), /--certificate, --key/);
    first.process.kill('SIGINT');
    assert.equal(await first.ended, 0);
  },
};

async function main() {
  let failed = 0;
  for (const [name, test] of Object.entries(tests)) {
    if (only && !name.includes(only)) continue;
    const began = Date.now();
    try {
      const late = new Promise((done, failed) => {
        setTimeout(() => failed(new Error('does not end')), 60000).unref();
      });
      await Promise.race([test(), late]);
      console.log(`ok      ${name}, ${Date.now() - began} ms`);
    } catch (error) {
      ++failed;
      console.log(`FAILED  ${name}, ${Date.now() - began} ms\n${error.stack}`);
    }
  }
  fs.rmSync(folder, {recursive: true});
  process.exit(failed === 0 ? 0 : 1);
}

main();
