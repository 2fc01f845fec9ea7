// The plots, and what of them outlasts a reload.
'use strict';

const { bus, by, coloured, picture, text, until } = require('./world.js');
const { connected, move, off, reading, received } = require('./person.js');
const assert = require('node:assert/strict');

module.exports = {
  async 'the page connects, its plots move, and it asks nobody else'({ view, world }) {
    await connected(view);
    assert.ok((await text(view, 'servo', /Servo 1/)).includes(bus));
    await move(view, 800);
    assert.ok(await world.heated());
    assert.ok(Math.abs(1e6 * (await world.read('live.position_m')) - (await reading(view, 'position_m'))) < 150);
    for (const plot of ['strain', 'power', 'temperature', 'phases']) {
      await until(`curves of ${plot}`, async () => (await coloured(view, `plot-${plot}`)) > 20);
    }
    const [before, samples] = [await picture(view, 'plot-strain'), await received(view)];
    await until('another picture', async () => (await picture(view, 'plot-strain')) !== before);
    await until('more samples', async () => (await received(view)) > samples);
    await by(view, 'stop').click();
    await off(view);
    const { origin } = new URL(world.url);
    for (const url of view.asked) {
      assert.ok(url.startsWith(origin) || /^(data|blob):/.test(url), url);
    }
  },

  async 'a loop has its trail, and the past comes back after a reload'({ view }) {
    await connected(view);
    await by(view, 'span-600').click();
    for (const target_um of [0, 1500, 300]) {
      await move(view, target_um);
    }
    await by(view, 'stop').click();
    await off(view);
    for (const plot of ['strain-resistance', 'strain-temperature', 'strain']) {
      await until(`a curve of ${plot}`, async () => (await coloured(view, `plot-${plot}`)) > 50);
    }
    // What came before the reload: the servo is off since, and its strain has stood still. Trails fade.
    await view.reload();
    await connected(view);
    for (const plot of ['strain', 'temperature', 'phases']) {
      await until(`the past of ${plot}`, async () => (await coloured(view, `plot-${plot}`)) > 50);
    }
  },
};
