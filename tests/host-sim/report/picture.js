// picture.js REPORT.html PICTURE.png: the first plot of a report as a person sees it on a bright screen, as the README
// shows it. NODE_PATH names the folder of the npm packages.
'use strict';

const { chromium } = require('playwright-core');
const fs = require('node:fs');
const path = require('node:path');
const { pathToFileURL } = require('node:url');

const [report, picture] = process.argv.slice(2);
// As wide as a README is on GitHub, at twice as many pixels.
const page_px = { width: 912, height: 700 };
const finer = 2;

async function main() {
  const browser = await chromium.launch({
    executablePath: '/usr/bin/chromium',
    args: ['--no-sandbox', '--disable-gpu'],
  });
  const view = await browser.newPage({ viewport: page_px, deviceScaleFactor: finer, colorScheme: 'light' });
  await view.goto(pathToFileURL(path.resolve(report)).href);
  const plot = view.locator('.interactive').first();
  await plot.locator('.plot[data-drawn]').waitFor();
  await plot.screenshot({ path: picture });
  console.log(`${picture}: ${(fs.statSync(picture).size / 1000).toFixed(0)} kB`);
  await browser.close();
}

main();
