// What a person does on the page in more than one test.
'use strict';

const {by, shown, text, until} = require('./world.js');

const received = async (view) => Number(await by(view, 'rate').getAttribute('data-received'));
const field = (view, parameter) => view.locator(`[id="value-${parameter}"]`);
const value = (view, parameter) => field(view, parameter).inputValue();
const drive = (view, words) => text(view, 'drive', words);
const off = (view) => drive(view, (words) => !/Enabled/.test(words));
const tab = (view, name) => by(view, `tab-${name}`).click();
const reading = async (view, name) =>
  Number((await by(view, `reading-${name}`).textContent()).replace('−', '-'));

async function connected(view) {
  await shown(view, 'rate');
  await until('samples', async () => await received(view) > 50);
}

/** The row of a parameter, found by its name. */
async function parameter(view, name) {
  await tab(view, 'parameters');
  await by(view, 'search').fill(name);
  await field(view, name).waitFor();
}

// A servo whose bridge does not get to run for a while switches itself off, and a command in that moment fails. What
// needs a heated wire is therefore done until it has been done.
const soon = {timeout: 10_000};

/** By the button of this place. */
async function enabled(view, place) {
  await until('an enabled servo', async () => {
    try {
      if (await by(view, 'reset-faults').count() > 0) await by(view, 'reset-faults').click(soon);
      const button = place.getByRole('button', {name: 'Enable', exact: true});
      if (await button.count() > 0) await button.click(soon);
      return /Enabled/.test(await by(view, 'drive').textContent());
    } catch {
      return false;
    }
  });
}

async function enable(view) {
  await tab(view, 'live');
  await enabled(view, view.locator('main'));
}

/** Enabled, and there. */
async function move(view, target_um) {
  let why = '';
  await until(() => `a move to ${target_um} um: ${why}`, async () => {
    await enable(view);
    try {
      await by(view, 'mode').selectOption('1', soon);
      await by(view, 'target').fill(String(target_um), soon);
      await by(view, 'go').click(soon);
    } catch (error) {
      why = error.message;
      return false;
    }
    why = 'it has not come there';
    for (let tries = 0; tries < 100; ++tries) {
      if (Math.abs(await reading(view, 'position_m') - target_um) < 100) return true;
      await view.waitForTimeout(100);
    }
    return false;
  });
}

module.exports = {connected, drive, enable, enabled, field, move, off, parameter, reading, received, soon, tab, value};
