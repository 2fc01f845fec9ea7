// bridge_test.js TEST_BRIDGE [NAME]: clients by others talk to the socket half of host-sim page, behind
// which is a source without a bus. NODE_PATH names the folder of the npm packages.
'use strict';

const { Bridge, Client, get, upgrade } = require('./bridge.js');
const { assertNoneUncounted, collect, main } = require('./test_clients.js');
const assert = require('node:assert/strict');
const { execFileSync } = require('node:child_process');
const fs = require('node:fs');
const os = require('node:os');
const path = require('node:path');

const [program, only] = process.argv.slice(2);
const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'smaservo-bridge-'));
const start = (...options) => Bridge.start(program, ...options);

const tests = {
  async 'server, channels and services are as the protocol has them'() {
    const bridge = await start();
    for (const protocol of ['foxglove.websocket.v1', 'foxglove.sdk.v1']) {
      const client = await Client.connect(bridge, { protocol });
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
    const client = await Client.connect(bridge, { url: `ws://127.0.0.1:${bridge.port}` });
    await client.close();
    assert.equal(await bridge.stop(), 0);
  },

  async 'messages at 1 kHz come to three clients, and none is missed that is not counted'() {
    const bridge = await start();
    const clients = [];
    for (let i = 0; i < 3; ++i) {
      clients.push(await Client.connect(bridge));
    }
    assert.equal(new Set(clients.map((one) => one.info.metadata.client)).size, 3);
    let last = 0n;
    const watched = clients[0].subscribe('/bridge', (_value, message) => {
      assert.ok(message.timestamp >= last);
      last = message.timestamp;
    });
    const collected = await Promise.all(clients.map((one) => collect(one, 3000)));
    assert.ok(last > 0n);
    clients[0].fox.unsubscribe(watched);
    await Promise.all(clients.map((one, i) => assertNoneUncounted(one, collected[i])));
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
    assert.deepEqual(
      all.parameters.map((one) => [one.name, one.value, one.type]),
      [
        ['node1.limits.current_A', 4, 'float64'],
        ['node1.strain.integral_W_s', 20, 'float64'],
        [gain, 8.5, 'float64'],
      ],
    );
    assert.deepEqual((await asked(writer, ['none', gain], 'x')).parameters.length, 1);
    reader.fox.subscribeParameterUpdates([gain]);
    other.fox.subscribeParameterUpdates(['node1.limits.current_A']);
    other.fox.on('parameterValues', () => assert.fail('told what it does not want'));
    await reader.call('echo');
    await other.call('echo');
    const told = reader.heard('parameterValues');
    let written = writer.heard('parameterValues');
    writer.fox.setParameters([{ name: gain, value: 9 }], 'set');
    assert.deepEqual((await written).parameters, [{ name: gain, value: 9, type: 'float64' }]);
    assert.deepEqual((await told).parameters[0].value, 9);
    // Of a set with one that is refused nothing is written.
    written = writer.heard('parameterValues');
    const refused = writer.heard('status');
    writer.fox.setParameters(
      [
        { name: 'node1.strain.integral_W_s', value: 1 },
        { name: gain, value: 101 },
      ],
      'bad',
    );
    assert.deepEqual(
      (await written).parameters.map((one) => one.value),
      [20, 9],
    );
    assert.deepEqual([(await refused).level, writer.statuses.at(-1).message], [2, `${gain} 101: must be 0 to 100`]);
    reader.fox.unsubscribeParameterUpdates([gain]);
    await reader.call('echo');
    reader.fox.on('parameterValues', () => assert.fail('told what it no longer wants'));
    written = writer.heard('parameterValues');
    writer.fox.setParameters([{ name: gain, value: 7 }], 'again');
    await written;
    await Promise.all([reader.call('echo'), other.call('echo')]);
    await bridge.stop();
  },

  async 'services answer, fail, and are not waited for'() {
    const bridge = await start();
    const client = await Client.connect(bridge);
    const held = client.call('hold');
    assert.deepEqual(await client.call('echo', { a: [1, 'ä\u0000', null] }), { a: [1, 'ä\u0000', null] });
    await assert.rejects(client.call('refuse'), /blocked by wire_open/);
    let heldIsBack = false;
    held.then(() => (heldIsBack = true));
    const many = await Promise.all([...Array(50).keys()].map((i) => client.call('echo', { i })));
    assert.deepEqual(
      many.map((one) => one.i),
      [...Array(50).keys()],
    );
    assert.equal(heldIsBack, false);
    await client.call('release');
    assert.deepEqual(await held, { held: true });
    client.services.set('nothing', { id: 99 });
    await assert.rejects(client.call('nothing'), /there is no service 99/);
    // A request that comes in many pieces, and one in several frames.
    const text = 'ü'.repeat(100000);
    assert.deepEqual(await client.call('echo', { text }), { text });
    const parts = ['{"op":"getPara', 'meters","para', 'meterNames":[]}'];
    const whole = client.heard('parameterValues');
    parts.forEach((part, i) => client.ws.send(part, { fin: i === parts.length - 1 }));
    assert.equal((await whole).parameters.length, 3);
    // A long answer, in the middle of live messages.
    const numbers = collect(client, 1500);
    const long = await client.call('big', { bytes: 5e6 });
    assert.equal(long.base64.length, 5e6);
    await numbers;
    // Whoever leaves before the answer is missed by nobody.
    const left = await Client.connect(bridge);
    left.call('hold');
    await left.call('echo');
    left.ws.terminate();
    const isGone = Number(left.info.metadata.client);
    await client.until('/bridge', (state) => !state.clients.some((one) => one.client === isGone));
    await client.call('release');
    assert.ok((await client.call('counts')).left.includes(isGone));
    assert.deepEqual(await client.call('echo', { a: 1 }), { a: 1 });
    await bridge.stop();
  },

  async 'servos come and go'() {
    const bridge = await start();
    const client = await Client.connect(bridge);
    await client.call('second_servo', { there: true });
    assert.ok(client.channels.has('/node2/live'));
    client.fox.subscribe(client.channels.get('/node2/live').id);
    await client.call('second_servo', { there: false });
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
      [200, 101, { Host: `localhost:${bridge.port}` }],
      [200, 101, { Origin: `http://${here}` }],
      [200, 101, { Origin: 'https://app.example' }],
      [403, 403, { Host: `evil.example:${bridge.port}` }],
      [403, 403, { Origin: 'https://evil.example' }],
      [403, 403, { Origin: `http://127.0.0.1:${bridge.port + 1}` }],
      [403, 403, { Origin: 'null' }],
      [400, 400, { Host: 'a b' }],
      [400, 400, { Host: 'x'.repeat(2000) }],
    ];
    for (const [asPage, asSocket, headers] of cases) {
      assert.equal((await get(bridge, '/', headers)).status, asPage, JSON.stringify(headers));
      assert.equal(await upgrade(bridge, '/ws', headers), asSocket, JSON.stringify(headers));
    }
    const answer = await get(bridge, '/');
    assert.equal(answer.body.length, fs.statSync(page).size);
    assert.match(
      answer.headers['content-security-policy'],
      new RegExp(`^default-src 'none'; .*connect-src 'self' ws://${here}; .*frame-ancestors 'none'$`),
    );
    assert.equal(answer.headers['x-content-type-options'], 'nosniff');
    assert.equal(answer.headers['referrer-policy'], 'no-referrer');
    assert.equal(answer.headers['cache-control'], 'no-store');
    assert.equal((await get(bridge, '/etc/passwd')).status, 404);
    assert.equal((await get(bridge, '/../../etc/passwd')).status, 404);
    assert.equal((await get(bridge, '/', {}, 'POST')).status, 405);
    assert.equal(await upgrade(bridge, '/other'), 404);
    assert.equal(await upgrade(bridge, '/ws', { 'Sec-WebSocket-Protocol': 'other' }), 400);
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
      [401, 401, '', { Authorization: 'Bearer ' + '0'.repeat(64) }],
      [403, 403, '?token=' + token, { Origin: 'https://evil.example' }],
      [200, 101, '?token=' + token, {}],
      [200, 101, '?x=1&token=' + token, { Host: 'pi.local' }],
      [200, 101, '', { Authorization: 'Bearer ' + token }],
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
    execFileSync(
      'openssl',
      [
        'req',
        '-x509',
        '-newkey',
        'ec',
        '-pkeyopt',
        'ec_paramgen_curve:P-256',
        '-nodes',
        '-keyout',
        key,
        '-out',
        certificate,
        '-days',
        '2',
        '-subj',
        '/CN=localhost',
        '-addext',
        'subjectAltName=IP:127.0.0.1',
      ],
      { stdio: 'ignore' },
    );
    const bridge = await start('--certificate', certificate, '--key', key);
    assert.equal(bridge.url.protocol, 'https:');
    const client = await Client.connect(bridge, { ca: fs.readFileSync(certificate) });
    await assertNoneUncounted(client, await collect(client, 500));
    assert.equal((await client.call('big', { bytes: 1e6 })).base64.length, 1e6);
    await assert.rejects(Client.connect(bridge), /refused/, 'an unknown certificate');
    await assertNoneUncounted(client, await collect(client, 100));
    assert.equal(await bridge.stop(), 0);
  },

  async 'who only reads writes nothing'() {
    const bridge = await start('--read-only');
    const client = await Client.connect(bridge);
    assert.equal(client.info.metadata.read_only, 'true');
    const refused = client.heard('status');
    client.fox.setParameters([{ name: 'node1.limits.current_A', value: 1 }], 'x');
    assert.match((await refused).message, /read-only/);
    const state = await client.until('/bridge', (value) => value.clients.length > 0);
    assert.equal(state.clients[0].read_only, true);
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
    assert.match(
      await bad('--listen', '192.0.2.1:8765', '--token-file', path.join(folder, 'token')),
      /192.0.2.1:8765: is no address of this machine/,
    );
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

main(tests, only).then((failed) => {
  fs.rmSync(folder, { recursive: true });
  process.exit(failed === 0 ? 0 : 1);
});
