// What the tests of the real page need: the bridge and a servo on a simulated wire as processes, on a bus
// that nobody else is on (tests/can/own_network.sh), and the system's browsers.
'use strict';

const {chromium, firefox} = require('playwright-core');
const {spawn} = require('node:child_process');
const {once} = require('node:events');
const fs = require('node:fs');
const os = require('node:os');
const path = require('node:path');

// A machine may be busy: this is only how long a failed test waits.
const patience_ms = 120_000;

const running = new Set();
process.on('exit', () => {
  for (const one of running) one.kill('SIGKILL');
});

class Program {
  constructor(file, ...options) {
    this.process = spawn(file, options, {stdio: ['ignore', 'pipe', 'pipe']});
    running.add(this.process);
    this.said = '';
    for (const stream of [this.process.stdout, this.process.stderr]) {
      stream.on('data', (bytes) => (this.said += bytes));
    }
    this.ended = new Promise((done) => {
      this.process.on('exit', (code, signal) => {
        running.delete(this.process);
        done(code ?? signal);
      });
    });
  }

  async stop(signal = 'SIGTERM') {
    this.process.kill(signal);
    return this.ended;
  }
}

/** A servo that keeps its settings in a folder; 250 Hz, so that a busy machine is no fault of its loop. */
function servo(smaservod, sources, folder) {
  fs.mkdirSync(path.join(folder, 'store'), {recursive: true});
  const device = path.join(folder, 'device.toml');
  fs.writeFileSync(device, fs.readFileSync(path.join(sources, 'tests/can/device.toml'), 'utf8') +
    '\n[identity]\nnode_id = 1\n\n[timing]\nperiod_ms = 4\nsample_timeout_ms = 100\n');
  return new Program(smaservod, '--board', 'sim', '--bus', 'udp', '--device', device,
    '--settings', path.join(folder, 'store'), '--no-real-time');
}

/** The bridge at a free port; its first line is its address. */
async function bridge(host_sim, ...options) {
  const program = new Program(host_sim, 'page', '--can', 'udp', '--listen', '127.0.0.1:0', '--watch', '5', ...options);
  await Promise.race([once(program.process.stdout, 'data'), program.ended]);
  const found = /https?:\/\/\S+/.exec(program.said);
  if (!found) throw new Error(`no address of the bridge: ${program.said}`);
  program.url = found[0];
  return program;
}

/** A browser of the system: Chromium by its own protocol, Firefox by WebDriver BiDi. */
function launch(name) {
  return name === 'firefox'
    ? firefox.launch({channel: 'moz-firefox', executablePath: '/usr/bin/firefox-esr', timeout: patience_ms})
    : chromium.launch({executablePath: '/usr/bin/chromium', args: ['--no-sandbox'], timeout: patience_ms});
}

/** A page of its own person, who remembers nothing; its errors are kept. */
async function visit(browser, url, viewport = {width: 1280, height: 900}) {
  const person = await browser.newContext({viewport});
  person.setDefaultTimeout(patience_ms);
  person.setDefaultNavigationTimeout(patience_ms);
  const view = await person.newPage();
  view.errors = [];
  view.on('pageerror', (error) => view.errors.push(error.message));
  await view.goto(url);
  return view;
}

const by = (view, name) => view.locator(`[data-testid="${name}"]`).first();
const shown = (view, name) => by(view, name).waitFor();
const gone = (view, name) => by(view, name).waitFor({state: 'hidden'});

/** Waits until a text fulfils a condition, and gives it. */
async function text(view, name, condition) {
  const until_ms = Date.now() + patience_ms;
  let last = '';
  while (Date.now() < until_ms) {
    last = await by(view, name).textContent({timeout: patience_ms});
    if (condition instanceof RegExp ? condition.test(last) : condition(last)) return last;
    await view.waitForTimeout(50);
  }
  throw new Error(`${name} says "${last}", waited for ${condition}`);
}

/** How many pixels of a plot's canvas have a colour, without axes and grid, which are grey. */
function coloured(view, name) {
  return by(view, name).locator('canvas').first().evaluate((canvas) => {
    const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let at = 0; at < data.length; at += 4) {
      const [low, high] = [Math.min(data[at], data[at + 1], data[at + 2]), Math.max(data[at], data[at + 1], data[at + 2])];
      if (data[at + 3] > 100 && high - low > 60) ++count;
    }
    return count;
  });
}

/** The picture of a plot, to be compared. */
const picture = (view, name) =>
  by(view, name).locator('canvas').first().evaluate((canvas) => canvas.toDataURL());

async function until(condition, what, view) {
  const until_ms = Date.now() + patience_ms;
  while (Date.now() < until_ms) {
    if (await condition()) return;
    await view.waitForTimeout(100);
  }
  throw new Error(`waited for: ${what}`);
}

const scratch = () => fs.mkdtempSync(path.join(os.tmpdir(), 'smaservo-browser-'));

module.exports = {Program, bridge, by, coloured, gone, launch, picture, scratch, servo, shown, text, until, visit};
