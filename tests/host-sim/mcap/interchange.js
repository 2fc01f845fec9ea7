// interchange.js BUILD SOURCE PACKAGES: what each command writes is read by npm's MCAP library, and
// what that writes is read by the commands. Runs in a network of its own (tests/can/own_network.sh);
// says SKIPPED with status 77 where the packages are not there.
'use strict';
const assert = require('node:assert/strict');
const { spawn, spawnSync } = require('node:child_process');
const fs = require('node:fs');
const os = require('node:os');
const path = require('node:path');

const [build, source, packages] = process.argv.slice(2);
if (!fs.existsSync(path.join(packages, 'node_modules/@mcap/core'))) {
  console.log(`SKIPPED: ${packages} has no @mcap/core; \`toolchain/dev test release\` installs it`);
  process.exit(77);
}
process.env.SMASERVO_MCAP_PACKAGES = packages;
const oracle = require('./oracle.js');

const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'smaservo-mcap-'));
const at = (name) => path.join(folder, name);
const text = (name) => fs.readFileSync(at(name), 'utf8');
const program = path.join(build, 'host-sim/host-sim');
const daemon = path.join(build, 'firmware/daemon/smaservod');

/** Only what hangs takes so long: tests/patience.hpp. */
const patience_ms = 600_000;

async function until(what, condition) {
  const end = Date.now() + patience_ms;
  while (!condition()) {
    assert.ok(Date.now() < end, `in vain: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

function run(command, args, status = 0) {
  const done = spawnSync(command, args, { cwd: folder, encoding: 'utf8', timeout: patience_ms });
  assert.equal(done.status, status, `${command} ${args.join(' ')}\n${done.stdout}${done.stderr}`);
  return done.stdout + done.stderr;
}
const host = (...args) => run(program, args);
const refused = (...args) => run(program, args, 1);

/** The same trace as CSV, and as MCAP that has come back to the same bytes. */
async function bothWays(name, options) {
  host('convert', `${name}.mcap`, '--out', `${name}.again.csv`);
  assert.equal(text(`${name}.again.csv`), text(`${name}.csv`), `${name}: there and back`);
  return oracle.check(at(`${name}.mcap`), text(`${name}.csv`), options);
}

const tests = {
  async simulate() {
    const scenario = path.join(source, 'host-sim/scenarios/sensor-faults.toml');
    host('simulate', scenario, '--out', 'loop.csv');
    host('simulate', scenario, '--out', 'loop.mcap');
    const { metadata, properties } = await bothWays('loop');
    assert.equal(metadata.program, 'host-sim simulate');
    assert.match(metadata.version, /^\d+\.\d+\.\d+$/);
    assert.equal(properties.state.type, 'string');
    assert.equal(properties.latched_faults.type, 'string');
    assert.equal(properties.strain.type, 'number');
    const bath = path.join(source, 'host-sim/traces/bath.toml');
    host('simulate', bath, '--out', 'bath.csv');
    host('simulate', bath, '--out', 'bath.mcap');
    await bothWays('bath', { timeless: true });
  },

  async replay() {
    const trace = path.join(source, 'host-sim/traces/150MPa.csv');
    host('replay', trace, '--out', 'estimate.csv');
    host('replay', trace, '--out', 'estimate.mcap');
    await bothWays('estimate');
    host('convert', trace, '--out', 'trace.mcap');
    fs.copyFileSync(trace, at('trace.csv'));
    const { metadata } = await bothWays('trace');
    assert.equal(metadata.source, trace);
    // The estimate of the MCAP file is that of the CSV file.
    host('replay', 'trace.mcap', '--out', 'of-mcap.csv');
    assert.equal(text('of-mcap.csv'), text('estimate.csv'));
    const device = path.join(source, 'host-sim/scenarios/devices/sublayers-1000.toml');
    host('simulate', path.join(source, 'host-sim/scenarios/steps.toml'), '--out', 'steps.mcap');
    assert.match(
      host('replay-device', device, 'steps.mcap', '--out', 'again.mcap'),
      /all 21 outputs are the same to the last bit/,
    );
    host('replay-device', device, 'again.mcap', '--out', 'again.csv');
    await bothWays('again');
  },

  async othersFiles() {
    const trace = path.join(source, 'host-sim/traces/units');
    const csv = fs.readFileSync(path.join(source, 'host-sim/traces/150MPa.csv'), 'utf8');
    assert.ok(fs.existsSync(trace));
    const { names, rows } = oracle.table(csv);
    // npm's library has numbers, no texts: 0.050 becomes 0.05.
    const numbers = [names, ...rows.map((row) => row.map((field) => `${Number(field)}`))]
      .map((row) => `${row.join(',')}\n`)
      .join('');
    host('replay', path.join(source, 'host-sim/traces/150MPa.csv'), '--out', 'wanted.csv');
    for (const [name, options] of Object.entries({
      plain: {},
      chunked: { chunked: true },
      zstd: { chunked: true, compression: 'zstd' },
      lz4: { chunked: true, compression: 'lz4' },
      schemaless: { schemaless: true, topic: '/a' },
      beside: { chunked: true, other: 'json' },
      binary: { topic: '/servo', other: 'cdr' },
    })) {
      await oracle.write(at(`${name}.mcap`), csv, options);
      host('convert', `${name}.mcap`, '--out', `${name}.csv`, ...(name === 'beside' ? ['--topic', '/trace'] : []));
      assert.equal(text(`${name}.csv`), numbers, name);
      if (name !== 'beside') {
        host('replay', `${name}.mcap`, '--out', `${name}-estimate.csv`);
        assert.equal(text(`${name}-estimate.csv`), text('wanted.csv'), name);
      }
    }
    await oracle.write(at('two.mcap'), csv, { topic: '/a', other: 'json' });
    assert.match(refused('convert', 'two.mcap', '--out', 'x.csv'), /is of \/other, those before of \/a/);
    assert.match(
      refused('convert', 'plain.mcap', '--topic', '/b', '--out', 'x.csv'),
      /no channel \/b with message encoding json; channels: \/trace \(json\)/,
    );
  },

  async texts() {
    // Numbers of 17 digits, signs of zero, what is no number, names and texts of any script.
    const csv =
      'time_s,current_A,größe "x",note,later,never\n' +
      '-0.5,0.1234567890123456789,-0,"a\\b",,\n' +
      '0.25,1e-300,5e-324,Ω é 😀 \t,,\n' +
      '1,-0.0,1.7976931348623157e308,inf,3,\n';
    fs.writeFileSync(at('texts.csv'), csv);
    host('convert', 'texts.csv', '--out', 'texts.mcap');
    const { properties } = await bothWays('texts', { timeless: true });
    assert.deepEqual(
      Object.values(properties).map((property) => property.type),
      ['number', 'number', 'number', 'string', 'number', 'string'],
    );
    host('convert', '--uncompressed', 'texts.csv', '--out', 'plain-texts.mcap');
    fs.copyFileSync(at('texts.csv'), at('plain-texts.csv'));
    await bothWays('plain-texts', { timeless: true });
  },

  async bus() {
    const started = spawn(daemon, ['--board', 'sim', '--bus', 'udp', '--no-real-time', '--record', 'bus.mcap'], {
      cwd: folder,
      stdio: 'ignore',
    });
    const ended = new Promise((resolve) => started.on('exit', resolve));
    const bus = (...args) => host('can', '--can', 'udp', '--node', '1', ...args);
    try {
      await until('a servo', () => bus('scan').includes('smaservo'));
      bus('enable');
      bus('move', '500');
      bus('record', '--signals', 'current_A,voltage_V,stress_Pa,strain', '--seconds', '2', '--out', 'recorder.mcap');
      bus('disable');
    } finally {
      started.kill('SIGTERM');
    }
    assert.equal(await ended, 0);
    host('convert', 'recorder.mcap', '--out', 'recorder.csv');
    const { rows, metadata } = await bothWays('recorder');
    assert.ok(rows >= 1900, `${rows} rows`);
    assert.equal(metadata.program, 'host-sim can record');
    assert.match(host('replay', 'recorder.mcap'), new RegExp(`${rows} rows`));
    host('convert', 'bus.mcap', '--out', 'bus.csv');
    const recording = await bothWays('bus');
    assert.equal(recording.metadata.program, 'smaservod --record');
    assert.equal(recording.properties.parameter_changes.type, 'string');
    assert.match(host('replay-device', 'bus.mcap.toml', 'bus.mcap'), /same to the last bit/);
  },

  async killed() {
    const started = spawn(daemon, ['--board', 'sim', '--bus', 'udp', '--no-real-time', '--record', 'killed.mcap'], {
      cwd: folder,
      stdio: 'ignore',
    });
    const ended = new Promise((resolve) => started.on('exit', resolve));
    // What is in the file while it is being written.
    const rows_so_far = () => {
      spawnSync(program, ['convert', 'killed.mcap', '--out', 'so-far.csv'], { cwd: folder });
      return fs.existsSync(at('so-far.csv')) ? text('so-far.csv').split('\n').length - 2 : 0;
    };
    await until('1000 rows', () => rows_so_far() >= 1000);
    started.kill('SIGKILL');
    await ended;
    assert.match(host('replay-device', 'killed.mcap.toml', 'killed.mcap'), /without a footer/);
    assert.match(host('convert', 'killed.mcap', '--out', 'repaired.mcap'), /without a footer/);
    host('convert', 'killed.mcap', '--out', 'repaired.csv');
    const { rows } = await bothWays('repaired');
    assert.ok(rows >= 1000, `${rows} rows`);
  },
};

(async () => {
  await oracle.ready;
  for (const [name, test] of Object.entries(tests)) {
    await test();
    console.log(`${name}: passed`);
  }
  fs.rmSync(folder, { recursive: true });
})().catch((error) => {
  console.error(error);
  console.error(`The files are in ${folder}`);
  process.exit(1);
});
