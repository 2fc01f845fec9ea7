// Programs of others that read the servo beside the page.
'use strict';

const { until } = require('./world.js');
const { connected } = require('./person.js');
const { Client } = require('../bridge.js');
const { parse } = require('@foxglove/rosmsg');
const { MessageReader } = require('@foxglove/rosmsg2-serialization');
const assert = require('node:assert/strict');

module.exports = {
  async 'a wire is chosen by the bridge'({ view }) {
    await connected(view);
    await view.getByTestId('tab-choose').click();
    await view.getByTestId('choose-force').fill('3');
    await view.getByTestId('choose-find').click();
    const rows = view.getByTestId('choose-wire');
    await rows.first().waitFor();
    assert.match(await view.getByTestId('choose-wires').innerText(), /flexinol-lt-0\.15mm/);
    await view.getByTestId('choose-time').fill('0.0001');
    await view.getByTestId('choose-find').click();
    await view.getByTestId('choose-refused').waitFor();
    assert.match(await view.getByTestId('choose-refused').innerText(), /time_s = 0\.0001: must be between/);
  },

  // PlotJuggler's plugin asks for this subprotocol, and takes only channels of this encoding.
  async 'PlotJuggler gets the values that the page gets'({ view, world }) {
    await connected(view);
    const client = await Client.connect(null, { url: `ws://127.0.0.1:${world.port}`, protocol: 'foxglove.sdk.v1' });
    const usable = [...client.channels.values()].filter(
      ({ encoding, schemaEncoding, schema, schemaName }) =>
        encoding === 'cdr' && schemaEncoding === 'ros2msg' && schema && schemaName,
    );
    assert.deepEqual(
      usable.map(({ topic }) => topic),
      ['/node1/signals'],
    );
    const reader = new MessageReader(parse(usable[0].schema, { ros2: true }));
    const [binary, text] = [new Map(), new Map()];
    client.subscribe(
      '/node1/signals',
      (values, { timestamp }) => binary.set(timestamp, values),
      (bytes) => reader.readMessage(bytes),
    );
    client.subscribe('/node1/live', (values, { timestamp }) => text.set(timestamp, values));
    const both = () => [...binary.keys()].filter((time) => text.has(time));
    await until('fifty samples', () => both().length >= 50);
    for (const time of both()) {
      for (const [name, value] of Object.entries(text.get(time))) {
        assert.equal(binary.get(time)[name.toLowerCase()], Math.fround(value ?? NaN), name);
      }
    }
    // Each signal is another number, so that none can stand for another.
    const last = binary.get(both().at(-1));
    assert.ok(new Set(Object.values(last)).size > 12, JSON.stringify(last));
    assert.ok(last.wire_temperature_k > 250 && last.wire_temperature_k < 450);
    client.ws.close();
  },
};
