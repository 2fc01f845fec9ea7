// The choice of a wire, as the page asks for it and shows it. Tests of front.js.
'use strict';

const { by, coloured, gone, noticed, picture, shown, text, until, usable } = require('./world.js');
const { tab } = require('./person.js');
const assert = require('node:assert/strict');

/** Contracts in a second, then comes back in `back_s`; the fan in a quarter of that. */
function course(stroke_m, back_s) {
  const times = (end_s) => Array.from({ length: 201 }, (_, k) => (k / 200) * (1 + end_s));
  const at = (time_s, end_s) => Math.max(0, time_s < 1 ? time_s : 1 - (time_s - 1) / end_s);
  return {
    time_s: times(back_s),
    contraction_m: times(back_s).map((time_s) => stroke_m * at(time_s, back_s)),
    temperature_K: times(back_s).map((time_s) => 298 + 75 * at(time_s, back_s)),
    fan_time_s: times(back_s / 4),
    fan_contraction_m: times(back_s / 4).map((time_s) => stroke_m * at(time_s, back_s / 4)),
  };
}

const thick = {
  wire: 'flexinol-lt-0.20mm',
  parallel: 1,
  length_m: 0.121,
  strain: 0.033,
  stress_Pa: 1.59e8,
  cold_stress_Pa: 1.2e8,
  current_A: 0.66,
  voltage_V: 2.3,
  power_W: 1.518,
  hold_current_A: 0.41,
  hottest_K: 372.15,
  overheats_s: 3.2,
  back_still_s: 3.5,
  back_fan_s: 0.9,
  spring_N: null,
  spring_N_m: null,
  cycles: 'about a million',
  note: '',
  course: course(0.004, 3.5),
};
const thin = {
  ...thick,
  wire: 'flexinol-lt-0.10mm',
  parallel: 4,
  current_A: 0.2,
  overheats_s: null,
  back_still_s: null,
  spring_N: 2.2,
  spring_N_m: 137,
  note: 'Four wires share the force only where they are equally long.',
  course: course(0.004, 8),
};
const why = '637 MPa, the maker suggests at most 172 MPa';
const others = [{ wire: 'flexinol-lt-0.05mm', why }];

const find = (view) => by(view, 'choose-find').click();
const rows = (view) => view.locator('[data-testid=choose-wire]');
/** The texts of a row of wires, from its name on. */
const cells = (view, row) => rows(view).nth(row).locator('th, td').allTextContents();
const typed = (view, field) => by(view, `choose-${field}`).inputValue();

module.exports = {
  'a wire is asked for in SI, also without a servo and by who may only look': Object.assign(
    async ({ view, bridge }) => {
      bridge.now({ bridge: { nodes: [] } });
      await shown(view, 'no-servo');
      bridge.answers.choose = () => ({ wires: [], others });
      await tab(view, 'choose');
      await find(view);
      await text(view, 'choose-others', (words) => words.includes(why));
      await text(view, 'choose-count', /none of 1 wires/);
      const air = { ambient_K: 298.15, fan_m_s: 2 };
      assert.deepEqual(bridge.requests('choose'), [
        { force_N: 5, stroke_m: 0.004, time_s: 1, ...air, life: 'long', parallel: 1 },
      ]);
      for (const [field, value] of Object.entries({
        force: '7,5',
        stroke: '3',
        time: '0.5',
        length: '120',
        supply: '12',
        air: '-10',
        fan: '0',
      })) {
        await by(view, `choose-${field}`).fill(value);
      }
      await by(view, 'choose-pull').selectOption('spring');
      await by(view, 'choose-spring-force').fill('1.5');
      await by(view, 'choose-spring-rate').fill('0.2');
      await by(view, 'choose-life').selectOption('short');
      await by(view, 'choose-parallel').selectOption('4');
      await text(view, 'choose-outdated', /changed since/);
      await by(view, 'choose-force').press('Enter');
      await until('the request', () => bridge.requests('choose').length === 2);
      await gone(view, 'choose-outdated');
      const asked = {
        force_N: 7.5,
        stroke_m: 0.003,
        time_s: 0.5,
        length_m: 0.12,
        supply_V: 12,
        ambient_K: 263.15,
        fan_m_s: 0,
        spring_N: 1.5,
        spring_N_m: 200,
        life: 'short',
        parallel: 4,
      };
      assert.deepEqual(bridge.requests('choose')[1], asked);
      // What is typed stays the same quantity in other units, and over a reload.
      await by(view, 'units-si').click();
      await view.reload();
      await until('the fields', async () => (await typed(view, 'length')) === '0.12');
      assert.deepEqual(
        [await typed(view, 'air'), await typed(view, 'spring-rate'), await typed(view, 'pull')],
        ['263.15', '200', 'spring'],
      );
      await usable(by(view, 'choose-find'));
      await find(view);
      await until('the request again', () => bridge.requests('choose').length === 3);
      assert.deepEqual(bridge.requests('choose')[2], asked);
      await by(view, 'choose-pull').selectOption('nothing');
      await by(view, 'choose-length').fill('');
      await by(view, 'choose-supply').fill('');
      await until('the answer of before', () => by(view, 'choose-find').isEnabled());
      await find(view);
      await until('the last request', () => bridge.requests('choose').length === 4);
      const { length_m: _l, supply_V: _s, spring_N: _n, spring_N_m: _m, ...rest } = asked;
      assert.deepEqual(bridge.requests('choose')[3], { ...rest, one_way: true });
      await by(view, 'units-bench').click();
    },
    { bridge: { read_only: true } },
  ),

  async 'wires are listed with what they take, and the selected one is drawn'({ view, bridge }) {
    bridge.answers.choose = () => ({ wires: [thick, thin], others });
    await tab(view, 'choose');
    await find(view);
    await text(view, 'choose-count', /2 of 3 wires/);
    const first = '1|121|660|2.3|1.52|410|99|3.5|0.9|159|about a million|–';
    assert.equal((await cells(view, 0)).join('|'), `flexinol-lt-0.20mm|${first}`);
    assert.deepEqual((await cells(view, 1)).slice(8), ['never', '0.9', '159', 'about a million', '2.2 + 0.137']);
    await text(view, 'choose-others', (words) => words.includes(`flexinol-lt-0.05mm${why}`));
    await text(view, 'choose-course', /flexinol-lt-0\.20mm, 121 mm/);
    await text(
      view,
      'choose-warning',
      /At 660 mA this wire passes its limit of temperature after 3\.2 s: switch to at most 410 mA \(what holds it\) when/,
    );
    for (const plot of ['contraction', 'temperature']) {
      await until(`the ${plot}`, async () => (await coloured(view, `plot-choose-${plot}`)) > 50);
    }
    const before = await picture(view, 'plot-choose-contraction');
    // By a key, then by a finger anywhere in the row.
    await rows(view).first().locator('input').focus();
    await view.keyboard.press('ArrowDown');
    await text(view, 'choose-course', /4 × flexinol-lt-0\.10mm, 121 mm/);
    await text(view, 'choose-note', /equally long/);
    await gone(view, 'choose-warning');
    await until('another course', async () => (await picture(view, 'plot-choose-contraction')) !== before);
    await rows(view).first().locator('td').nth(3).click();
    await text(view, 'choose-course', /flexinol-lt-0\.20mm/);
    assert.equal(await rows(view).first().locator('input').isChecked(), true);
    // Another view does not forget the answer, and it follows the choice of units.
    await tab(view, 'state');
    await tab(view, 'choose');
    await by(view, 'units-si').click();
    await until('SI', async () => (await cells(view, 0)).slice(2, 4).join() === '0.121,0.66');
    await text(view, 'choose-warning', /At 0\.66 A .* at most 0\.41 A/);
    await by(view, 'units-bench').click();
  },

  async 'a wish that makes no sense is said, and what is no number is not sent'({ view, bridge }) {
    bridge.answers.choose = () => ({ wires: [thick], others });
    await tab(view, 'choose');
    await find(view);
    await shown(view, 'choose-wires');
    const mistaken = async (field, value, words) => {
      const before = await typed(view, field);
      await by(view, `choose-${field}`).fill(value);
      await find(view);
      assert.match(await by(view, `choose-${field}`).evaluate((input) => input.validationMessage), words);
      assert.equal(bridge.requests('choose').length, 1);
      await by(view, `choose-${field}`).fill(before);
    };
    await mistaken('force', 'much', /Write a number above 0\./);
    await mistaken('stroke', '0', /above 0/);
    await mistaken('fan', '-1', /at least 0/);
    await mistaken('air', '-300', /above −273\.15/);
    await mistaken('length', '12o', /or leave the field empty/);
    bridge.answers.choose = () => {
      throw new Error('force_N: 1e+06 is too large, allowed: above 0, at most 1000');
    };
    await by(view, 'choose-force').fill('1000000');
    await find(view);
    await text(view, 'choose-refused', /^force_N: 1e\+06 is too large, allowed: above 0, at most 1000$/);
    await noticed(view, /Choose a wire: force_N: 1e\+06 is too large/);
    await gone(view, 'choose-wires');
    bridge.answers.choose = () => ({ wires: [thick], others });
    await find(view);
    await shown(view, 'choose-wires');
    await gone(view, 'choose-refused');
    assert.equal(bridge.requests('choose').length, 3);
  },
};
