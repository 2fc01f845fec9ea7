// picture.js HOST_SIM SMASERVOD SOURCES PICTURE.png [light|dark]: the picture of the live page that the README shows: a
// simulated servo that moves in nested loops. Run as main.js, by `toolchain/dev figures page`.
'use strict';

const { World, by, launch, until } = require('./world.js');
const { enable } = require('./person.js');
const fs = require('node:fs');

const [host_sim, smaservod, sources, picture, colorScheme = 'light'] = process.argv.slice(2);
const signals = 'strain,setpoint,reference,drive_current_A,power_W,wanted_power_W,resistance_ohm,wire_temperature_K';
const between_ms = 1800;
// Narrow enough that its texts can be read at the width of a README, and so high that no card is cut.
const page_px = { width: 1120, height: 932 };
const plots = 4; // those that have room beside the cards
const finer = 1.5;
const targets_um = [100, 2400, 100, 2400, 400, 2200, 700, 2000, 1000, 2400, 100, 2400, 400, 2000, 700];

/** Only the first plots, as many as have room. */
async function arrange(view) {
  const button = view.getByRole('button', { name: 'Arrange plots' });
  await button.click();
  const shown = view.locator('[data-testid^=show-][aria-pressed=true]');
  for (let more = await shown.count(); more > plots; --more) {
    await shown.nth(plots).click();
  }
  await button.click();
}

/** All moves; false where the servo has switched itself off meanwhile. */
async function moved(view) {
  await enable(view);
  await by(view, 'mode').selectOption('1');
  try {
    for (const target_um of targets_um) {
      await by(view, 'target').fill(String(target_um), { timeout: between_ms });
      await by(view, 'go').click({ timeout: between_ms });
      await view.waitForTimeout(between_ms);
    }
  } catch {
    return false;
  }
  return (await by(view, 'enable').count()) === 0;
}

async function main() {
  const world = new World({ host_sim, smaservod, sources }, await launch('chromium'));
  await world.startServo();
  // By SYNC, with all that is in sight: a signal that comes by polling beside them is drawn some 0.3 s late.
  await world.startBridge('--sync', '0.01', '--signals', signals);
  const view = await world.visit({ viewport: page_px, deviceScaleFactor: finer, colorScheme });
  await arrange(view);
  await until('a servo that moves to all targets', () => moved(view));
  await view.screenshot({ path: picture });
  console.log(`${picture}: ${(fs.statSync(picture).size / 1000).toFixed(0)} kB`);
  const missing = /\d+ samples missing/.exec(await view.locator('main').textContent());
  if (missing) {
    console.log(`${missing[0]}, as the picture says: the machine has much else to do`);
  }
  await world.end();
  await world.browser.close();
}

main();
