// open_reports.js BROWSER: opens reports for panels.py, which gives one job a line as JSON and gets one answer
// a line. A job is {page, folder, name, explore}: each panel becomes a picture in the folder, the page a PDF.
// NODE_PATH names the folder of the npm packages.
'use strict';

const {chromium, firefox} = require('playwright-core');
const path = require('node:path');
const readline = require('node:readline');
const {pathToFileURL} = require('node:url');

const [name] = process.argv.slice(2);
const size = {width: 1100, height: 6000};  // a plot that is out of sight is not drawn
const patience_ms = 120_000;  // only as long as a failed condition takes

const launch = () => (name === 'firefox'
  ? firefox.launch({channel: 'moz-firefox', executablePath: '/usr/bin/firefox-esr', timeout: patience_ms})
  : chromium.launch({executablePath: '/usr/bin/chromium', args: ['--no-sandbox', '--disable-gpu'], timeout: patience_ms}));

/** Whether it comes true. */
async function comes(view, condition, limit_ms = patience_ms) {
  for (const until_ms = Date.now() + limit_ms; Date.now() < until_ms;) {
    if (await condition()) return true;
    await view.waitForTimeout(50);
  }
  return false;
}

/** All plots have been drawn, and stand still. */
async function settled(view) {
  const undrawn = () => view.evaluate(() => document.querySelectorAll('.plot:not([data-drawn])').length);
  await comes(view, async () => await undrawn() === 0);
  let last = '';
  await comes(view, async () => {
    await view.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    const now = (await pixels(view)).join();
    const same = now === last;
    last = now;
    return same;
  });
}

const pixels = (view) => view.evaluate(() =>
  [...document.querySelectorAll('.plot canvas')].map((canvas) => canvas.toDataURL()));
const values = (view) => view.evaluate(() => [...document.querySelectorAll('.plot')].map((plot) =>
  [...plot.querySelectorAll('.plot-value')].map((value) => value.textContent)));

async function panels(view, job) {
  const sections = view.locator('.plots section');
  const boxes = [];
  for (let k = 0; k < await sections.count(); ++k) {
    const canvas = sections.nth(k).locator('canvas');
    const shown = await canvas.count() > 0 ? canvas.first() : sections.nth(k).locator('img').first();
    const file = path.join(job.folder, `${job.name}-${k}.png`);
    await shown.screenshot({path: file, timeout: patience_ms});
    boxes.push(file);
  }
  return boxes;
}

/** What the mouse does not do that it should. The first panels of a replay are linked by time, its last two are
 * loops over the same time. */
async function unexplored(view) {
  const missing = [];
  const must = async (what, condition) => {
    if (!await comes(view, condition, 30_000)) missing.push(what);
  };
  const first = await pixels(view);
  const differ = async () => (await pixels(view)).map((one, k) => one !== first[k]);
  const all = async (value) => (await differ()).every((one) => one === value);
  const over = await view.locator('.plot .u-over').first().boundingBox();
  const at = (x) => [over.x + x * over.width, over.y + 0.5 * over.height];
  if ((await values(view)).some((some) => some.some((value) => value !== ''))) missing.push('no values before');
  await view.mouse.move(...at(0.5));
  await must('values of all linked panels under the cursor', async () =>
    (await values(view)).slice(0, -2).every((some) => some.length > 0 && some.every((value) => value !== '')));
  await must('a dot on the loops under the cursor', async () => (await differ()).slice(-2).every((one) => one));
  await view.mouse.move(...at(0.3));
  await view.mouse.down();
  await view.mouse.move(...at(0.5), {steps: 10});
  await view.mouse.up();
  await must('zoom of all panels', () => all(true));
  // Firefox's protocol makes two single clicks of a double one.
  if (name === 'firefox') await view.locator('.plot .u-over').first().dispatchEvent('dblclick');
  else await view.mouse.dblclick(...at(0.5));
  await view.mouse.move(5, 5);
  await must('all again by a double click', () => all(false));
  const key = view.locator('.plot').first().locator('.plot-key').last();
  const only = async () => (await differ()).every((one, k) => one === (k === 0));
  await key.click();
  await view.mouse.move(5, 5);
  await must('a curve is off, in its panel only', async () =>
    await key.getAttribute('aria-pressed') === 'false' && await only());
  await key.click();
  await view.mouse.move(5, 5);
  await must('and on again', async () => await key.getAttribute('aria-pressed') === 'true' && await all(false));
  return missing;
}

async function open(browser, job) {
  const view = await browser.newPage({viewport: size});
  view.setDefaultTimeout(patience_ms);
  const errors = [];
  view.on('pageerror', (error) => errors.push(error.message));
  await view.goto(pathToFileURL(job.page).href, {timeout: patience_ms});
  await settled(view);
  const answer = {
    width: await view.evaluate(() => document.documentElement.scrollWidth),
    live: await view.locator('.plots section.live').count(),
    pictures: await panels(view, job),
    unexplored: job.explore ? await unexplored(view) : [],
    errors,
  };
  await view.pdf({path: path.join(job.folder, `${job.name}.pdf`)});
  await view.close();
  return answer;
}

async function main() {
  const browser = await launch();
  for await (const line of readline.createInterface({input: process.stdin})) {
    console.log(JSON.stringify(await open(browser, JSON.parse(line))));
  }
  await browser.close();
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
