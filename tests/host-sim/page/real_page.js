// What the tests of the real page need: a simulated servo of the real daemon, the bridge, browsers, and
// `host-sim can` as an independent look at the servo.
'use strict';

const assert = require('node:assert/strict');
const {execFile, execFileSync, spawn} = require('node:child_process');
const {once} = require('node:events');
const fs = require('node:fs');
const os = require('node:os');
const path = require('node:path');
const {promisify} = require('node:util');
const {chromium} = require('playwright-core');

// As long as whatever is waited for may take on a machine that does much else. Nothing is measured by it.
const patience_ms = 90000;
const bus = 'udp';
const browserProgram = process.env.CHROMIUM ?? '/usr/bin/chromium';

const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

// Waits until `condition` gives something, which is returned.
async function until(what, condition) {
  const end = Date.now() + patience_ms;
  for (;;) {
    const result = await condition();
    if (result) return result;
    assert.ok(Date.now() < end, `does not come: ${what}`);
    await sleep(100);
  }
}

const running = new Set();
process.on('exit', () => {
  for (const one of running) one.kill('SIGKILL');
});

class Process {
  constructor(program, args) {
    this.name = path.basename(program);
    this.process = spawn(program, args);
    running.add(this.process);
    this.said = '';
    for (const stream of [this.process.stdout, this.process.stderr]) {
      stream.on('data', (bytes) => (this.said += bytes));
    }
    this.ended = once(this.process, 'exit').then(([code, signal]) => {
      running.delete(this.process);
      return code ?? signal;
    });
  }
  async end(signal = 'SIGTERM') {
    this.process.kill(signal);
    return this.ended;
  }
}

class Bench {
  constructor(hostSim, daemon) {
    this.hostSim = hostSim;
    this.daemonProgram = daemon;
    this.folder = fs.mkdtempSync(path.join(os.tmpdir(), 'smaservo-page-'));
    this.port = 0;  // any for the first bridge, then the same one
  }

  async startServo() {
    this.daemon = new Process(this.daemonProgram, ['--board', 'sim', '--bus', bus, '--no-real-time',
      '--settings', path.join(this.folder, 'store')]);
    await until('the servo answers', async () => (await this.can('get', '1018:1')) !== null);
  }
  async startBridge(...options) {
    const bridge = new Process(this.hostSim,
      ['page', '--can', bus, '--listen', `127.0.0.1:${this.port}`, ...options]);
    const url = await until('the bridge says where it is', () => bridge.said.match(/^http\S+/m)?.[0]);
    bridge.url = url;
    this.port = Number(new URL(url).port);
    return bridge;
  }
  // What another master on the bus is told; null: the servo did not answer.
  async can(...words) {
    try {
      const {stdout} = await promisify(execFile)(this.hostSim, ['can', '--can', bus, '--timeout', '2', ...words]);
      return stdout;
    } catch {
      return null;
    }
  }
  // A value of the servo.
  async read(name) {
    const text = await until(name, () => this.can('get', name));
    const found = text.match(/(-?[0-9][0-9.e+-]*)/g);
    return Number(found.at(-1));
  }
  // Whether current flows, as the servo has measured it.
  async flows() {
    const measured_A = await this.read('live.measured_A');
    return measured_A > 0.01;
  }

  // What a machine lacks to show the page; "" where nothing.
  async missing(url) {
    if (!fs.existsSync(browserProgram)) return `${browserProgram} is missing`;
    const page = await (await fetch(url)).text();
    return page.startsWith('<!') ? '' : 'this host-sim has no page, for it was built without npm';
  }

  async open(url, options = {}) {
    this.browser ??= await chromium.launch({executablePath: browserProgram,
      args: ['--no-sandbox', '--disable-gpu']});
    const context = await this.browser.newContext({viewport: {width: 1280, height: 900}, ...options});
    const page = await context.newPage();
    page.setDefaultTimeout(patience_ms);
    page.mistakes = [];
    page.asked = [];
    page.on('pageerror', (error) => page.mistakes.push(String(error)));
    page.on('console', (message) => message.type() === 'error' && page.mistakes.push(message.text()));
    page.on('request', (request) => page.asked.push(request.url()));
    await page.goto(url);
    await page.getByTestId('servo').waitFor();
    return page;
  }

  async close() {
    await this.browser?.close();
    for (const one of [...running]) one.kill('SIGKILL');
    fs.rmSync(this.folder, {recursive: true, force: true});
  }
}

// The pixels of all plots as numbers that change with them.
function picture(page) {
  return page.locator('.panel canvas').evaluateAll((all) => all.map((canvas) => {
    const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    let drawn = 0, sum = 0;
    for (let i = 0; i < data.length; i += 4) {
      drawn += data[i + 3] > 0 ? 1 : 0;
      sum = (sum * 31 + data[i] + data[i + 1] + data[i + 2] + data[i + 3]) % 1000003;
    }
    return {drawn, sum};
  }));
}

const number = async (place) => Number((await place.textContent()).replace('−', '-'));

module.exports = {Bench, execFileSync, number, picture, sleep, until};
