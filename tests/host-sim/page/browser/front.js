// front.js BROWSER HOST_SIM SMASERVOD SOURCES: what the page does with what a bridge tells it, in one browser, one bridge
// and one page that live through all tests. What heats nothing and needs no servo is here, for both browsers; whether
// bridge and servo do what the page asks is in main.js. Run as that.
'use strict';

const { ScriptedBridge, page_of } = require('./scripted_bridge.js');
const { World, by, coloured, gone, launch, noticed, picture, shown, text, until, usable } = require('./world.js');
const { drive, field, off, parameter, received, tab, value } = require('./person.js');
const assert = require('node:assert/strict');

const [name, host_sim, smaservod, sources] = process.argv.slice(2);
const gain = 'strain.proportional_W';
const markup = '<img src=x onerror="window.broken=1"><b>bold</b>';

const tests = {
  async 'each state of the drive offers what it allows'({ view, bridge }) {
    const rows = {
      not_ready: [/Not ready/, false, false],
      switch_on_disabled: [/Off/, true, false],
      ready: [/Off/, true, false],
      switched_on: [/Off/, true, false],
      operation_enabled: [/Enabled: heated/, false, false],
      quick_stop: [/Quick stop/, false, false],
      fault_reaction: [/Fault reaction/, false, false],
      fault: [/Fault/, false, true],
    };
    await tab(view, 'state');
    for (const [state, [words, enable, reset]] of Object.entries(rows)) {
      bridge.now({ state: { drive: state } });
      await drive(view, words);
      await usable(by(view, 'state-enable'), enable);
      await usable(by(view, 'state-reset_faults'), reset);
      await usable(by(view, 'stop'));
    }
    bridge.now({ state: { drive: 'switch_on_disabled', blocking: ['wire_open'] } });
    await drive(view, /Off: blocked/);
    await usable(by(view, 'state-enable'), false);
  },

  async 'a fault is said with its first cause, its explanation and the values before it'({ view, bridge }) {
    await tab(view, 'state');
    bridge.now({
      state: {
        drive: 'fault',
        latched: ['over_temperature', 'wire_open'],
        active: ['wire_open'],
        first_cause: 'wire_open',
        freeze_frame: { wire_temperature_K: 361.2, drive_current_A: null },
      },
    });
    await text(view, 'fault-wire_open', /first cause.*present now.*why it came/s);
    await text(view, 'fault-over_temperature', /gone, can be reset/);
    await text(view, 'freeze-frame', /88.*–/s);
    await by(view, 'state-reset_faults').click();
    await until('the request', () => bridge.requests('reset_faults').length === 1);
    assert.deepEqual(bridge.requests('reset_faults'), [{ node: 1 }]);
    bridge.now({
      state: { drive: 'switch_on_disabled', latched: [], active: [], freeze_frame: null, first_cause: null },
    });
    await text(view, 'faults', /No fault is latched/);
    await gone(view, 'freeze-frame');
  },

  async 'a warning that stands says how often its cause has come'({ view, bridge }) {
    await tab(view, 'state');
    const warned = (times) => ({
      state: { active: [], warnings: ['heat_limit'], warning_causes: { heat_limit: times } },
    });
    bridge.now(warned(1));
    await text(view, 'fault-heat_limit', (words) => !words.includes('times'));
    bridge.now(warned(1494));
    await text(view, 'fault-heat_limit', /1494 times/);
    bridge.now({ state: { warnings: [], warning_causes: {} } });
    await gone(view, 'warnings');
  },

  async 'a refusal is said as a text, whatever it contains'({ view, bridge }) {
    bridge.answers.enable = () => {
      throw new Error(`enable: refused ${markup}`);
    };
    await tab(view, 'live');
    await by(view, 'enable').click();
    await noticed(view, /refused <img src=x/);
    await text(view, 'notice-error', (words) => words.includes(markup));
    await off(view);
    // An error stays until it is dismissed.
    await by(view, 'notice-error').getByRole('button', { name: 'Dismiss' }).click();
    await gone(view, 'notice-error');
    bridge.now({ bridge: { trouble: `can0: ${markup}` } });
    await text(view, 'bus-trouble', (words) => words.includes(markup));
    assert.equal(await view.evaluate(() => window.broken), undefined);
  },

  async 'a stop that is not confirmed is said, one that is as well'({ view, bridge }) {
    await by(view, 'stop').click();
    await noticed(view, /all servos are off/);
    bridge.answers.stop = () => {
      throw new Error('node 1: does not confirm that it is off');
    };
    await view.keyboard.press('Escape');
    await noticed(view, /NOT confirmed.*node 1: does not confirm/);
    assert.equal(bridge.requests('stop').length, 2);
  },

  async 'who has no control writes nothing, until it is taken'({ view, bridge }) {
    await parameter(view, gain);
    bridge.now({
      bridge: {
        control: 3,
        clients: [
          ...bridge.bridge.clients,
          { client: 3, address: '10.0.0.3', queued: 0, dropped: 0, read_only: false },
        ],
      },
    });
    await text(view, 'control', /Client 3 \(10\.0\.0\.3\) has control/);
    await usable(field(view, gain), false);
    await usable(by(view, 'stop'));
    bridge.answers.take_control = () => bridge.now({ bridge: { control: 7 } });
    await by(view, 'take-control').click();
    await text(view, 'control', /You have control/);
    await usable(field(view, gain));
    bridge.answers.release_control = () => bridge.now({ bridge: { control: null } });
    await by(view, 'release-control').click();
    await text(view, 'control', /Nobody has control/);
  },

  'a bridge that may only show offers no change': Object.assign(
    async ({ view }) => {
      await text(view, 'read-only', /View only/);
      await tab(view, 'live');
      await usable(by(view, 'enable'), false);
      await parameter(view, gain);
      await usable(field(view, gain), false);
      await usable(by(view, 'stop'));
    },
    { bridge: { read_only: true } },
  ),

  async 'a value is checked before it is sent, and written as it was typed'({ view, bridge }) {
    await parameter(view, gain);
    for (const wrong of ['1e12', '-1', 'much', '1 2']) {
      await field(view, gain).fill(wrong);
      await view.locator(`[id="value-${gain}-why"]`).waitFor();
      await usable(by(view, 'write'), false);
    }
    await field(view, gain).fill('7500');
    await by(view, 'write').click();
    await text(view, 'history', /, written/);
    assert.deepEqual(bridge.requests('set'), [[{ name: `node1.${gain}`, value: 7.5 }]]);
    assert.equal(await value(view, gain), '7500');
    await text(view, 'history', /strain\.proportional_mW\s*2000 mW → 7500 mW/);
    await by(view, 'undo').click();
    await until('the value of before', async () => (await value(view, gain)) === '2000');
    await by(view, 'redo').click();
    await until('the value again', async () => (await value(view, gain)) === '7500');
    await by(view, 'units-si').click();
    await text(view, 'history', /strain\.proportional_W\s*2 W → 7\.5 W/);
  },

  async 'what surprises is explained, in the units of the page'({ view }) {
    await tab(view, 'live');
    await text(view, 'plot-temperature', /hot spot \(wire \+ 18 K\)/);
    await by(view, 'why-hot-spot').click();
    await text(view, 'hot-spot-text', /plus a fixed margin of 18 K \(limits\.hot_spot_K\)/);
    await parameter(view, 'limits.temperature_K');
    await text(view, 'parameter-limits.temperature_K', /temperature_degC.*0 to 326\.85 °C/s);
    await field(view, 'limits.temperature_K').fill('900');
    await text(view, 'parameter-limits.temperature_K', /900 is too large; allowed: 0 to 326\.85 °C/);
    await by(view, 'units-si').click();
    await text(view, 'parameter-limits.temperature_K', /1173\.15 is too large; allowed: 273\.15 to 600 K/);
    await by(view, 'units-bench').click();
    await by(view, 'discard').click();
    await parameter(view, gain);
    assert.equal(await by(view, `note-${gain}`).count(), 0);
    await field(view, gain).fill('0');
    await text(view, `note-${gain}`, /by the model of the wire alone.*0\.01 s/);
    await tab(view, 'live');
    await text(view, 'about-gains', /0 are the default: the inverse model of the wire .* run a step test, try a gain/);
    await by(view, 'discard').click();
    await gone(view, 'about-gains');
  },

  async 'one choice of units is that of all numbers, by keyboard, and outlasts a reload'({ view, bridge }) {
    const temperature = 'limits.temperature_K';
    const units = async (pattern) => {
      await tab(view, 'live');
      bridge.samples(1);
      await text(view, 'plot-temperature', pattern.plot);
      await text(view, `unit-${temperature}`, pattern.unit);
      assert.match(await view.locator('.readings').textContent(), pattern.readings);
      assert.match(await view.locator('form.target').textContent(), pattern.target);
      await tab(view, 'step');
      assert.match(await view.locator('form.card').textContent(), pattern.step);
    };
    const bench = { plot: /°C/, unit: /^°C$/, readings: /µm.*%.*°C.*mA/, target: /Target µm/, step: /Amplitude µm/ };
    const si = { plot: /K/, unit: /^K$/, readings: /m.*K.*A/, target: /Target m[^m]/, step: /Amplitude m[^m]/ };
    await units(bench);
    assert.equal(await by(view, 'step-amplitude').inputValue(), '500');
    await tab(view, 'live');
    await field(view, temperature)
      .or(view.locator(`[id="value-f-${temperature}"]`))
      .first()
      .waitFor();
    const edit = view.locator(`[id="value-f-${temperature}"]`);
    assert.equal(await edit.inputValue(), '120');
    // A text that is typed goes along, and what nobody has edited is no edit.
    await edit.fill('110');
    await by(view, 'units-si').focus();
    await view.keyboard.press('Enter');
    await until('kelvins', async () => (await edit.inputValue()) === '383.15');
    await text(view, 'edit-bar', /1 change/);
    await by(view, 'write').click();
    await until('it is written', () => bridge.requests('set').length === 1);
    assert.deepEqual(bridge.requests('set'), [[{ name: `node1.${temperature}`, value: 383.15 }]]);
    await units(si);
    assert.equal(await by(view, 'step-amplitude').inputValue(), '0.0005');
    await view.reload();
    await until(
      'a choice that is kept',
      async () => (await by(view, 'units-si').getAttribute('aria-pressed')) === 'true',
    );
    await units(si);
    await by(view, 'units-bench').click();
    await units(bench);
    assert.equal(await by(view, 'step-amplitude').inputValue(), '500');
    assert.equal(bridge.requests('set').length, 1);
  },

  'a browser without a choice has the units of the bridge': Object.assign(
    async ({ view, bridge }) => {
      await until('its choice', async () => (await by(view, 'units-si').getAttribute('aria-pressed')) === 'true');
      await by(view, 'units-bench').click();
      await view.reload();
      await until('requests', () => bridge.requests('describe').length > 1);
      assert.equal(await by(view, 'units-bench').getAttribute('aria-pressed'), 'true');
    },
    { units: 'si' },
  ),

  async 'targets are sent as the protocol has them, whatever the units'({ view, bridge }) {
    bridge.now({ state: { drive: 'operation_enabled' } });
    await tab(view, 'live');
    const send = async (typed, count) => {
      await by(view, 'target').fill(typed);
      await by(view, 'go').click();
      await until('the target', () => bridge.requests('target').length === count);
      return bridge.requests('target').at(-1).value;
    };
    assert.equal(await send('700', 1), 700);
    await by(view, 'units-si').click();
    assert.equal(await send('0.0007', 2), 700);
    bridge.now({ state: { mode: -3, mode_name: 'temperature', target: 350 } });
    await view.locator('form.target', { hasText: 'Target K' }).waitFor();
    assert.equal(await send('340', 3), 340);
    await by(view, 'units-bench').click();
    await view.locator('form.target', { hasText: 'Target °C' }).waitFor();
    assert.equal(await by(view, 'target').inputValue(), '76.85');
    assert.equal(await send('66.85', 4), 340);
  },

  async 'a trigger keeps its level when the units are switched'({ view, bridge }) {
    const level = () => by(view, 'trigger-value').inputValue();
    const recorded = async (count) => {
      await by(view, 'record').click();
      await until('the request', () => bridge.requests('record').length === count);
      return bridge.requests('record').at(-1).trigger;
    };
    const rows = [[300], [310]];
    bridge.answers.record = () => ({ recording: { id: 1, period_s: 0.001, signals: ['wire_temperature_K'], rows } });
    await tab(view, 'step');
    await by(view, 'trigger').selectOption('wire_temperature_K');
    await by(view, 'trigger-value').fill('60');
    assert.equal(await recorded(1), 'wire_temperature_K>333.15');
    await shown(view, 'plot-record-°C');
    await by(view, 'units-si').click();
    await until('kelvins', async () => (await level()) === '333.15');
    await shown(view, 'plot-record-K');
    assert.equal(await recorded(2), 'wire_temperature_K>333.15');
    await by(view, 'trigger-value').fill('340');
    assert.equal(await recorded(3), 'wire_temperature_K>340');
    await by(view, 'units-bench').click();
    await until('degrees Celsius', async () => (await level()) === '66.85');
    assert.equal(await recorded(4), 'wire_temperature_K>340');
  },

  async 'step tests say in which gains the shown ones differ'({ view, bridge }) {
    let runs = 0;
    const recording = { period_s: 0.01, signals: ['position_m', 'setpoint'], rows: Array(50).fill([0, 0]) };
    const figures = { rise_s: 0.1, settling_s: 0.2, overshoot_percent: 1, error_percent: 0.5, peak_K: 360 };
    bridge.answers.step = () => {
      const gains = { [gain]: runs, 'limits.temperature_K': runs === 2 ? 383.15 : 393.15, 'limits.hot_spot_K': 18 };
      return { recording: { ...recording, id: ++runs }, figures, gains };
    };
    await tab(view, 'step');
    const rows = view.locator('[data-testid=run]');
    for (const count of [1, 2, 3]) {
      await by(view, 'step-run').click();
      await until('the run', async () => (await rows.count()) === count);
    }
    const told = () => view.locator('th[data-testid^=gain-]').allTextContents();
    assert.deepEqual(await told(), ['strain.proportional_mW', 'limits.temperature_degC']);
    assert.match(await rows.first().textContent(), /86\.8.*2000 mW.*110 °C/);
    assert.match(await rows.last().textContent(), /0 mW.*120 °C/);
    await text(view, 'gains-of-runs', /gains and limits in which the shown runs differ/);
    // Without the one in which the limit was another.
    await rows.first().locator('.run-key').click();
    await until('one column less', async () => (await told()).join() === 'strain.proportional_mW');
    await by(view, 'units-si').click();
    await until('other units', async () => (await told()).join() === 'strain.proportional_W');
    assert.match(await rows.nth(1).textContent(), /360.*1 W/);
  },

  async 'a trial counts down, and its end is said'({ view, bridge }) {
    await parameter(view, gain);
    bridge.answers.try = () => bridge.now({ state: { transaction: { state: 'trying', seconds_left: 30 } } });
    await field(view, gain).fill('3000');
    await field(view, gain).press('Enter');
    await text(view, 'trial-left', /^(30|2\d) s$/);
    assert.deepEqual(
      bridge.requests('try').map(({ values }) => values),
      [{ [gain]: 3 }],
    );
    await usable(by(view, 'undo'), false);
    bridge.now({ state: { transaction: { state: 'none', seconds_left: null } } });
    await gone(view, 'trial');
    await noticed(view, /trial has ended/);
  },

  async 'a bridge that goes is missed, and nothing is asked again when it is back'({ view, bridge }) {
    await tab(view, 'live');
    let answer;
    bridge.answers.enable = () =>
      new Promise((done) => {
        answer = done;
      });
    await by(view, 'enable').click();
    await until('the request', () => bridge.requests('enable').length === 1);
    const { asked } = bridge;
    bridge.begin({});
    await noticed(view, /connection was lost before the answer came/);
    await gone(view, 'lost');
    await off(view);
    answer({});
    await until('what it reads again', () => bridge.requests('describe').length === 1);
    assert.equal(asked.filter(([service]) => service === 'enable').length, 1);
    assert.deepEqual(bridge.requests('enable'), []);
  },

  async 'a servo that is away, and a node-id of two, are said above everything'({ view, bridge }) {
    bridge.now({ state: { online: false } });
    await text(view, 'offline', /Servo 1 does not answer/);
    await drive(view, /offline/);
    await tab(view, 'live');
    await usable(by(view, 'enable'), false);
    bridge.now({
      state: { online: true },
      bridge: { nodes: [{ node: 1, name: 'smaservo', online: true, duplicate: true }] },
    });
    await gone(view, 'offline');
    await text(view, 'duplicate', /Two devices have the node-id 1/);
    bridge.now({ bridge: { nodes: [] } });
    await text(view, 'no-servo', /No servo on can0 yet/);
  },

  'one of several servos is chosen, and all that is sent goes to it': Object.assign(
    async ({ view, bridge }) => {
      await view.locator('[data-testid=servo-choice]').selectOption('5');
      bridge.state.node = 5;
      bridge.now({});
      await tab(view, 'live');
      await usable(by(view, 'enable'));
      await by(view, 'enable').click();
      await until('the request', () => bridge.requests('enable').length === 1);
      assert.deepEqual(bridge.requests('enable'), [{ node: 5 }]);
      await view.locator('[data-testid=servo-choice]').selectOption('1');
    },
    { bridge: { nodes: [1, 5].map((node) => ({ node, name: 'smaservo', online: true, duplicate: false })) } },
  ),

  async 'samples are drawn, and a value that is missing leaves a gap'({ view, bridge }) {
    await tab(view, 'live');
    await until('its samples', async () => {
      bridge.samples(10);
      return (await coloured(view, 'plot-strain')) > 50 && (await coloured(view, 'plot-temperature')) > 50;
    });
    bridge.send('/node1/live', { strain: null, wire_temperature_K: null, position_m: null });
    await until('no value', async () => /^[–-]$/.test(await by(view, 'reading-strain').textContent()));
  },

  async 'a pause stands still, and goes on'({ view, bridge }) {
    await tab(view, 'live');
    bridge.stream();
    await until('a curve', async () => (await coloured(view, 'plot-strain')) > 50);
    await by(view, 'pause').click();
    await text(view, 'pause', /Go on/);
    let still = '';
    await until('it stands', async () => {
      const before = still;
      still = await picture(view, 'plot-strain');
      return still === before;
    });
    const samples = await received(view);
    await until('samples while it stands', async () => (await received(view)) > samples + 50);
    assert.equal(await picture(view, 'plot-strain'), still);
    await by(view, 'pause').click();
    await until('another picture', async () => (await picture(view, 'plot-strain')) !== still);
  },

  async 'a reload keeps what was chosen, and draws the past'({ view, bridge }) {
    await tab(view, 'live');
    await by(view, 'span-10').click();
    await by(view, 'arrange').click();
    await by(view, 'show-current').click();
    await by(view, 'show-phases').click();
    await shown(view, 'plot-current');
    await gone(view, 'plot-phases');
    const hidden = () => by(view, 'plot-strain').locator('.plot-key[data-key=band]');
    await hidden().click();
    bridge.answers.history = () => bridge.past(8);
    await view.reload();
    await shown(view, 'plot-current');
    assert.equal(await by(view, 'plot-phases').count(), 0);
    assert.equal(await by(view, 'span-10').getAttribute('aria-pressed'), 'true');
    assert.equal(await hidden().getAttribute('aria-pressed'), 'false');
    for (const plot of ['strain', 'temperature']) {
      await until(`the past of ${plot}`, async () => (await coloured(view, `plot-${plot}`)) > 50);
    }
  },

  ...require('./choose.js'),
};

async function passes(view, bridge, title, test) {
  const began_ms = Date.now();
  try {
    bridge.begin(test.bridge ?? {}, test.units);
    await view.evaluate(() => localStorage.clear());
    await view.reload();
    await shown(view, 'drive');
    await until('the page knows its servo', async () => bridge.requests('history').length > 0);
    await test({ view, bridge });
    assert.deepEqual(view.errors, []);
    console.log(`ok      ${title}, ${Date.now() - began_ms} ms`);
    return true;
  } catch (error) {
    console.log(`FAILED  ${title}, ${Date.now() - began_ms} ms`);
    console.log(`        ${String(error.stack).split('\n').slice(0, 12).join('\n        ')}`);
    const page = await view
      .evaluate(() => ({ notices: window.noticed, text: document.body.innerText.slice(0, 3000) }))
      .catch(() => null);
    console.log(`        page: ${JSON.stringify(page)}\n        asked: ${JSON.stringify(bridge.asked).slice(-1000)}`);
    return false;
  }
}

async function main() {
  const world = new World({ host_sim, smaservod, sources }, await launch(name));
  await world.startBridge();
  const bridge = await ScriptedBridge.start(await page_of(world.url));
  world.url = bridge.url;
  const view = await world.visit();
  let failed = 0;
  for (const [title, test] of Object.entries(tests)) {
    if (!(await passes(view, bridge, title, test))) {
      ++failed;
    }
  }
  await world.end();
  await world.browser.close();
  bridge.close();
  process.exit(failed ? 1 : 0);
}

main();
