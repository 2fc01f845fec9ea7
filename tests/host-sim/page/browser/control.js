// Who may heat, and who may stop.
'use strict';

const { by, notices, noticed, shown, text, until, usable } = require('./world.js');
const { connected, enable, field, move, off, parameter, drive } = require('./person.js');

const gain = 'strain.proportional_W';

module.exports = {
  async 'a click, the space bar and Escape stop the servo'({ view, world }) {
    await connected(view);
    const ways = {
      'a click': () => by(view, 'stop').click(),
      // Also where a button has the focus, which the bar would press.
      async 'the bar'() {
        await by(view, 'disable').focus();
        await view.keyboard.press('Space');
      },
      // Also where it is typed into a field.
      async Escape() {
        await parameter(view, gain);
        await by(view, 'search').focus();
        await view.keyboard.press('Escape');
      },
    };
    for (const [way, stop] of Object.entries(ways)) {
      await move(view, 800);
      const before = await notices(view);
      await stop();
      await off(view);
      await until(`${way}: no current`, async () => !(await world.heated()));
      await noticed(view, /all servos are off/, before);
    }
  },

  async 'a second browser sees all and changes nothing until it takes control'({ view, world }) {
    await connected(view);
    const second = await world.visit();
    await connected(second);
    await enable(view);
    await text(view, 'control', /You have control/);
    await text(second, 'control', /has control/);
    await drive(second, /Enabled/);
    await usable(by(second, 'disable'), false);
    await parameter(second, gain);
    await usable(field(second, gain), false);
    // Taking it stops what the first one had enabled.
    await by(second, 'take-control').click();
    await text(second, 'control', /You have control/);
    await text(view, 'control', /has control/);
    await off(second);
    // The stop is anybody's.
    await enable(second);
    await by(view, 'stop').click();
    await off(second);
  },

  async 'the last page that goes ends the heat'({ view, world }) {
    await connected(view);
    await move(view, 800);
    await view.context().close();
    await until('no current', async () => !(await world.heated()));
    await shown(await world.visit(), 'enable');
  },
};
