// The plots, and what of them outlasts a reload.
'use strict';

const {bus, by, coloured, gone, picture, shown, text, until} = require('./world.js');
const {connected, move, off, reading, received} = require('./person.js');
const assert = require('node:assert/strict');

module.exports = {
  async 'the page connects, its plots move, and it asks nobody else'({view, world}) {
    await connected(view);
    assert.ok((await text(view, 'servo', /Servo 1/)).includes(bus));
    await move(view, 800);
    assert.ok(await world.heated());
    assert.ok(Math.abs(1e6 * await world.read('live.position_m') - await reading(view, 'position_m')) < 150);
    for (const plot of ['strain', 'power', 'temperature', 'phases']) {
      await until(`curves of ${plot}`, async () => await coloured(view, `plot-${plot}`) > 20);
    }
    const [before, samples] = [await picture(view, 'plot-strain'), await received(view)];
    await until('another picture', async () => await picture(view, 'plot-strain') !== before);
    await until('more samples', async () => await received(view) > samples);
    await by(view, 'stop').click();
    await off(view);
    const {origin} = new URL(world.url);
    for (const url of view.asked) assert.ok(url.startsWith(origin) || /^(data|blob):/.test(url), url);
  },

  async 'a pause stands still, and goes on'({view}) {
    await connected(view);
    await by(view, 'pause').click();
    await text(view, 'pause', /Go on/);
    await view.waitForTimeout(500);
    const still = await picture(view, 'plot-strain');
    const samples = await received(view);
    await until('samples while it stands', async () => await received(view) > samples + 50);
    assert.equal(await picture(view, 'plot-strain'), still);
    await by(view, 'pause').click();
    await until('another picture', async () => await picture(view, 'plot-strain') !== still);
  },

  async 'a reload keeps what was chosen, and the past'({view}) {
    await connected(view);
    await by(view, 'span-10').click();
    await by(view, 'arrange').click();
    await by(view, 'show-current').click();
    await by(view, 'show-phases').click();
    await shown(view, 'plot-current');
    await gone(view, 'plot-phases');
    const hidden = () => by(view, 'plot-strain').locator('.plot-key[data-key=band]');
    await hidden().click();
    await view.waitForTimeout(3000);
    const past = [];
    view.on('websocket', (socket) => socket.on('framereceived', ({payload}) => {
      const words = payload.toString();
      if (typeof payload !== 'string' && words.includes('"t_ns"')) past.push(JSON.parse(words.slice(words.indexOf('{"'))));
    }));
    const reload_ns = Date.now() * 1e6;
    await view.reload();
    await connected(view);
    await shown(view, 'plot-current');
    assert.equal(await by(view, 'plot-phases').count(), 0);
    assert.equal(await by(view, 'span-10').getAttribute('aria-pressed'), 'true');
    assert.equal(await hidden().getAttribute('aria-pressed'), 'false');
    await until('the past is drawn', async () => await coloured(view, 'plot-strain') > 50);
    // Firefox's protocol does not tell of frames of sockets.
    if (past.length > 0) {
      const times_ns = past[0].t_ns;
      assert.ok(reload_ns - times_ns[0] > 3e9, 'it began before the reload');
      assert.ok(times_ns.every((time, i) => i === 0 || time >= times_ns[i - 1]));
    }
  },

  async 'a loop has its trail, and the past comes back after a reload'({view}) {
    await connected(view);
    await by(view, 'span-600').click();
    for (const target_um of [0, 1500, 300]) await move(view, target_um);
    await by(view, 'stop').click();
    await off(view);
    for (const plot of ['strain-resistance', 'strain-temperature', 'strain']) {
      await until(`a curve of ${plot}`, async () => await coloured(view, `plot-${plot}`) > 50);
    }
    // What came before the reload: the servo is off since, and its strain has stood still. Trails fade.
    await view.reload();
    await connected(view);
    for (const plot of ['strain', 'temperature', 'phases']) {
      await until(`the past of ${plot}`, async () => await coloured(view, `plot-${plot}`) > 50);
    }
  },
};
