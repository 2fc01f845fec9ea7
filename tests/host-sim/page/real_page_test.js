// real_page_test.js HOST_SIM SMASERVOD [NAME]: the page in Chromium, before the real bridge and a simulated servo
// of the real daemon, over UDP multicast. To be run in a network of its own (tests/can/own_network.sh), where it
// takes the interface down, too. NODE_PATH names the folder of the npm packages.
'use strict';

const {Bench, execFileSync, number, picture, until} = require('./real_page.js');
const assert = require('node:assert/strict');
const fs = require('node:fs');

const [hostSim, daemon, only] = process.argv.slice(2);
const bench = new Bench(hostSim, daemon);
const gain = 'strain.proportional_W';
// A bridge that does not get to run for a while is not dead.
const patient = ['--watch', '5'];

const at = (page, id) => page.getByTestId(id);
const go = (page, view) => at(page, `tab-${view}`).click();
const drive = (page, text) => at(page, 'drive').filter({hasText: text}).waitFor();

async function edit(page, name, value) {
  await go(page, 'parameters');
  await at(page, 'search').fill(name);
  await page.locator(`[id="value-${name}"]`).fill(value);
}

// Enabled and moved, so that it is warm. Where the machine keeps the bridge or the browser from running for so long
// that the servo switches itself off meanwhile, it is done again.
async function heat(page) {
  const soon = {timeout: 10000};
  await go(page, 'live');
  await until('the wire is heated', async () => {
    try {
      if (await at(page, 'enable').count() > 0) await at(page, 'enable').click(soon);
      await at(page, 'disable').waitFor(soon);
      await at(page, 'mode').selectOption({label: 'profile position'}, soon);
      await at(page, 'target').fill('800', soon);
      await at(page, 'go').click(soon);
    } catch {
      return false;
    }
    return bench.flows();
  });
}

async function download(page, id) {
  const [file] = await Promise.all([page.waitForEvent('download'), at(page, id).first().click()]);
  return {name: file.suggestedFilename(), bytes: fs.readFileSync(await file.path())};
}

let bridge, page;

const tests = {
  async 'it finds the servo, draws it, and asks for nothing else'() {
    await drive(page, /off/i);
    await until('samples', async () => Number(await at(page, 'rate').getAttribute('data-received')) > 100);
    const before = await picture(page);
    assert.ok(before.length >= 3, `${before.length} plots`);
    for (const one of before) assert.ok(one.drawn > 500, 'an empty plot');
    await until('some plot moves', async () => (await picture(page)).some((one, i) => one.sum !== before[i].sum));
    const origin = new URL(bridge.url).origin;
    for (const url of page.asked) assert.ok(url.startsWith(origin) || /^(data|blob):/.test(url), url);
  },

  async 'it enables, moves, and shows what the servo says'() {
    const cold = await picture(page);
    await heat(page);
    await until('the position', async () => {
      const shown = await number(at(page, 'reading-position_m'));
      return Math.abs(shown - 800) < 120;
    });
    const shown = await number(at(page, 'reading-position_m'));
    assert.ok(Math.abs(1e6 * await bench.read('live.position_m') - shown) < 100);
    await at(page, 'control').filter({hasText: 'You have control'}).waitFor();
    await until('each plot has moved', async () => {
      const warm = await picture(page);
      return warm.length === cold.length && warm.every((one, i) => one.sum !== cold[i].sum);
    });
  },

  async 'the space bar and the button stop it, in another browser as well'() {
    for (const press of [
      () => page.keyboard.press('Space'),
      () => at(page, 'stop').click(),
      async () => {
        await go(page, 'parameters');
        await at(page, 'search').focus();
        await page.keyboard.press('Escape');
      },
    ]) {
      await go(page, 'live');
      if (await at(page, 'enable').count() > 0) await heat(page);
      await press();
      await until('it is off', async () => !(await bench.flows()));
      await go(page, 'live');
      await at(page, 'enable').waitFor();
    }
    await heat(page);
    const other = await bench.open(bridge.url);
    await at(other, 'control').filter({hasText: /Client \d+ .*has control/}).waitFor();
    assert.equal(await at(other, 'disable').isEnabled(), false, 'it may not write');
    await at(other, 'stop').click();
    await until('it is off', async () => !(await bench.flows()));
    await at(page, 'enable').waitFor();
    await other.context().close();
  },

  async 'an edit is tried, reverts by itself, is kept, undone'() {
    const before = await bench.read(gain);
    await go(page, 'parameters');
    await at(page, 'try-seconds').selectOption('10');
    await edit(page, gain, '7.5');
    await at(page, 'try').click();
    await at(page, 'trial').waitFor();
    assert.equal(await bench.read(gain), 7.5);
    await at(page, 'trial').waitFor({state: 'detached'});
    await until('the value before', async () => (await bench.read(gain)) === before);
    await until('the page shows it', async () =>
      Number(await page.locator(`[id="value-${gain}"]`).inputValue()) === before);
    await edit(page, gain, '6.5');
    await at(page, 'try').click();
    await at(page, 'keep').click();
    await at(page, 'trial').waitFor({state: 'detached'});
    assert.equal(await bench.read(gain), 6.5);
    await at(page, 'undo').click();
    await until('undone', async () => (await bench.read(gain)) === before);
    await edit(page, gain, '8.25');
    await at(page, 'write').click();
    await until('written', async () => (await bench.read(gain)) === 8.25);
    await at(page, 'store').click();
    await page.getByText('stored', {exact: true}).waitFor();
  },

  async 'what the servo refuses is said, and changes nothing'() {
    const before = await bench.read('limits.current_A');
    // Out of its range: the page knows that.
    await edit(page, 'limits.current_A', '99');
    await page.getByText(/0\.001 .*20/).first().waitFor();
    assert.equal(await at(page, 'write').isEnabled(), false);
    await at(page, 'discard').click();
    // Against another parameter: only the servo knows.
    await edit(page, 'limits.current_A', '19');
    await at(page, 'write').click();
    await at(page, 'notice-error').filter({hasText: 'limits.current_A'}).first().waitFor();
    assert.equal(await bench.read('limits.current_A'), before);
    await at(page, 'discard').click();
    // A change of another master is seen.
    assert.notEqual(await bench.can('set', `${gain}=5.75`), null);
    await at(page, 'search').fill(gain);
    await until('the other master', async () =>
      Number(await page.locator(`[id="value-${gain}"]`).inputValue()) === 5.75);
  },

  async 'a step is run over the last one, and leaves as CSV and MCAP'() {
    await go(page, 'step');
    await at(page, 'step-seconds').fill('1');
    for (const runs of [1, 2]) {
      await at(page, 'step-run').click();
      await until(`run ${runs}`, async () => await at(page, 'run').count() === runs);
    }
    const cells = await at(page, 'run').first().locator('td').allTextContents();
    const [rise_ms, hottest_degC] = [cells[3], cells[7]].map(Number);
    assert.ok(rise_ms > 0 && rise_ms < 1000, cells.join('|'));
    assert.ok(hottest_degC > 25 && hottest_degC < 150, cells.join('|'));
    assert.ok(await page.locator('[data-testid="step-plots"] canvas').count() >= 3);
    const csv = await download(page, 'save-csv');
    assert.match(csv.bytes.toString(), /^time_s,.*position_m.*\n0,/);
    const mcap = await download(page, 'save-mcap');
    assert.equal(mcap.bytes.subarray(0, 8).toString('latin1'), '\x89MCAP0\r\n');
    const file = `${bench.folder}/step.mcap`;
    fs.writeFileSync(file, mcap.bytes);
    execFileSync(hostSim, ['convert', file, '--out', `${bench.folder}/step.csv`]);
    assert.equal(fs.readFileSync(`${bench.folder}/step.csv`, 'utf8'), csv.bytes.toString());
    await until('it is off', async () => !(await bench.flows()));
  },

  async 'a reload loses nothing'() {
    const answers = [];
    page.on('websocket', (socket) => socket.on('framereceived', ({payload}) => {
      const text = payload.toString();
      const from = text.indexOf('{"');
      if (typeof payload !== 'string' && text.includes('"t_ns"')) answers.push(JSON.parse(text.slice(from)));
    }));
    const reloaded_ns = Date.now() * 1e6;
    await page.reload();
    await drive(page, /off/i);
    await until('the history', () => answers.length > 0);
    const times = answers[0].t_ns;
    assert.ok(reloaded_ns - times[0] > 10e9, 'it began long before the reload');
    assert.ok(times.every((time, i) => i === 0 || time >= times[i - 1]));
    await go(page, 'step');
    await until('the runs', async () => await at(page, 'run').count() === 2);
  },

  async 'a servo that is killed is missed, comes back, and is not enabled'() {
    await heat(page);
    await bench.daemon.end('SIGKILL');
    await at(page, 'offline').waitFor();
    await bench.startServo();
    await at(page, 'offline').waitFor({state: 'detached'});
    await at(page, 'enable').waitFor();
    assert.equal(await bench.flows(), false);
    assert.equal(await bench.read(gain), 8.25, 'what was stored');
    // A wire that was hot when its program was killed is not heated before somebody says so.
    await at(page, 'blocked').filter({hasText: 'unclean_boot'}).waitFor();
    assert.equal(await at(page, 'enable').isEnabled(), false);
    assert.notEqual(await bench.can('reset-faults'), null);
    await at(page, 'blocked').waitFor({state: 'detached'});
  },

  async 'a bus that is down is said, and heats nothing'() {
    await heat(page);
    execFileSync('ip', ['link', 'set', 'here', 'down']);
    await until('trouble', async () => await at(page, 'bus-trouble').count() + await at(page, 'offline').count() > 0);
    execFileSync('ip', ['link', 'set', 'here', 'up']);
    execFileSync('ip', ['route', 'replace', '224.0.0.0/4', 'dev', 'here']);
    await at(page, 'offline').waitFor({state: 'detached'});
    await until('it is off', async () => !(await bench.flows()));
  },

  async 'a bridge that is killed leaves no heat, and the page says what it is'() {
    await heat(page);
    await bridge.end('SIGKILL');
    await at(page, 'lost').waitFor();
    await until('it is off', async () => !(await bench.flows()));
    bridge = await bench.startBridge(...patient);
    await at(page, 'lost').waitFor({state: 'detached'});
    await drive(page, /off/i);
    assert.equal(await bench.flows(), false);
  },

  async 'the last page that goes ends the heat'() {
    await heat(page);
    await page.context().close();
    await until('it is off', async () => !(await bench.flows()));
    page = await bench.open(bridge.url);
  },

  async 'a bridge that only shows offers nothing to write'() {
    assert.deepEqual(page.mistakes, []);
    await bridge.end();
    bridge = await bench.startBridge('--read-only');
    const viewer = await bench.open(bridge.url);
    await at(viewer, 'read-only').waitFor();
    await at(viewer, 'enable').waitFor();
    assert.equal(await at(viewer, 'enable').isEnabled(), false);
    await viewer.context().close();
  },
};

async function main() {
  const {main: run} = require('./test_clients.js');
  await bench.startServo();
  bridge = await bench.startBridge(...patient);
  const missing = await bench.missing(bridge.url);
  if (missing) {
    console.log(`${missing}: not tested`);
    await bench.close();
    process.exit(77);
  }
  page = await bench.open(bridge.url);
  const failed = await run(tests, only, 240000);
  if (failed > 0) {
    await page.screenshot({path: 'page_failed.png', fullPage: true}).catch(() => {});
    console.log(page.mistakes, bridge.said, bench.daemon.said, await bench.can('faults'));
  }
  await bench.close();
  process.exit(failed === 0 ? 0 : 1);
}

main().catch(async (error) => {
  console.log(error);
  await bench.close();
  process.exit(1);
});
