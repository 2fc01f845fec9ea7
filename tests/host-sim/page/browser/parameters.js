// Parameters: tried, kept, reverted, undone, stored, refused, changed by others.
'use strict';

const { by, download, gone, noticed, shown, text, until, usable } = require('./world.js');
const { connected, field, parameter, tab, value } = require('./person.js');
const assert = require('node:assert/strict');

const gain = 'strain.proportional_W';
const mW = 1e-3; // as it is shown, in what the servo has

module.exports = {
  async 'an edit is tried, reverted, and kept'({ view, world }) {
    await connected(view);
    await parameter(view, gain);
    const before = await value(view, gain);
    const other = String(Number(before) + 1);
    await field(view, gain).fill(other);
    await by(view, 'try').click();
    await shown(view, 'trial');
    assert.equal(await world.read(gain), Number(other) * mW);
    await by(view, 'revert').click();
    await gone(view, 'trial');
    await until('the page shows the value before', async () => (await value(view, gain)) === before);
    assert.equal(await world.read(gain), Number(before) * mW);
    await field(view, gain).fill(other);
    await field(view, gain).press('Enter');
    await shown(view, 'trial');
    await by(view, 'keep').click();
    await gone(view, 'trial');
    assert.equal(await world.read(gain), Number(other) * mW);
    await until('the value that is kept', async () => (await value(view, gain)) === other);
    await shown(view, `changed-${gain}`);
    await text(view, 'history', /kept after a trial/);
    await by(view, 'undo').click();
    await until('the value before the change', async () => (await value(view, gain)) === before);
    assert.equal(await world.read(gain), Number(before) * mW);
  },

  async 'a value that is written and stored outlasts the servo'({ view, world }) {
    await connected(view);
    await parameter(view, gain);
    await field(view, gain).fill('8250');
    await by(view, 'write').click();
    await text(view, 'history', /, written/);
    assert.equal(await world.read(gain), 8.25);
    await by(view, 'store').click();
    await view.getByText('stored', { exact: true }).waitFor();
    await world.servo.stop();
    await world.startServo();
    assert.equal(await world.read(gain), 8.25);
  },

  async 'a refused value says why, and the servo keeps its own'({ view, world }) {
    await connected(view);
    await parameter(view, gain);
    const before = await value(view, gain);
    // Beyond its range: the page itself knows.
    await field(view, gain).fill('1e12');
    await text(view, `parameter-${gain}`, /at most|between|to /);
    await view.locator(`[id="value-${gain}-why"]`).waitFor();
    await usable(by(view, 'try'), false);
    await by(view, 'discard').click();
    assert.equal(await value(view, gain), before);
    // Within its range, against another parameter: the servo says it.
    const trip_A = await world.read('trips.current_A');
    await parameter(view, 'trips.current_A');
    await field(view, 'trips.current_A').fill(String(1e3 * ((await world.read('limits.current_A')) / 2)));
    await by(view, 'try').click();
    await noticed(view, /current_m?A/);
    assert.equal(await by(view, 'trial').count(), 0);
    assert.equal(await world.read('trips.current_A'), trip_A);
  },

  async 'what is shown of each parameter is its value, in both choices of units'({ view }) {
    await connected(view);
    await tab(view, 'parameters');
    await by(view, 'only-all').click();
    // A search opens all groups.
    await by(view, 'search').fill('.');
    await field(view, gain).waitFor();
    const settings = async () => (await download(view, 'dump-toml')).toString().replace(/^#.*\n/gm, '');
    const before = await settings();
    const shown_now = () =>
      view.evaluate(() =>
        Object.fromEntries([...document.querySelectorAll('.tree input')].map((input) => [input.id, input.value])),
      );
    const typed = () =>
      view.evaluate(() => {
        const inputs = [...document.querySelectorAll('.tree input')].filter((input) => input.value !== '');
        for (const input of inputs) {
          input.dispatchEvent(new Event('input', { bubbles: true }));
        }
        return inputs.length;
      });
    const first = await shown_now();
    for (const units of ['si', 'bench', 'si', 'bench']) {
      assert.ok((await typed()) > 100);
      await text(view, 'edit-bar', /0 changes/);
      await by(view, `units-${units}`).click();
      // The texts that were typed are now in other units, and no change either.
      await text(view, 'edit-bar', /0 changes/);
      assert.equal(await view.locator('.tree .refused').count(), 0);
      await by(view, 'discard').click();
    }
    assert.deepEqual(await shown_now(), first);
    assert.equal(await settings(), before);
  },

  async 'what another master changes is seen'({ view, world }) {
    await connected(view);
    await parameter(view, gain);
    await until('the other master', async () => (await world.can('set', `${gain}=5.75`)) !== null);
    await until('its value', async () => Number(await value(view, gain)) === 5750);
  },

  async 'settings leave as a file, are compared with it, and come back'({ view, world }) {
    await connected(view);
    await parameter(view, gain);
    const before = await value(view, gain);
    const toml = await download(view, 'dump-toml');
    assert.match(
      (await download(view, 'dump-can')).toString(),
      /^host-sim can .* set \\\n[\s\S]*strain\.proportional_W=/,
    );

    const compare = (name, buffer) => by(view, 'diff-file').setInputFiles({ name, mimeType: 'text/plain', buffer });
    await compare('node1.toml', toml);
    await text(view, 'differences', /no differences/);
    await field(view, gain).fill('7500');
    await by(view, 'write').click();
    await text(view, 'history', /, written/);
    assert.equal(await world.read(gain), 7.5);
    await compare('node1.toml', toml);
    await text(view, 'differences', /1 difference/);
    const row = by(view, 'differences').locator('tbody tr');
    assert.equal(await row.count(), 1);
    assert.deepEqual(await row.locator('td').allTextContents(), ['strain.proportional_mW', '7500 mW', `${before} mW`]);
    await by(view, 'restore').click();
    await text(view, 'history', /restored from a file/);
    assert.equal(await world.read(gain), Number(before) * mW);

    await compare('other.toml', Buffer.from('strain.proportional_W = "much"'));
    await noticed(view, /other\.toml/);
    assert.equal(await world.read(gain), Number(before) * mW);
  },
};
