// guide_test.js BROWSER HOST_SIM SMASERVOD SOURCES [NAME]: the walks that take a while, of a person before the real
// page with a real bridge and a real servo on a simulated wire: the guide to its end, the recorder with a trigger,
// settings as files, the past of the plots. How it is run, and what it needs: browser_test.js.
// 77: the browser or the page is missing. BROWSER_SHOTS=FOLDER keeps a picture of each test's end.
'use strict';

const {bridge, by, coloured, launch, scratch, servo, shown, text, until, visit} = require('./browser.js');
const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');

const [name, host_sim, smaservod, sources, only = ''] = process.argv.slice(2);
const gain = 'strain.proportional_W';
const file = name === 'firefox' ? '/usr/bin/firefox-esr' : '/usr/bin/chromium';
const soon = {timeout: 10_000};

const received = async (view) => Number(await by(view, 'rate').getAttribute('data-received'));
const value = (view, parameter) => view.locator(`[id="value-${parameter}"]`).inputValue();
const go = (view, tab) => by(view, `tab-${tab}`).click();
const finding = (view, step) => text(view, `finding-${step}`, /./);

async function connected(view) {
  await shown(view, 'rate');
  await until(async () => await received(view) > 50, 'samples', view);
}

// A busy machine may keep the bridge from running for so long that the servo switches itself off: again then.
async function enabled(view, place) {
  await until(async () => {
    try {
      if (await by(view, 'reset-faults').count() > 0) await by(view, 'reset-faults').click(soon);
      const button = place.getByRole('button', {name: 'Enable', exact: true});
      if (await button.count() > 0) await button.click(soon);
      return /Enabled/.test(await by(view, 'drive').textContent());
    } catch {
      return false;
    }
  }, 'an enabled servo', view);
}

async function move(view, target_um) {
  await go(view, 'live');
  await until(async () => {
    try {
      await enabled(view, by(view, 'plots').locator('xpath=ancestor::main'));
      await by(view, 'mode').selectOption('1', soon);
      await by(view, 'target').fill(String(target_um), soon);
      await by(view, 'go').click(soon);
      for (let tries = 0; tries < 50; ++tries) {
        const position_um = Number((await by(view, 'reading-position_m').textContent()).replace('−', '-'));
        if (Math.abs(position_um - target_um) < 100) return true;
        await view.waitForTimeout(100);
      }
    } catch {
      // Switched off meanwhile.
    }
    return false;
  }, `a move to ${target_um} um`, view);
}

// A file that the page gives. Firefox by WebDriver BiDi tells of no download: there it is what the page has made.
async function download(view, button) {
  if (name !== 'firefox') {
    const [given] = await Promise.all([view.waitForEvent('download'), by(view, button).click()]);
    return {name: given.suggestedFilename(), bytes: fs.readFileSync(await given.path())};
  }
  await view.evaluate(() => {
    globalThis.given = null;
    globalThis.made ??= URL.createObjectURL.bind(URL);
    URL.createObjectURL = (blob) => {
      blob.arrayBuffer().then((buffer) => {
        globalThis.given = [...new Uint8Array(buffer)];
      });
      return globalThis.made(blob);
    };
    HTMLAnchorElement.prototype.click = function () {
      globalThis.givenName = this.download;
    };
  });
  await by(view, button).click();
  await until(() => view.evaluate(() => globalThis.given !== null), 'a file', view);
  const [called, bytes] = await view.evaluate(() => [globalThis.givenName, globalThis.given]);
  return {name: called, bytes: Buffer.from(bytes)};
}

async function table(view, testid) {
  const rows = by(view, testid).locator('tbody tr');
  return (await rows.all()).length === 0 ? [] : Promise.all((await rows.all()).map((row) => row.locator('td').allTextContents()));
}

const tests = {
  async 'the guide is walked to its end, left and taken up again'({view}) {
    await connected(view);
    await go(view, 'guide');
    await by(view, 'guide-bus-done').click();
    assert.match(await finding(view, 'bus'), /Node 1 \(smaservo\) answers on udp/);
    await text(view, 'guide-wire', /76 µm/);
    await by(view, 'guide-wire-done').click();
    await text(view, 'guide-limits', /limits\.current_A is 400 mA, below the trip at 450 mA/);
    await by(view, 'guide-limits-done').click();
    await finding(view, 'limits');

    await view.reload();
    await text(view, 'guide', /3 of 7 steps done/);
    await shown(view, 'resistor-ohm');
    assert.equal(await by(view, 'measure').isEnabled(), false, 'measured without a current');
    // The wire stands for the resistor.
    const ohm = Number(await by(view, 'resistor-ohm').inputValue());
    await until(async () => {
      await enabled(view, by(view, 'guide-resistor'));
      await by(view, 'measure').click(soon).catch(() => {});
      const done = by(view, 'guide-resistor-done');
      for (let tries = 0; tries < 50 && !await done.isEnabled(); ++tries) await view.waitForTimeout(100);
      return done.isEnabled();
    }, 'a measured resistance', view);
    await by(view, 'guide-resistor-done').click();
    const read_ohm = Number(/Read ([\d.]+) Ω/.exec(await finding(view, 'resistor'))[1]);
    assert.ok(Math.abs(read_ohm / ohm - 1) < 0.2, `${read_ohm} instead of ${ohm}`);

    // Heated only when it is asked for.
    await until(async () => {
      await enabled(view, by(view, 'guide-heat'));
      await by(view, 'heat').click(soon).catch(() => {});
      await until(async () => await by(view, 'heat').isEnabled() || await by(view, 'drive').textContent() !== 'Enabled: heated',
        'the end of the heating', view);
      return by(view, 'guide-heat-done').isEnabled();
    }, 'a heated wire', view);
    await by(view, 'guide-heat-done').click();
    const [, asked, moved] = /Asked (\d+) µm, estimated ([\d.]+) µm/.exec(await finding(view, 'heat')).map(Number);
    assert.ok(Math.abs(moved - asked) < 0.3 * asked, `${moved} instead of ${asked}`);

    // Left for the step test, and taken up again.
    await text(view, 'guide-tune', /No step test has been run/);
    assert.equal(await by(view, 'guide-tune-done').isEnabled(), false);
    await by(view, 'guide-tune').getByRole('link', {name: 'To the step test'}).click();
    await by(view, 'step-amplitude').fill('300');
    await by(view, 'step-seconds').fill('1');
    await until(() => by(view, 'step-run').isEnabled(), 'a servo that can step', view);
    await by(view, 'step-run').click();
    await shown(view, 'run');
    await go(view, 'guide');
    await by(view, 'guide-tune-done').click();
    assert.match(await finding(view, 'tune'), /rise [\d.]+ ms/);

    await by(view, 'guide-keep-done').click();
    await text(view, 'guide', /All steps are done/);
    await view.reload();
    await text(view, 'guide', /All steps are done/);
    await by(view, 'guide-heat').getByRole('button', {name: 'Do it again'}).click();
    await shown(view, 'heat');
    await text(view, 'guide', /6 of 7 steps done/);
  },

  async 'a recording waits for its trigger, and has what was before it'({view}) {
    await connected(view);
    await move(view, 0);
    await go(view, 'step');
    await by(view, 'trigger').selectOption('position_m');
    await by(view, 'trigger-value').fill('500');
    await by(view, 'record-before').fill('0.2');
    await by(view, 'record-seconds').fill('1');
    await by(view, 'record').click();
    await text(view, 'record', /Waiting for the trigger/);
    await move(view, 1000);
    await go(view, 'step');
    await shown(view, 'recorded');
    await until(async () => await coloured(view, 'plot-record-µm') > 50, 'the recording', view);
    const csv = await download(view, 'save-csv');
    const [head, ...rows] = csv.bytes.toString().trim().split('\n').filter((line) => !line.startsWith('#')).map((line) => line.split(','));
    const at = (column) => rows.map((row) => Number(row[head.indexOf(column)]));
    const [time_s, position_m] = [at('time_s'), at('position_m')];
    const first = position_m.findIndex((position) => position > 0.0005);
    assert.ok(first > 0, head.join());
    assert.ok(Math.abs(time_s[first] - time_s[0] - 0.2) < 0.05, `${time_s[first] - time_s[0]} s before the trigger`);
    const mcap = await download(view, 'save-mcap');
    assert.equal(mcap.bytes.subarray(1, 5).toString(), 'MCAP');
  },

  async 'settings leave as a file, are compared with it, and come back'({view}) {
    await connected(view);
    await go(view, 'parameters');
    await view.locator(`[id="value-${gain}"]`).waitFor();
    const before = await value(view, gain);
    const dumped = await download(view, 'dump-toml');
    assert.equal(dumped.name, 'node1.toml');
    const lines = await download(view, 'dump-can');
    assert.match(lines.bytes.toString(), /^host-sim can .* set \\\n[^]*strain\.proportional_W=/);

    await by(view, 'diff-file').setInputFiles({name: 'node1.toml', mimeType: 'text/plain', buffer: dumped.bytes});
    await text(view, 'differences', /no differences/);
    await view.locator(`[id="value-${gain}"]`).fill('7.5');
    await by(view, 'write').click();
    await until(async () => await value(view, gain) === '7.5', 'the value that is written', view);
    await by(view, 'diff-file').setInputFiles({name: 'node1.toml', mimeType: 'text/plain', buffer: dumped.bytes});
    await text(view, 'differences', /1 difference/);
    assert.deepEqual(await table(view, 'differences'), [[gain, '7.5', before]]);
    await by(view, 'restore').click();
    await until(async () => await value(view, gain) === before, 'the value of the file', view);
    await text(view, 'history', /restored from a file/);

    const broken = {name: 'other.toml', mimeType: 'text/plain', buffer: Buffer.from('strain.proportional_W = "much"')};
    await by(view, 'diff-file').setInputFiles(broken);
    await text(view, 'notice-error', /other\.toml/);
    assert.equal(await value(view, gain), before);
  },

  async 'a loop has its trail, and both come back after a reload'({view}) {
    await connected(view);
    await by(view, 'span-600').click();
    for (const target_um of [0, 1500, 300]) await move(view, target_um);
    await by(view, 'stop').click();
    await text(view, 'drive', (words) => !/Enabled/.test(words));
    for (const plot of ['strain-resistance', 'strain-temperature', 'strain']) {
      await until(async () => await coloured(view, `plot-${plot}`) > 50, `a curve of ${plot}`, view);
    }
    // What came before the reload: the servo is off since, and its strain has stood still.
    await view.reload();
    await connected(view);
    for (const plot of ['strain-temperature', 'strain', 'temperature', 'phases']) {
      await until(async () => await coloured(view, `plot-${plot}`) > 50, `the past of ${plot}`, view);
    }
  },
};

async function run(browser, title, test) {
  const folder = scratch();
  const one = servo(smaservod, sources, folder);
  const shows = await bridge(host_sim);
  const view = await visit(browser, shows.url);
  try {
    await test({view, browser});
    assert.deepEqual(view.errors, []);
    console.log(`ok      ${title}`);
    return true;
  } catch (error) {
    console.log(`FAILED  ${title}\n        ${String(error.stack).split('\n').slice(0, 12).join('\n        ')}`);
    console.log(`        bridge: ${shows.said.slice(-500)}\n        servo: ${one.said.slice(-500)}`);
    return false;
  } finally {
    if (process.env.BROWSER_SHOTS) {
      const shot = path.join(process.env.BROWSER_SHOTS, `${name} ${title.replaceAll(/[^a-z]+/gi, '-')}.png`);
      await view.screenshot({path: shot, fullPage: true}).catch(() => {});
    }
    await view.context().close();
    await shows.stop();
    await one.stop();
    fs.rmSync(folder, {recursive: true});
  }
}

async function main() {
  if (!fs.existsSync(file)) {
    console.log(`SKIPPED: there is no ${file}`);
    process.exit(77);
  }
  const empty = await bridge(host_sim);
  const served = await (await fetch(empty.url)).text();
  await empty.stop();
  if (!served.startsWith('<!')) {
    console.log('SKIPPED: this host-sim has no page, for it was built without npm');
    process.exit(77);
  }
  const browser = await launch(name);
  let failed = 0;
  for (const [title, test] of Object.entries(tests)) {
    if (only.split('|').some((part) => title.includes(part)) && !await run(browser, title, test)) ++failed;
  }
  await browser.close();
  process.exit(failed ? 1 : 0);
}

main();
