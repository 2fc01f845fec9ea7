// The step test and the recorder.
'use strict';

const { by, coloured, download, succeeds, text, until } = require('./world.js');
const { connected, move, tab } = require('./person.js');
const assert = require('node:assert/strict');
const { execFileSync } = require('node:child_process');
const fs = require('node:fs');
const path = require('node:path');

/** One run more. */
async function stepped(view, runs, count) {
  await by(view, 'step-run').click();
  await succeeds(view, `${count} runs`, async () => (await runs.count()) === count);
}

module.exports = {
  async 'step tests lie over each other, outlast a reload, and leave as files'({ view, world }) {
    await connected(view);
    await tab(view, 'step');
    await by(view, 'step-amplitude').fill('300');
    await by(view, 'step-seconds').fill('1');
    const runs = view.locator('[data-testid=run]');
    for (const count of [1, 2]) {
      await stepped(view, runs, count);
      await until('a response', async () => (await coloured(view, 'plot-step-position_m')) > 50);
    }
    const cells = await runs.first().locator('td').allTextContents();
    const [rise_ms, hottest_degC] = [cells[3], cells[7]].map(Number);
    assert.ok(rise_ms > 0 && rise_ms < 1000, cells.join('|'));
    assert.ok(hottest_degC > 25 && hottest_degC < 150, cells.join('|'));

    const keys = () => by(view, 'plot-step-position_m').locator('.plot-key').allTextContents();
    assert.deepEqual(
      (await keys()).map((words) => words.match(/run \d|set-point/)?.[0]),
      ['set-point', 'run 2', 'run 1'],
    );
    const both = await coloured(view, 'plot-step-position_m');
    await view.locator('[data-testid=run] .run-key').nth(1).click();
    await until('one run less', async () => (await keys()).length === 2);
    await until('one curve less', async () => (await coloured(view, 'plot-step-position_m')) < both);

    const csv = (await download(view, 'save-csv')).toString();
    assert.match(csv, /^time_s,.*position_m.*\n0,/);
    const [mcap, again] = ['step.mcap', 'step.csv'].map((name) => path.join(world.folder, name));
    fs.writeFileSync(mcap, await download(view, 'save-mcap'));
    execFileSync(world.host_sim, ['convert', mcap, '--out', again]);
    assert.equal(fs.readFileSync(again, 'utf8'), csv);

    await view.reload();
    await until('the runs of before', async () => (await runs.count()) === 2);
    assert.equal((await keys()).length, 2);
    await until('it is off', async () => !(await world.heated()));
  },

  async 'a recording waits for its trigger, and has what was before it'({ view }) {
    await connected(view);
    await move(view, 0);
    await tab(view, 'step');
    await by(view, 'trigger').selectOption('position_m');
    await by(view, 'trigger-value').fill('500');
    await by(view, 'record-before').fill('1');
    await by(view, 'record-seconds').fill('2');
    await by(view, 'record').click();
    await text(view, 'record', /Waiting for the trigger/);
    await move(view, 1000);
    await tab(view, 'step');
    await succeeds(view, 'a recording', () => by(view, 'recorded').isVisible());
    await until('the recording', async () => (await coloured(view, 'plot-record-µm')) > 50);
    const lines = (await download(view, 'save-csv'))
      .toString()
      .trim()
      .split('\n')
      .filter((line) => !line.startsWith('#'));
    const [head, ...rows] = lines.map((line) => line.split(','));
    const column = (name) => rows.map((row) => Number(row[head.indexOf(name)]));
    const [time_s, position_m] = [column('time_s'), column('position_m')];
    const first = position_m.findIndex((position) => position > 0.0005);
    assert.ok(first > 0, head.join());
    assert.ok(Math.abs(time_s[first] - time_s[0] - 1) < 0.05, `${time_s[first] - time_s[0]} s before the trigger`);
  },
};
