// What a person does on the page in more than one test.
'use strict';

const { by, shown, succeeds, text, until } = require('./world.js');

const received = async (view) => Number(await by(view, 'rate').getAttribute('data-received'));
const field = (view, parameter) => view.locator(`[id="value-${parameter}"]`);
const value = (view, parameter) => field(view, parameter).inputValue();
const drive = (view, words) => text(view, 'drive', words);
const off = (view) => drive(view, (words) => !/Enabled/.test(words));
const tab = (view, name) => by(view, `tab-${name}`).click();
const reading = async (view, name) => Number((await by(view, `reading-${name}`).textContent()).replace('−', '-'));

async function connected(view) {
  await shown(view, 'rate');
  await until('samples', async () => (await received(view)) > 50);
}

/** The row of a parameter, found by its name. */
async function parameter(view, name) {
  await tab(view, 'parameters');
  await by(view, 'search').fill(name);
  await field(view, name).waitFor();
}

/** By the button of this place, unless it is. */
async function enabled(view, place) {
  if (/Enabled/.test(await by(view, 'drive').textContent())) {
    return;
  }
  await place.getByRole('button', { name: 'Enable', exact: true }).click();
  await succeeds(view, 'enabled', async () => /Enabled/.test(await by(view, 'drive').textContent()));
}

async function enable(view) {
  await tab(view, 'live');
  await enabled(view, view.locator('main'));
}

/** Enabled, and there. */
async function move(view, target_um) {
  await enable(view);
  await by(view, 'mode').selectOption('1');
  // The mode is in force when its unit is shown.
  await view.locator('form.target', { hasText: 'µm' }).waitFor();
  await by(view, 'target').fill(String(target_um));
  await by(view, 'go').click();
  await succeeds(
    view,
    `a move to ${target_um} um`,
    async () => Math.abs((await reading(view, 'position_m')) - target_um) < 100,
  );
}

module.exports = { connected, drive, enable, enabled, field, move, off, parameter, reading, received, tab, value };
