// The world of one test: a bridge and a servo on a simulated wire as processes, another master that looks at the servo
// by itself, and the system's browsers. The bus is nobody else's: multicast in a network of its own
// (tests/can/own_network.sh), or SERVO_BUS, an interface of a kernel of its own (toolchain/can/uml).
'use strict';

const { chromium, firefox } = require('playwright-core');
const { execFile, execFileSync, spawn } = require('node:child_process');
const fs = require('node:fs');
const os = require('node:os');
const path = require('node:path');
const { promisify } = require('node:util');

// Only a program that hangs takes so long; less where a person looks for what hangs.
const patience_ms = 1000 * Number(process.env.BROWSER_PATIENCE_S ?? 600);

// The longest silences of a bridge before a servo ends its heat, of a browser before the bridge does, and of a servo
// that was asked: those that a busy machine does not let run for a while are not dead. What is about these has a shorter
// watch.
const calm = ['--watch', '60', '--patience', '60', '--timeout', '10'];
const short_watch_s = 5;

const bus = process.env.SERVO_BUS ?? 'udp';
// What carries it. Multicast goes out by either end of the test's network.
const links = bus === 'udp' ? ['here', 'there'] : [bus];

const programs = {
  chromium: process.env.CHROMIUM ?? '/usr/bin/chromium',
  firefox: process.env.FIREFOX ?? '/usr/bin/firefox-esr',
};

const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

/** Waits until the condition gives something, and gives that. */
async function until(what, condition) {
  const end_ms = Date.now() + patience_ms;
  for (;;) {
    const result = await condition();
    if (result) {
      return result;
    }
    if (Date.now() > end_ms) {
      throw new Error(`does not come: ${typeof what === 'string' ? what : what()}`);
    }
    await sleep(100);
  }
}

/** The first processor that this process may use. */
const firstProcessor = () => /^Cpus_allowed_list:\s*(\d+)/m.exec(fs.readFileSync('/proc/self/status', 'utf8'))[1];

const running = new Set();
process.on('exit', () => {
  for (const one of running) {
    one.kill('SIGKILL');
  }
});

class Program {
  constructor(file, ...options) {
    this.process = spawn(file, options, { stdio: ['ignore', 'pipe', 'pipe'] });
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

class World {
  constructor({ host_sim, smaservod, sources }, browser) {
    Object.assign(this, { host_sim, smaservod, sources, browser });
    this.folder = fs.mkdtempSync(path.join(os.tmpdir(), 'smaservo-browser-'));
    this.views = [];
    this.port = 0; // any for the first bridge, then the same one
  }

  /**
   * 250 Hz, so that a busy machine is no fault of its loop; its settings outlast it. The wire's time stands still while
   * the loop waits for a processor, but not while its bus's thread does, from which commands come (command_timeout): on
   * one processor neither thread goes on for long without the other.
   */
  async startServo() {
    fs.mkdirSync(path.join(this.folder, 'store'), { recursive: true });
    const device = path.join(this.folder, 'device.toml');
    fs.writeFileSync(
      device,
      ['device.toml', 'node_1_at_250_Hz.toml']
        .map((name) => fs.readFileSync(path.join(this.sources, 'tests/can', name), 'utf8'))
        .concat('command_timeout_ms = 60000\n')
        .join(''),
    );
    this.servo = new Program(
      'taskset',
      '--cpu-list',
      firstProcessor(),
      this.smaservod,
      '--board',
      'sim',
      '--bus',
      bus,
      '--device',
      device,
      '--settings',
      path.join(this.folder, 'store'),
      '--no-real-time',
    );
    await until('the servo answers', () => this.can('get', '1018:1'));
  }

  async startBridge(...options) {
    if (!options.includes('--watch')) {
      options.push(...calm);
    }
    const bridge = new Program(this.host_sim, 'page', '--can', bus, '--listen', `127.0.0.1:${this.port}`, ...options);
    const found = await until('the address of the bridge', () =>
      bridge.process.exitCode === null ? /^https?:\S+/m.exec(bridge.said) : [''],
    );
    if (!found[0]) {
      throw new Error(`no address of the bridge: ${bridge.said}`);
    }
    this.url = found[0];
    this.port = Number(new URL(this.url).port);
    this.bridge = bridge;
  }

  /** What another master on the bus is told; null: nothing, which may be as the bridge asks at that moment, too. A node
   * answers one of two requests that meet, and the bridge writes once: so nobody asks here while the page writes. */
  async can(...words) {
    try {
      const { stdout } = await promisify(execFile)(this.host_sim, ['can', '--can', bus, '--timeout', '2', ...words]);
      return stdout;
    } catch {
      return null;
    }
  }

  /** The bus, `up` or `down`. */
  link(state) {
    for (const name of links) {
      execFileSync('ip', ['link', 'set', name, state]);
    }
  }

  /** A value of the servo, which must answer. */
  async read(name) {
    const text = await until(name, () => this.can('get', name));
    return Number(text.match(/(-?[0-9][0-9.e+-]*)/g).at(-1));
  }

  /** Whether current flows, as the servo has measured it. */
  async heated() {
    return (await this.read('live.current_A')) > 0.01;
  }

  /** The page as a person of its own sees it, who remembers nothing. */
  async visit(options = {}) {
    const person = await this.browser.newContext({ viewport: { width: 1280, height: 900 }, ...options });
    person.setDefaultTimeout(patience_ms);
    person.setDefaultNavigationTimeout(patience_ms);
    const view = await person.newPage();
    Object.assign(view, { errors: [], asked: [] });
    // What the page has said in passing: a notice goes by itself.
    await view.addInitScript(() => {
      window.noticed = [];
      window.failed = [];
      new MutationObserver((changes) => {
        const said = new Set();
        for (const { target, addedNodes } of changes) {
          // One that is said again says so in its text.
          const around = (target.nodeType === Node.ELEMENT_NODE ? target : target.parentElement)?.closest(
            '[data-testid^=notice-]',
          );
          const inside = [...addedNodes]
            .filter((node) => node.nodeType === Node.ELEMENT_NODE)
            .flatMap((node) =>
              [node, ...node.querySelectorAll('*')].filter((one) => one.dataset?.testid?.startsWith('notice-')),
            );
          for (const notice of around ? [around, ...inside] : inside) {
            said.add(notice.textContent);
            if (notice.dataset.testid === 'notice-error') {
              window.failed.push(notice.textContent);
            }
          }
        }
        window.noticed.push(...said);
      }).observe(document, { childList: true, subtree: true, characterData: true });
    });
    // That nobody listens, or that a reload ends a connection, is an error of the page to Firefox.
    const expected = /establish a connection|interrupted while the page was loading/;
    view.on('pageerror', ({ message }) => expected.test(message) || view.errors.push(message));
    view.on('request', (request) => view.asked.push(request.url()));
    await view.goto(this.url);
    this.views.push(view);
    return view;
  }

  async end() {
    for (const view of this.views) {
      await view.context().close();
    }
    for (const program of [this.bridge, this.servo]) {
      await program?.stop('SIGKILL');
    }
    fs.rmSync(this.folder, { recursive: true });
  }
}

/** A browser of the system: Chromium by its own protocol, Firefox by WebDriver BiDi. */
function launch(name) {
  const executablePath = programs[name];
  return name === 'firefox'
    ? firefox.launch({ channel: 'moz-firefox', executablePath, timeout: patience_ms })
    : chromium.launch({ executablePath, args: ['--no-sandbox', '--disable-gpu'], timeout: patience_ms });
}

const by = (view, name) => view.locator(`[data-testid="${name}"]`).first();
const shown = (view, name) => by(view, name).waitFor();
const gone = (view, name) => by(view, name).waitFor({ state: 'hidden' });

/** Waits until the page has said so in a notice, after the first `since` ones. */
const noticed = (view, words, since = 0) =>
  until(`a notice: ${words}`, async () =>
    (await view.evaluate(() => window.noticed)).slice(since).some((said) => words.test(said)),
  );

/** As until(), of what the page has been asked for: an error that it says meanwhile is the answer. */
async function succeeds(view, what, condition) {
  const before = await view.evaluate(() => window.failed.length);
  await until(what, async () => {
    const [failure] = (await view.evaluate(() => window.failed)).slice(before);
    if (failure) {
      throw new Error(`${what}: the page says: ${failure}`);
    }
    return await condition();
  });
}

/** How many notices there have been. */
const notices = (view) => view.evaluate(() => window.noticed.length);

/** Waits until something can be pressed or filled in, or cannot. */
const usable = (place, wanted = true) =>
  until(`${place} ${wanted ? '' : 'not '}usable`, async () => (await place.isEnabled()) === wanted);

/** Waits until a text fulfils a condition, and gives it. */
async function text(view, name, condition) {
  let last = '';
  const fulfils = (words) => (condition instanceof RegExp ? condition.test(words) : condition(words));
  try {
    await until(name, async () => fulfils((last = await by(view, name).textContent())));
  } catch {
    throw new Error(`${name} says "${last}", waited for ${condition}`);
  }
  return last;
}

/** How many pixels of a plot's canvas have a colour, without axes and grid, which are grey. */
function coloured(view, name) {
  return by(view, name)
    .locator('canvas')
    .first()
    .evaluate((canvas) => {
      const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
      let count = 0;
      for (let at = 0; at < data.length; at += 4) {
        const [low, high] = [
          Math.min(data[at], data[at + 1], data[at + 2]),
          Math.max(data[at], data[at + 1], data[at + 2]),
        ];
        if (data[at + 3] > 100 && high - low > 60) {
          ++count;
        }
      }
      return count;
    });
}

/** The picture of a plot, to be compared. */
const picture = (view, name) =>
  by(view, name)
    .locator('canvas')
    .first()
    .evaluate((canvas) => canvas.toDataURL());

/** A file that a button of the page gives. Firefox's protocol does not tell of it: there it is taken from the page. */
async function download(view, name) {
  if (view.context().browser().browserType().name() === 'chromium') {
    const [file] = await Promise.all([view.waitForEvent('download'), by(view, name).click()]);
    return fs.readFileSync(await file.path());
  }
  await view.evaluate(() => {
    const make = URL.createObjectURL;
    URL.createObjectURL = (blob) => make.call(URL, (window.saved = blob));
  });
  await by(view, name).click();
  const bytes = await until(`the file of ${name}`, () =>
    view.evaluate(async () => (window.saved ? [...new Uint8Array(await window.saved.arrayBuffer())] : null)),
  );
  await view.evaluate(() => delete window.saved);
  return Buffer.from(bytes);
}

module.exports = {
  World,
  bus,
  by,
  coloured,
  download,
  gone,
  launch,
  noticed,
  notices,
  picture,
  programs,
  short_watch_s,
  shown,
  succeeds,
  text,
  until,
  usable,
};
