// open_reports.js BROWSER: opens reports for panels.py, which gives one job a line as JSON and gets one answer
// a line. A job is {page, screen, pdf, explore}: the screen becomes the picture `screen`, of which the answer has
// the boxes of the panels; the page becomes a PDF, unless `pdf` is null; the mouse is moved if `explore` is true.
// NODE_PATH names the folder of the npm packages.
'use strict';

const { chromium, firefox } = require('playwright-core');
const readline = require('node:readline');
const { pathToFileURL } = require('node:url');

const [name] = process.argv.slice(2);
const width = 1100;
const patience_ms = 120_000; // only a page that hangs or is broken takes so long

const launch = () =>
  name === 'firefox'
    ? firefox.launch({ channel: 'moz-firefox', executablePath: '/usr/bin/firefox-esr', timeout: patience_ms })
    : chromium.launch({
        executablePath: '/usr/bin/chromium',
        args: ['--no-sandbox', '--disable-gpu'],
        timeout: patience_ms,
      });

const drawn = (view) =>
  view.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));

/** Looks after each drawing of the page whether it has come true. */
async function comes(view, what, condition) {
  for (const until_ms = Date.now() + patience_ms; Date.now() < until_ms; ) {
    if (await condition()) {
      return;
    }
    await drawn(view);
  }
  throw new Error(`has not come: ${what}`);
}

/** All plots have been drawn, and stand still. */
async function settled(view) {
  // A plot that is out of sight is not drawn.
  const height = await view.evaluate(() => document.documentElement.scrollHeight);
  await view.setViewportSize({ width, height: height + 500 });
  await comes(view, 'all plots are drawn', () =>
    view.evaluate(() => document.querySelectorAll('.plot:not([data-drawn])').length === 0),
  );
  await view.evaluate(() =>
    Promise.all([...document.images].filter((image) => image.checkVisibility()).map((image) => image.decode())),
  );
  let last = '';
  await comes(view, 'all plots stand still', async () => {
    await drawn(view);
    const now = (await pixels(view)).join();
    const same = now === last;
    last = now;
    return same;
  });
}

const pixels = (view) =>
  view.evaluate(() => [...document.querySelectorAll('.plot canvas')].map((canvas) => canvas.toDataURL()));
const values = (view) =>
  view.evaluate(() =>
    [...document.querySelectorAll('.plot')].map((plot) =>
      [...plot.querySelectorAll('.plot-value')].map((value) => value.textContent),
    ),
  );

/** Left, top, right and bottom of each panel's plot, or of the picture in its place. */
const boxes = (view) =>
  view.evaluate(() =>
    [...document.querySelectorAll('.plots section')].map((section) => {
      const box = (section.querySelector('canvas') ?? section.querySelector('img')).getBoundingClientRect();
      return [box.left + scrollX, box.top + scrollY, box.right + scrollX, box.bottom + scrollY].map(Math.round);
    }),
  );

/** Ends with an error where the mouse does not do what it should. The first panels of a replay are linked by
 * time, its last two are loops over the same time. */
async function explore(view) {
  const must = (what, condition) => comes(view, what, condition);
  const first = await pixels(view);
  const differ = async () => (await pixels(view)).map((one, k) => one !== first[k]);
  const all = async (value) => (await differ()).every((one) => one === value);
  const over = await view.locator('.plot .u-over').first().boundingBox();
  const at = (x) => [over.x + x * over.width, over.y + 0.5 * over.height];
  if ((await values(view)).some((some) => some.some((value) => value !== ''))) {
    throw new Error('has values before');
  }
  await view.mouse.move(...at(0.5));
  await must('values of all linked panels under the cursor', async () =>
    (await values(view)).slice(0, -2).every((some) => some.length > 0 && some.every((value) => value !== '')),
  );
  await must('a dot on the loops under the cursor', async () => (await differ()).slice(-2).every((one) => one));
  await view.mouse.move(...at(0.3));
  await view.mouse.down();
  await view.mouse.move(...at(0.5), { steps: 10 });
  await view.mouse.up();
  await must('zoom of all panels', () => all(true));
  // Firefox's protocol makes two single clicks of a double one.
  if (name === 'firefox') {
    await view.locator('.plot .u-over').first().dispatchEvent('dblclick');
  } else {
    await view.mouse.dblclick(...at(0.5));
  }
  await view.mouse.move(5, 5);
  await must('all again by a double click', () => all(false));
  const key = view.locator('.plot').first().locator('.plot-key').last();
  const only = async () => (await differ()).every((one, k) => one === (k === 0));
  await key.click();
  await view.mouse.move(5, 5);
  await must(
    'a curve is off, in its panel only',
    async () => (await key.getAttribute('aria-pressed')) === 'false' && (await only()),
  );
  await key.click();
  await view.mouse.move(5, 5);
  await must('and on again', async () => (await key.getAttribute('aria-pressed')) === 'true' && (await all(false)));
}

async function open(browser, job) {
  const view = await browser.newPage({ viewport: { width, height: 1000 } });
  view.setDefaultTimeout(patience_ms);
  const errors = [];
  view.on('pageerror', (error) => errors.push(error.message));
  await view.goto(pathToFileURL(job.page).href, { timeout: patience_ms });
  await settled(view);
  const answer = {
    width: await view.evaluate(() => document.documentElement.scrollWidth),
    live: await view.locator('.plots section.live').count(),
    boxes: await boxes(view),
    missing: [],
    errors,
  };
  await view.screenshot({ path: job.screen, timeout: patience_ms });
  if (job.explore) {
    await explore(view).catch((error) => answer.missing.push(error.message));
  }
  if (job.pdf) {
    await view.pdf({ path: job.pdf });
  }
  await view.close();
  return answer;
}

async function main() {
  const browser = await launch();
  for await (const line of readline.createInterface({ input: process.stdin })) {
    console.log(JSON.stringify(await open(browser, JSON.parse(line))));
  }
  await browser.close();
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
