// browser_test.js BROWSER HOST_SIM SMASERVOD SOURCES [NAME]: a person before the real page, with a real bridge
// and a real servo on a simulated wire. Run by own_network.sh; NODE_PATH names the folder of the npm packages.
// 77: the browser or the page is missing. BROWSER_SHOTS=FOLDER keeps a picture of each test's end.
'use strict';

const {bridge, by, coloured, gone, launch, picture, scratch, servo, shown, text, until, visit} = require('./browser.js');
const assert = require('node:assert/strict');
const {execFileSync} = require('node:child_process');
const fs = require('node:fs');
const path = require('node:path');

const [name, host_sim, smaservod, sources, only = ''] = process.argv.slice(2);
const gain = 'strain.proportional_W';
const file = name === 'firefox' ? '/usr/bin/firefox-esr' : '/usr/bin/chromium';

const received = async (view) => Number(await by(view, 'rate').getAttribute('data-received'));
const field = (view, parameter) => view.locator(`[id="value-${parameter}"]`);
const value = (view, parameter) => field(view, parameter).inputValue();
const drive = (view, words) => text(view, 'drive', words);

async function connected(view) {
  await shown(view, 'rate');
  await until(async () => await received(view) > 50, 'samples', view);
}

async function parameters(view) {
  await by(view, 'tab-parameters').click();
  await field(view, gain).waitFor();
}

async function enable(view) {
  await by(view, 'tab-live').click();
  await until(() => by(view, 'enable').isEnabled(), 'a servo that may be enabled', view);
  await by(view, 'enable').click();
  await drive(view, /Enabled/);
}

// Until it is there: where a busy machine keeps the bridge from running, the servo switches itself off meanwhile.
async function move(view, target_um) {
  await until(async () => {
    const soon = {timeout: 10_000};
    try {
      if (await by(view, 'enable').count() > 0) await by(view, 'enable').click(soon);
      await by(view, 'mode').selectOption('1', soon);
      await by(view, 'target').fill(String(target_um), soon);
      await by(view, 'go').click(soon);
    } catch {
      return false;
    }
    for (let tries = 0; tries < 100; ++tries) {
      const position = Number((await by(view, 'reading-position_m').textContent()).replace('−', '-'));
      if (Math.abs(position - target_um) < 100) return true;
      await view.waitForTimeout(100);
    }
    return false;
  }, `a move to ${target_um} um`, view);
}

const tests = {
  async 'the page connects, and its plots move'({view}) {
    await connected(view);
    assert.match(await text(view, 'servo', /Servo 1/), /udp/);
    await move(view, 800);
    for (const plot of ['strain', 'power', 'temperature', 'phases']) {
      await until(async () => await coloured(view, `plot-${plot}`) > 20, `curves of ${plot}`, view);
    }
    const [before, samples] = [await picture(view, 'plot-strain'), await received(view)];
    await until(async () => await picture(view, 'plot-strain') !== before, 'another picture', view);
    await until(async () => await received(view) > samples, 'more samples', view);
    await by(view, 'stop').click();
    await drive(view, (words) => !/Enabled/.test(words));
  },

  async 'a pause stands still, and goes on'({view}) {
    await connected(view);
    await by(view, 'pause').click();
    await text(view, 'pause', /Go on/);
    await view.waitForTimeout(500);
    const still = await picture(view, 'plot-strain');
    const samples = await received(view);
    await until(async () => await received(view) > samples + 50, 'samples while it stands', view);
    assert.equal(await picture(view, 'plot-strain'), still);
    await by(view, 'pause').click();
    await until(async () => await picture(view, 'plot-strain') !== still, 'another picture', view);
  },

  async 'an edit is tried, reverted by hand and by itself, and kept'({view}) {
    await connected(view);
    await parameters(view);
    const before = await value(view, gain);
    const other = String(Number(before) + 1);
    for (const how of ['revert', 'itself']) {
      if (how === 'itself') await by(view, 'try-seconds').selectOption('10');
      await field(view, gain).fill(other);
      await by(view, 'try').click();
      await shown(view, 'trial');
      await until(async () => await value(view, gain) === other, 'the value on trial', view);
      if (how === 'revert') await by(view, 'revert').click();
      await gone(view, 'trial');
      await until(async () => await value(view, gain) === before, `the value before (${how})`, view);
    }
    await field(view, gain).fill(other);
    await field(view, gain).press('Enter');
    await shown(view, 'trial');
    await by(view, 'keep').click();
    await gone(view, 'trial');
    await until(async () => await value(view, gain) === other, 'the value that is kept', view);
    await shown(view, `changed-${gain}`);
    await text(view, 'history', /kept after a trial/);
    await by(view, 'undo').click();
    await until(async () => await value(view, gain) === before, 'the value before the change', view);
  },

  async 'a refused value says why, and the servo keeps its own'({view}) {
    await connected(view);
    await parameters(view);
    const before = await value(view, gain);
    // Beyond its range: the page itself knows.
    await field(view, gain).fill('1e9');
    await text(view, `parameter-${gain}`, /at most|between|to /);
    await view.locator(`[id="value-${gain}-why"]`).waitFor();
    assert.equal(await by(view, 'try').isEnabled(), false);
    await by(view, 'discard').click();
    assert.equal(await value(view, gain), before);
    // Within its range, against another parameter: the servo says it.
    await by(view, 'search').fill('limits.current_A');
    const limit = await value(view, 'limits.current_A');
    await by(view, 'search').fill('trips.current_A');
    await field(view, 'trips.current_A').fill(String(Number(limit) / 2));
    await by(view, 'try').click();
    const why = await text(view, 'notice-error', /current/);
    assert.match(why, /current_m?A/);
    assert.equal(await by(view, 'trial').count(), 0);
  },

  async 'step tests are drawn over each other, and outlast a reload'({view}) {
    await connected(view);
    await by(view, 'tab-step').click();
    await by(view, 'step-amplitude').fill('300');
    await by(view, 'step-seconds').fill('1');
    for (const runs of [1, 2]) {
      await until(() => by(view, 'step-run').isEnabled(), 'a servo that can step', view);
      await by(view, 'step-run').click();
      await until(async () => await view.locator('[data-testid=run]').count() === runs, `${runs} runs`, view);
      await until(async () => await coloured(view, 'plot-step-position_m') > 50, 'a response', view);
    }
    const keys = () => by(view, 'plot-step-position_m').locator('.plot-key').allTextContents();
    assert.deepEqual((await keys()).map((words) => words.match(/run \d|set-point/)?.[0]), ['set-point', 'run 2', 'run 1']);
    const both = await coloured(view, 'plot-step-position_m');
    await view.locator('[data-testid=run] .run-key').nth(1).click();
    await until(async () => (await keys()).length === 2, 'one run less', view);
    await until(async () => await coloured(view, 'plot-step-position_m') < both, 'one curve less', view);
    await view.reload();
    await until(async () => await view.locator('[data-testid=run]').count() === 2, 'the runs of before', view);
    assert.equal((await keys()).length, 2);
  },

  async 'a click and the space bar stop the servo'({view}) {
    await connected(view);
    for (const how of ['click', 'space']) {
      await enable(view);
      if (how === 'click') {
        await by(view, 'stop').click();
      } else {
        // Also where a button has the focus, which the bar would press.
        await by(view, 'disable').focus();
        await view.keyboard.press('Space');
      }
      await drive(view, (words) => !/Enabled/.test(words));
      await until(async () => (await view.locator('[data-testid=notice-info]').allTextContents())
        .some((words) => /all servos are off/.test(words)), 'a word that it is off', view);
      // It is gone by itself before the next one.
      await until(async () => await view.locator('[data-testid=notice-info]').count() === 0, 'no notice', view);
    }
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
    await view.reload();
    await connected(view);
    await shown(view, 'plot-current');
    assert.equal(await by(view, 'plot-phases').count(), 0);
    assert.equal(await by(view, 'span-10').getAttribute('aria-pressed'), 'true');
    assert.equal(await hidden().getAttribute('aria-pressed'), 'false');
    // What came before the reload is drawn: nothing of it could have come since.
    await until(async () => await coloured(view, 'plot-strain') > 50, 'the past', view);
  },

  async 'a second browser sees all and changes nothing until it takes control'({view, browser, url}) {
    await connected(view);
    const second = await visit(browser, url);
    await connected(second);
    await enable(view);
    await text(view, 'control', /You have control/);
    await text(second, 'control', /has control/);
    await drive(second, /Enabled/);
    assert.equal(await by(second, 'disable').isEnabled(), false);
    await parameters(second);
    assert.equal(await field(second, gain).isEnabled(), false);
    // Taking it stops what the first one had enabled.
    await by(second, 'take-control').click();
    await text(second, 'control', /You have control/);
    await text(view, 'control', /has control/);
    await drive(second, (words) => !/Enabled/.test(words));
    // The stop is anybody's.
    await enable(second);
    await by(view, 'stop').click();
    await drive(second, (words) => !/Enabled/.test(words));
    assert.deepEqual(second.errors, []);
    await second.context().close();
  },

  async 'a bridge that may only show offers no change'({browser}) {
    const shows = await bridge(host_sim, '--read-only');
    const view = await visit(browser, shows.url);
    await connected(view);
    await text(view, 'read-only', /View only/);
    assert.equal(await by(view, 'enable').isEnabled(), false);
    await parameters(view);
    assert.equal(await field(view, gain).isEnabled(), false);
    assert.equal(await by(view, 'stop').isEnabled(), true);
    await view.context().close();
    assert.equal(await shows.stop(), 0);
  },

  async 'a servo that is killed is said to be gone, and comes back'({view, world}) {
    await connected(view);
    await world.servo.stop('SIGKILL');
    await text(view, 'offline', /does not answer/);
    await world.startServo();
    await gone(view, 'offline');
    const samples = await received(view);
    await until(async () => await received(view) > samples + 20, 'samples of the servo that is back', view);
    await enable(view);
    await by(view, 'stop').click();
    await drive(view, (words) => !/Enabled/.test(words));
  },

  async 'a bridge that is killed is said to be gone'({browser}) {
    const other = await bridge(host_sim);
    const view = await visit(browser, other.url);
    await connected(view);
    await other.stop('SIGKILL');
    await text(view, 'lost', /No connection/);
    await text(view, 'drive', /not connected/);
    await by(view, 'stop').click();
    await text(view, 'notice-error', /NOT confirmed/);
    await view.context().close();
  },

  async 'a bus that is down is said, and nothing is heated after it'({view, world}) {
    await connected(view);
    await enable(view);
    const ip = (...words) => execFileSync('ip', words);
    ip('link', 'set', 'here', 'down');
    await until(async () => await by(view, 'offline').isVisible() || await by(view, 'bus-trouble').isVisible(),
      'a word about the bus', view);
    ip('link', 'set', 'here', 'up');
    ip('route', 'replace', '224.0.0.0/4', 'dev', 'here');
    await until(async () => !await by(view, 'offline').isVisible() && !await by(view, 'bus-trouble').isVisible(),
      'the bus again', view);
    // The servo has ended its heat by itself, and the page has not enabled it again.
    await drive(view, (words) => !/Enabled/.test(words));
    assert.equal(world.servo.process.exitCode, null);
  },
};

// A servo that is as it was before the first test.
async function world(folder) {
  const one = {folder};
  one.startServo = async () => {
    one.servo = servo(smaservod, sources, folder);
  };
  await one.startServo();
  return one;
}

async function run(browser, title, test) {
  const folder = scratch();
  const its = await world(folder);
  const shows = await bridge(host_sim);
  const view = await visit(browser, shows.url);
  try {
    await test({view, browser, url: shows.url, world: its});
    assert.deepEqual(view.errors, []);
    console.log(`ok      ${title}`);
    return true;
  } catch (error) {
    console.log(`FAILED  ${title}\n        ${String(error.stack).split('\n').slice(0, 12).join('\n        ')}`);
    console.log(`        bridge: ${shows.said.slice(-500)}\n        servo: ${its.servo.said.slice(-500)}`);
    return false;
  } finally {
    if (process.env.BROWSER_SHOTS) {
      const shot = path.join(process.env.BROWSER_SHOTS, `${name} ${title.replaceAll(/[^a-z]+/gi, '-')}.png`);
      await view.screenshot({path: shot, fullPage: true}).catch(() => {});
    }
    await view.context().close();
    await shows.stop();
    await its.servo.stop();
    fs.rmSync(folder, {recursive: true});
  }
}

async function main() {
  if (!fs.existsSync(file)) {
    console.log(`SKIPPED: there is no ${file}`);
    process.exit(77);
  }
  const browser = await launch(name);
  let failed = 0;
  for (const [title, test] of Object.entries(tests)) {
    if (!only.split('|').some((part) => title.includes(part))) continue;
    if (!await run(browser, title, test)) ++failed;
  }
  await browser.close();
  process.exit(failed ? 1 : 0);
}

main();
