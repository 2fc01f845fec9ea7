// What is lost in the middle: a servo, the bridge, the bus.
'use strict';

const { by, gone, noticed, short_watch_s, text, until, usable } = require('./world.js');
const { connected, enable, move, off, received } = require('./person.js');
const assert = require('node:assert/strict');

// The servo's own watch ends the heat.
const watched = (test) => Object.assign(test, { bridge: ['--watch', String(short_watch_s), '--patience', '60'] });

module.exports = {
  async 'a servo that is killed hot is missed, comes back, and is not enabled'({ view, world }) {
    await connected(view);
    await move(view, 800);
    assert.ok(await world.heated());
    await world.servo.stop('SIGKILL');
    await text(view, 'offline', /does not answer/);
    await world.startServo();
    await gone(view, 'offline');
    const samples = await received(view);
    await until('samples of the servo that is back', async () => (await received(view)) > samples + 20);
    assert.equal(await world.heated(), false);
    // A wire that was hot when its program was killed is not heated before somebody says so.
    await text(view, 'blocked', /unclean_boot/);
    await usable(by(view, 'enable'), false);
    await until('the faults are reset', async () => (await world.can('reset-faults')) !== null);
    await gone(view, 'blocked');
    await enable(view);
  },

  'a bridge that is killed leaves no heat, and the page says what it is': watched(async ({ view, world }) => {
    await connected(view);
    await move(view, 800);
    assert.ok(await world.heated());
    await world.bridge.stop('SIGKILL');
    await text(view, 'lost', /No connection/);
    await text(view, 'drive', /not connected/);
    await by(view, 'stop').click();
    await noticed(view, /NOT confirmed/);
    await until('no current', async () => !(await world.heated()));
    await world.startBridge();
    await gone(view, 'lost');
    await off(view);
    assert.equal(await world.heated(), false);
  }),

  'a bus that is down is said, and heats nothing after it': watched(async ({ view, world }) => {
    await connected(view);
    await move(view, 800);
    const trouble = async () => (await by(view, 'offline').isVisible()) || (await by(view, 'bus-trouble').isVisible());
    world.link('down');
    await until('a word about the bus', trouble);
    // Nothing but the time tells a servo that nobody can command it.
    await view.waitForTimeout(1500 * short_watch_s);
    world.link('up');
    await until('the bus again', async () => !(await trouble()));
    // The servo has ended its heat by itself, and the page has not enabled it again.
    await off(view);
    assert.equal(await world.heated(), false);
    assert.equal(world.servo.process.exitCode, null);
  }),
};
