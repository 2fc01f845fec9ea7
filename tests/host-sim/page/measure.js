// measure.js TEST_BRIDGE [SECONDS]: what the bridge costs while a servo sends 8 signals 1000 times a
// second to one and to three clients: share of a core, memory, gaps. NODE_PATH as for bridge_test.js.
'use strict';

const { Bridge, Client } = require('./bridge.js');
const { execFileSync } = require('node:child_process');
const fs = require('node:fs');

const [program, seconds = '20'] = process.argv.slice(2);
const ticks = Number(execFileSync('getconf', ['CLK_TCK']));

// Processor time of a process in s, its own and the system's for it.
function processorTime(pid) {
  const fields = fs.readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ');
  return (Number(fields[11]) + Number(fields[12])) / ticks;
}

const memory_MB = (pid) => Number(/VmHWM:\s+(\d+)/.exec(fs.readFileSync(`/proc/${pid}/status`, 'utf8'))[1]) / 1024;

async function measure(count) {
  const bridge = await Bridge.start(program);
  let messages = 0,
    gaps = 0;
  for (let i = 0; i < count; ++i) {
    const client = await Client.connect(bridge);
    let last;
    client.subscribe('/node1/live', ({ number }) => {
      ++messages;
      if (last !== undefined) {
        gaps += number - last - 1;
      }
      last = number;
    });
  }
  await new Promise((done) => setTimeout(done, 1000));
  const [began, before, start] = [process.hrtime.bigint(), messages, processorTime(bridge.pid)];
  await new Promise((done) => setTimeout(done, 1000 * Number(seconds)));
  const elapsed_s = Number(process.hrtime.bigint() - began) * 1e-9;
  const used_s = processorTime(bridge.pid) - start;
  console.log(
    `| ${count} | ${((100 * used_s) / elapsed_s).toFixed(1)} % | ` +
      `${memory_MB(bridge.pid).toFixed(1)} MB | ${((messages - before) / elapsed_s / count).toFixed(0)} | ${gaps} |`,
  );
  await bridge.stop();
}

async function main() {
  console.log('| clients | of a core | memory, at most | messages/s and client | missing |\n|--:|--:|--:|--:|--:|');
  for (const count of [1, 3]) {
    await measure(count);
  }
  process.exit(0);
}

main();
