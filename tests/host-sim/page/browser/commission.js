// A wire file from a guided run, with the person in the browser as the one who reads the caliper. The run of the
// first test takes half of its usual times, 42 s, and the test a minute and a quarter; those of the second are ended
// early, within three quarters of a minute.
'use strict';

const { by, download, gone, shown, succeeds, text, until, usable } = require('./world.js');
const { connected, reading, tab } = require('./person.js');
const assert = require('node:assert/strict');

async function open_step(view) {
  await connected(view);
  await tab(view, 'guide');
  await by(view, 'guide-commission').locator('.step-head').click();
}

async function start(view, readings, pace) {
  await by(view, 'commission-readings').selectOption(String(readings));
  await by(view, 'commission-pace').fill(pace);
  await usable(by(view, 'commission-start'));
  await by(view, 'commission-start').click();
}

/** More than what only measures the resistance, in whichever level a slow machine is when it looks. */
const heats = (view) => text(view, 'commission-line', /^cycle \d of 3, level \d+ of \d+: ([5-9]\d|\d{3})[.\d]* mA/);

/** No current flows, and nothing of the run is left. */
async function left_alone(world) {
  await until('no current', async () => !(await world.heated()));
  await until('the mode before', async () => (await world.read('6060')) === 0);
  assert.equal(await world.read('target.power_W'), 0);
}

module.exports = {
  async 'a wire file is made with the readings of a person'({ view, world }) {
    await open_step(view);
    const second = await world.visit();
    await open_step(second);
    await start(view, 2, '0,5');

    // The cold wire. Others see that, and may not answer.
    await text(view, 'commission-said', /read the cold wire/i);
    await text(second, 'commission-other', /leads this run and is asked/);
    assert.equal(await by(second, 'commission-reading').count(), 0);
    await by(view, 'commission-reading').fill('1,5');
    await by(view, 'commission-take').click();
    await gone(view, 'commission-reading');
    await text(second, 'commission-line', /^cycle \d of 3, level \d+ of \d+: .* s left/);

    // The hot wire, a slip of the finger first. The second page, which plots all along, is the caliper.
    await tab(second, 'live');
    await text(view, 'commission-said', /read the displacement of the heated wire/);
    await text(view, 'commission-line', /A reading is asked for: \d+ s left/);
    await by(view, 'commission-reading').fill('77');
    await view.keyboard.press('Enter');
    await text(
      view,
      'commission-refused',
      /75\.5 mm from the cold reading, 1\.5 mm; a wire of 100 mm moves by at most/,
    );
    const mm = 1.5 + (await reading(second, 'position_m')) / 1000;
    await by(view, 'commission-reading').fill(mm.toFixed(2));
    await by(view, 'commission-take').click();
    await gone(view, 'commission-reading');
    await by(view, 'commission-skip').click();
    await gone(view, 'commission-skip');

    const printed = await text(view, 'commission-text', /commission-node1\.csv and 2 readings.*expected mean error/s);
    await text(view, 'guide-commission', /Expected error of the stroke.* before, .* after/);
    assert.match(String(await download(view, 'commission-file-run')), /^time_s,current_A,voltage_V,stress_Pa/);
    assert.match(String(await download(view, 'commission-file-readings')), /^time_s,displacement_m,sd_m\n0\.000000,0,/);
    const wire = String(await download(view, 'commission-file-wire'));
    assert.match(wire, /commissioned with commission-node1\.csv and 2 readings/);
    await left_alone(world);

    await by(view, 'commission-write').click();
    await succeeds(view, 'the wire in the servo', async () =>
      /settings are this wire file's/.test(await by(view, 'commission-write').textContent()),
    );
    const [, strain_percent] = /martensite strain from \S+ to ([\d.]+)/.exec(printed);
    const written = await world.read('wire.martensite.strain');
    assert.ok(Math.abs(written - strain_percent / 100) < 1e-4, `${written} instead of ${strain_percent} %`);
    await by(view, 'guide-commission-done').click();
    await text(view, 'finding-commission', /The servo has the wire of this run: the expected error .* %/);
  },

  async 'the heat of commissioning ends by Cancel, by the stop, with the browser and with the bridge'({ view, world }) {
    await open_step(view);
    for (const end of ['commission-cancel', 'stop']) {
      await start(view, 0, '1');
      await heats(view);
      await by(view, end).click();
      await text(view, 'commission-error', /the heat is off/);
      await left_alone(world);
    }
    await start(view, 0, '1');
    await heats(view);
    await view.context().close();
    await left_alone(world);
    const later = await world.visit();
    await open_step(later);
    await text(later, 'commission-error', /the heat is off/);
    await start(later, 0, '1');
    await heats(later);
    await world.bridge.stop('SIGTERM');
    await left_alone(world);
  },

  'a page that is read-only commissions nothing': Object.assign(
    async ({ view }) => {
      await open_step(view);
      await shown(view, 'commission-start');
      await usable(by(view, 'commission-start'), false);
    },
    { bridge: ['--read-only'] },
  ),
};
