// What the tests of the socket half share.
'use strict';

const assert = require('node:assert/strict');

// How many messages are missing between the first and the last of these numbers.
function missing(numbers) {
  return numbers.at(-1) - numbers[0] + 1 - numbers.length;
}

// A client that the machine keeps from running may lose messages, but each is counted, and their
// order stays.
async function assertNoneUncounted(client, numbers) {
  assert.ok(numbers.every((number, i) => i === 0 || number > numbers[i - 1]));
  const own = (state) => state.clients.find((one) => one.client === Number(client.info.metadata.client));
  const state = await client.until('/bridge', own);
  assert.ok(
    missing(numbers) <= own(state).dropped,
    `${missing(numbers)} of ${numbers.length} are missing, ${own(state).dropped} are counted`,
  );
}

// That many messages of the servo, one after the other.
function collect(client, count) {
  return new Promise((done) => {
    const numbers = [];
    const id = client.subscribe('/node1/live', (value) => {
      numbers.push(value.number);
      if (numbers.length !== count) {
        return;
      }
      client.fox.unsubscribe(id);
      done(numbers);
    });
  });
}

// Runs tests, those whose name has `only`; how many have failed.
async function main(tests, only, longest_ms = 60000) {
  let failed = 0;
  for (const [name, test] of Object.entries(tests)) {
    if (only && !name.includes(only)) {
      continue;
    }
    const began = Date.now();
    try {
      const late = new Promise((_done, failed) => {
        setTimeout(() => failed(new Error('does not end')), longest_ms).unref();
      });
      await Promise.race([test(), late]);
      console.log(`ok      ${name}, ${Date.now() - began} ms`);
    } catch (error) {
      ++failed;
      console.log(`FAILED  ${name}, ${Date.now() - began} ms\n${error.stack}`);
    }
  }
  return failed;
}

module.exports = { assertNoneUncounted, collect, main, missing };
