// The guide of a first run, to its end.
'use strict';

const { bus, by, shown, succeeds, text, until, usable } = require('./world.js');
const { connected, enabled, tab } = require('./person.js');
const assert = require('node:assert/strict');

const finding = (view, step) => text(view, `finding-${step}`, /./);

async function settings_steps(view) {
  await by(view, 'guide-bus-done').click();
  assert.ok((await finding(view, 'bus')).includes(`Node 1 (smaservo) answers on ${bus}`));
  await text(view, 'guide-wire', /76 µm/);
  await by(view, 'guide-wire-done').click();
  await text(view, 'guide-limits', /limits\.current_mA is 400 mA, below the trip at 450 mA/);
  await by(view, 'guide-limits-done').click();
  await finding(view, 'limits');
}

/** The wire stands for the resistor. */
async function resistor_step(view) {
  await shown(view, 'resistor-ohm');
  await usable(by(view, 'measure'), false);
  const ohm = Number(await by(view, 'resistor-ohm').inputValue());
  await enabled(view, by(view, 'guide-resistor'));
  await by(view, 'measure').click();
  await by(view, 'guide-resistor-done').click();
  const read_ohm = Number(/Read ([\d.]+) Ω/.exec(await finding(view, 'resistor'))[1]);
  assert.ok(Math.abs(read_ohm / ohm - 1) < 0.2, `${read_ohm} instead of ${ohm}`);
}

/** Heated only when it is asked for. */
async function heating_step(view) {
  await enabled(view, by(view, 'guide-heat'));
  await by(view, 'heat').click();
  await by(view, 'guide-heat-done').click();
  const [, asked, moved] = /Asked (\d+) µm, estimated ([\d.]+) µm/.exec(await finding(view, 'heat')).map(Number);
  assert.ok(Math.abs(moved - asked) < 0.3 * asked, `${moved} instead of ${asked}`);
}

/** Left for the step test, and taken up again. */
async function tuning_step(view) {
  await text(view, 'guide-tune', /No step test has been run/);
  await usable(by(view, 'guide-tune-done'), false);
  await by(view, 'guide-tune').getByRole('link', { name: 'To the step test' }).click();
  await by(view, 'step-amplitude').fill('300');
  await by(view, 'step-seconds').fill('1');
  await until('a servo that can step', () => by(view, 'step-run').isEnabled());
  await by(view, 'step-run').click();
  await succeeds(view, 'a run', () => by(view, 'run').isVisible());
  await tab(view, 'guide');
  await by(view, 'guide-tune-done').click();
  assert.match(await finding(view, 'tune'), /rise [\d.]+ ms/);
}

module.exports = {
  async 'the guide is walked to its end, left and taken up again'({ view }) {
    await connected(view);
    await tab(view, 'guide');
    await settings_steps(view);
    await view.reload();
    await text(view, 'guide', /3 of 8 steps done/);
    await resistor_step(view);
    await heating_step(view);
    await by(view, 'guide-commission-left-out').click();
    await tuning_step(view);
    await by(view, 'guide-keep-done').click();
    await text(view, 'guide', /All steps are done/);
    await view.reload();
    await text(view, 'guide', /All steps are done/);
    // What was found is read in the units in force.
    const in_um = /Asked (\d+) µm, .* °C\./.exec(await finding(view, 'heat'))[1];
    await by(view, 'units-si').click();
    const said = await text(view, 'finding-heat', /Asked [\d.e-]+ m, .* K\./);
    assert.equal(Math.round(1e6 * Number(/Asked ([\d.e-]+) m/.exec(said)[1])), Number(in_um));
    await by(view, 'units-bench').click();
    await by(view, 'guide-heat').getByRole('button', { name: 'Do it again' }).click();
    await shown(view, 'heat');
    await text(view, 'guide', /7 of 8 steps done/);
  },
};
