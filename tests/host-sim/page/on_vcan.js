// on_vcan.js HOST_SIM SMASERVOD SOURCES: the bridge on a kernel's CAN, with Foxglove's own client in the place of a
// browser, which is too much for the one processor of User-Mode Linux. Run in a guest (toolchain/can/uml), with
// SERVO_BUS=vcan0.
'use strict';

const { Client } = require('./bridge.js');
const { World, until } = require('./browser/world.js');
const assert = require('node:assert/strict');

const [host_sim, smaservod, sources] = process.argv.slice(2);
const short_watch_s = 5;

/** The newest of each topic that is asked for. A signal that a message of live values lacks keeps its value. */
function follow(client, ...topics) {
  const last = new Map();
  for (const topic of topics) {
    client.subscribe(topic, (value) =>
      last.set(topic, topic.endsWith('/live') ? { ...last.get(topic), ...value } : value),
    );
  }
  return (topic) => last.get(topic) ?? {};
}

async function main() {
  const world = new World({ host_sim, smaservod, sources });
  await world.startServo();
  await world.startBridge('--watch', String(short_watch_s), '--patience', '60', '--timeout', '10');
  const client = await Client.connect(null, { url: `ws://127.0.0.1:${world.port}` });
  await until('the servo is found', () => client.channels.has('/node1/live') && client.channels.has('/node1/state'));
  const now = follow(client, '/bridge', '/node1/state', '/node1/live');
  await until('its state', () => now('/node1/state').online);

  await client.call('enable', { node: 1 });
  await client.call('mode', { node: 1, mode: 1 });
  await client.call('target', { node: 1, value: 800 });
  await until('a move', () => Math.abs(now('/node1/state').position_um - 800) < 100);
  assert.ok(await world.heated());
  // The heat is kept by what the bridge sends, for longer than the servo would wait for it.
  await new Promise((done) => setTimeout(done, 1500 * short_watch_s));
  assert.equal(now('/node1/state').drive, 'operation_enabled');
  const live = now('/node1/live');
  assert.ok(live.drive_current_A > 0.01 && live.wire_temperature_K > 300, JSON.stringify(live));
  console.log('ok      a move, and heat that is kept');

  world.link('down');
  await until('a word about the bus', () => now('/bridge').trouble);
  // Nothing but the time tells a servo that nobody can command it.
  await new Promise((done) => setTimeout(done, 1500 * short_watch_s));
  world.link('up');
  await until(
    'the bus again',
    () =>
      now('/bridge').trouble === '' && now('/node1/state').online && now('/node1/state').drive !== 'operation_enabled',
  );
  assert.equal(await world.heated(), false);
  assert.equal(world.servo.process.exitCode, null);
  console.log('ok      a bus that is down is said, and heats nothing after it');

  // Who may, enables it again; a client that goes ends its heat.
  await until('the faults are reset', async () => (await world.can('reset-faults')) !== null);
  await until('nothing blocks', () => now('/node1/state').blocking?.length === 0);
  await client.call('enable', { node: 1 });
  await until('it is enabled', () => now('/node1/state').drive === 'operation_enabled');
  await client.close();
  await until('no current', async () => !(await world.heated()));
  console.log('ok      enabled again, and off with its client');
  await world.end();
}

main();
