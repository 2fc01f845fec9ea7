// main.js BROWSER HOST_SIM SMASERVOD SOURCES [TITLE|TITLE...]: a person before the real page, with a real bridge
// and a real servo on a simulated wire, each test with its own. Run by own_network.sh, or in a guest (world.js);
// NODE_PATH names the folder of the npm packages. BROWSER_SHOTS=FOLDER
// keeps a picture of each test's end. A missing browser, and a host-sim without its page, are failures.
'use strict';

const { World, launch, programs } = require('./world.js');
const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');

const [name, host_sim, smaservod, sources, only = ''] = process.argv.slice(2);

const tests = {
  ...require('./live.js'),
  ...require('./parameters.js'),
  ...require('./steps.js'),
  ...require('./guide.js'),
  ...require('./commission.js'),
  ...require('./control.js'),
  ...require('./losses.js'),
  ...require('./others.js'),
};

async function shoot(view, title) {
  if (!process.env.BROWSER_SHOTS || view.isClosed()) {
    return;
  }
  const file = path.join(process.env.BROWSER_SHOTS, `${name} ${title.replaceAll(/[^a-z]+/gi, '-')}.png`);
  await view.screenshot({ path: file, fullPage: true }).catch(() => {});
}

async function passes(browser, title, test) {
  const world = new World({ host_sim, smaservod, sources }, browser);
  const began_ms = Date.now();
  let view;
  try {
    await world.startServo();
    await world.startBridge(...(test.bridge ?? []));
    view = await world.visit();
    await test({ view, world });
    for (const one of world.views) {
      assert.deepEqual(one.errors, []);
    }
    console.log(`ok      ${title}, ${Date.now() - began_ms} ms`);
    return true;
  } catch (error) {
    console.log(`FAILED  ${title}, ${Date.now() - began_ms} ms`);
    console.log(`        ${String(error.stack).split('\n').slice(0, 12).join('\n        ')}`);
    const page = await view
      ?.evaluate(() => ({ notices: window.noticed, text: document.body.innerText.slice(0, 3000) }))
      .catch(() => null);
    console.log(`        page: ${JSON.stringify(page)}`);
    console.log(`        bridge: ${world.bridge?.said.slice(-500)}\n        servo: ${world.servo?.said.slice(-500)}`);
    return false;
  } finally {
    if (view) {
      await shoot(view, title);
    }
    await world.end();
  }
}

/** What this machine lacks for the tests; "" where nothing. */
async function missing() {
  if (!fs.existsSync(programs[name])) {
    return `${programs[name]} is missing`;
  }
  const world = new World({ host_sim, smaservod, sources });
  try {
    await world.startBridge();
    const page = await (await fetch(world.url)).text();
    return page.startsWith('<!') ? '' : 'this host-sim has no page, for it was built without npm';
  } finally {
    await world.end();
  }
}

async function main() {
  const lacks = await missing();
  if (lacks) {
    console.log(`FAILED: ${lacks}`);
    process.exit(1);
  }
  const browser = await launch(name);
  let failed = 0;
  for (const [title, test] of Object.entries(tests)) {
    if (!only.split('|').some((part) => title.includes(part))) {
      continue;
    }
    if (!(await passes(browser, title, test))) {
      ++failed;
    }
  }
  await browser.close();
  process.exit(failed ? 1 : 0);
}

main();
