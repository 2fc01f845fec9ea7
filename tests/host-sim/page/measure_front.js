// measure_front.js PAGE [SECONDS [WINDOW_S]]: what the page costs in headless Chromium while 8 signals come
// 1000 times a second. Ten minutes of history are full from the start, and WINDOW_S of them are shown. All of
// the browser runs on one core, the bridge on the others. Processor time is the figure: frames per second depend
// on what else the machine does. NODE_PATH as for bridge_test.js.
// MEASURE_PROFILE=FILE writes a CPU profile of 10 s, which Chromium's developer tools open.
'use strict';

const { chromium } = require('playwright-core');
const { execFileSync } = require('node:child_process');
const fs = require('node:fs');
const os = require('node:os');
const { serve } = require('./synthetic_bridge.js');

const [page, seconds = '60', window_s = '600'] = process.argv.slice(2);
const history_s = 600;
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

async function counters(tab, machine, view) {
  const { metrics } = await tab.send('Performance.getMetrics');
  const of = (name) => metrics.find((metric) => metric.name === name).value;
  const { processInfo } = await machine.send('SystemInfo.getProcessInfo');
  const used = (type) =>
    processInfo.filter((one) => one.type.toLowerCase() === type).reduce((sum, one) => sum + one.cpuTime, 0);
  return {
    time_s: of('Timestamp'),
    main_s: of('ThreadTime'),
    script_s: of('ScriptDuration'),
    renderer_s: used('renderer'),
    gpu_s: used('gpu'),
    frames: await view.evaluate('frameCount'),
    samples: Number(await view.getAttribute('[data-testid=rate]', 'data-received')),
  };
}

/** MB that are in use after a collection: JavaScript's heap, and with it what typed arrays take. */
async function heap(tab) {
  for (let k = 0; k < 3; ++k) {
    await tab.send('HeapProfiler.collectGarbage');
  }
  const { usedSize, backingStorageSize } = await tab.send('Runtime.getHeapUsage');
  return [usedSize / 1e6, (backingStorageSize ?? 0) / 1e6];
}

/** What Chromium's threads do in 5 s, for its developer tools or Perfetto. */
async function trace(machine, file) {
  const events = [];
  machine.on('Tracing.dataCollected', ({ value }) => events.push(...value));
  const complete = new Promise((done) => machine.once('Tracing.tracingComplete', done));
  await machine.send('Tracing.start', {
    traceConfig: {
      includedCategories: [
        'devtools.timeline',
        'disabled-by-default-devtools.timeline',
        'toplevel',
        'cc',
        'viz',
        'blink',
        'v8',
        'gpu',
      ],
    },
  });
  await pause(5000);
  await machine.send('Tracing.end');
  await complete;
  fs.writeFileSync(file, JSON.stringify({ traceEvents: events }));
}

async function profile(tab, file) {
  await tab.send('Profiler.enable');
  await tab.send('Profiler.setSamplingInterval', { interval: 500 });
  await tab.send('Profiler.start');
  await pause(10_000);
  fs.writeFileSync(file, JSON.stringify((await tab.send('Profiler.stop')).profile));
}

/** The browser with all its processes on the last core, this process on the others. */
async function launchOnOneCore() {
  const last = os.cpus().length - 1;
  const stay = (cores) => execFileSync('taskset', ['-acp', cores, String(process.pid)]);
  stay(String(last));
  const browser = await chromium.launch({ executablePath: '/usr/bin/chromium', args: ['--no-sandbox'] });
  if (last > 0) {
    stay(`0-${last - 1}`);
  }
  return browser;
}

/** What has waited while the history was read is no part of the rate. */
async function settled(view) {
  const received = async () => Number(await view.getAttribute('[data-testid=rate]', 'data-received'));
  const until_ms = Date.now() + 120_000;
  for (let [rate, before, at_ms] = [Infinity, await received(), Date.now()]; rate > 1050 && Date.now() < until_ms; ) {
    await pause(2000);
    const [now, now_ms] = [await received(), Date.now()];
    rate = (1000 * (now - before)) / (now_ms - at_ms);
    [before, at_ms] = [now, now_ms];
  }
}

async function main() {
  const address = await serve(page, history_s);
  const browser = await launchOnOneCore();
  const view = await browser.newPage({ viewport: { width: 1280, height: 900 } });
  view.on('pageerror', (error) => console.log(`error in the page: ${error.message}`));
  await view.addInitScript((seconds) => {
    // A picture is what the strain's canvas was cleared for.
    globalThis.frameCount = 0;
    const clear = CanvasRenderingContext2D.prototype.clearRect;
    CanvasRenderingContext2D.prototype.clearRect = function (...box) {
      if (this.canvas.closest('[data-testid=plot-strain]')) {
        ++globalThis.frameCount;
      }
      clear.apply(this, box);
    };
    localStorage.setItem('smaservo.span_s', JSON.stringify(seconds));
  }, Number(window_s));
  await view.goto(address + (process.env.MEASURE_VIEW ?? ''));
  await view.waitForFunction('Number(document.querySelector("[data-testid=rate]")?.dataset.received) > 2000', null, {
    timeout: 120_000,
  });
  await settled(view);
  const tab = await view.context().newCDPSession(view);
  const machine = await browser.newBrowserCDPSession();
  await tab.send('Performance.enable', { timeDomain: 'timeTicks' });
  if (process.env.MEASURE_PROFILE) {
    await profile(tab, process.env.MEASURE_PROFILE);
  }
  if (process.env.MEASURE_TRACE) {
    await trace(machine, process.env.MEASURE_TRACE);
  }
  if (process.env.MEASURE_SHOT) {
    await view.screenshot({ path: process.env.MEASURE_SHOT, fullPage: true });
  }
  const heapBefore = await heap(tab);
  const before = await counters(tab, machine, view);
  await pause(1000 * Number(seconds));
  const after = await counters(tab, machine, view);
  const heapAfter = await heap(tab);
  const spent = Object.fromEntries(Object.keys(after).map((key) => [key, after[key] - before[key]]));
  const ms = (value) => ((1000 * value) / spent.frames).toFixed(1);
  const share = (value) => `${((100 * value) / spent.time_s).toFixed(0)} %`;
  const row = (...cells) => console.log(`| ${cells.join(' | ')} |`);
  row('8 signals of 1 kHz', `${spent.time_s.toFixed(0)} s, ${window_s} s of ${history_s} s shown`);
  console.log('|---|--:|');
  row('samples/s', (spent.samples / spent.time_s).toFixed(0));
  row('frames/s', (spent.frames / spent.time_s).toFixed(1));
  row('processor time of the page per frame', `${ms(spent.renderer_s)} ms`);
  row('- of that, script', `${ms(spent.script_s)} ms`);
  row('processor time of what paints it per frame', `${ms(spent.gpu_s)} ms`);
  row('the page of a core', share(spent.renderer_s));
  row('what paints it of a core', share(spent.gpu_s));
  row('heap after a collection, before and after', `${heapBefore[0].toFixed(2)}, ${heapAfter[0].toFixed(2)} MB`);
  row('arrays beside it, before and after', `${heapBefore[1].toFixed(1)}, ${heapAfter[1].toFixed(1)} MB`);
  await browser.close();
  process.exit(0);
}

main();
