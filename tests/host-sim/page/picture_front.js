// picture_front.js HOST_SIM SMASERVOD SOURCES PICTURE.png [light|dark]: the picture of the live page that the README
// shows: a simulated servo that moves in nested loops. How it is run: browser_test.js.
'use strict';

const {bridge, by, launch, scratch, servo, text, until, visit} = require('./browser.js');
const fs = require('node:fs');

const [host_sim, smaservod, sources, picture, scheme = 'light'] = process.argv.slice(2);
const signals = 'strain,setpoint,reference,current_A,power_W,wanted_power_W,resistance_ohm,temperature_K';
const between_ms = 1800;
const targets_um = [100, 2400, 100, 2400, 400, 2200, 700, 2000, 1000, 2400, 100, 2400, 400, 2000, 700];

/** All moves; false where a busy machine kept the servo from running for so long that it switched itself off. */
async function moved(view) {
  if (await by(view, 'reset-faults').count() > 0) await by(view, 'reset-faults').click();
  if (await by(view, 'enable').count() > 0) await by(view, 'enable').click();
  await text(view, 'drive', /Enabled/);
  await by(view, 'mode').selectOption('1');
  try {
    for (const target_um of targets_um) {
      await by(view, 'target').fill(String(target_um), {timeout: between_ms});
      await by(view, 'go').click({timeout: between_ms});
      await view.waitForTimeout(between_ms);
    }
  } catch {
    return false;
  }
  return await by(view, 'enable').count() === 0;
}

async function main() {
  const folder = scratch();
  const one = servo(smaservod, sources, folder);
  // By SYNC, with all that is in sight: a signal that comes by polling beside them is drawn some 0.3 s late.
  const shows = await bridge(host_sim, '--sync', '0.01', '--signals', signals);
  const browser = await launch('chromium');
  const view = await visit(browser, shows.url, {width: 1280, height: 842});
  await view.emulateMedia({colorScheme: scheme});
  await until(() => by(view, 'enable').isEnabled(), 'a servo that may be enabled', view);
  await until(() => moved(view), 'a servo that moves to all targets', view);
  await view.screenshot({path: picture});
  console.log(`${picture}: ${(fs.statSync(picture).size / 1000).toFixed(0)} kB`);
  await browser.close();
  await shows.stop();
  await one.stop();
  fs.rmSync(folder, {recursive: true});
  process.exit(0);
}

main();
