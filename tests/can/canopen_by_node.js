// canopen_by_node.js INTERFACE NODE EDS: npm's canopen talks to the servo. Exits with 1 when
// something is not as it should be.
'use strict';

const assert = require('node:assert');
const { setTimeout: sleep } = require('node:timers/promises');
const { DataType, Device, Eds, LssMode, NmtState } = require('canopen');
const socketcan = require('socketcan');

const [interfaceName, nodeText, edsFile] = process.argv.slice(2);
const node = Number(nodeText);
// The library's own 30 ms are for a machine with a clock. Only what hangs takes so long: tests/patience.hpp.
const timeout = 600_000;

async function until(what, condition) {
  const end = Date.now() + timeout;
  while (!(await condition())) {
    assert(Date.now() < end, `in vain: ${what}`);
    await sleep(20);
  }
}

/** A check with its name. */
async function check(name, run) {
  await run();
  console.log(`ok  ${name}`);
}

function setUp() {
  const eds = Eds.fromFile(edsFile);
  const device = new Device({ id: 0x7a, enableLss: true });
  device.eds.addSdoClientParameter(node, 0x600 + node, 0x580 + node);
  device.eds.addHeartbeatConsumer(node, 2000);
  device.eds.addEmcyConsumer(0x80 + node);
  const channel = socketcan.createRawChannel(interfaceName);
  const frames = [];
  device.addListener('message', (m) => channel.send(m));
  channel.addListener('onMessage', (m) => {
    frames.push({ id: m.id, data: Buffer.from(m.data) });
    device.receive(m);
  });
  channel.start();
  device.start();
  device.nmt.startNode(0x7a);
  return { device, channel, frames, eds };
}

async function main() {
  const { device, channel, frames, eds } = setUp();
  const read = (index, subIndex, dataType, more = {}) =>
    device.sdo.upload({ deviceId: node, index, subIndex, dataType, timeout, ...more });
  const write = (index, subIndex, data, dataType, more = {}) =>
    device.sdo.download({ deviceId: node, index, subIndex, data, dataType, timeout, ...more });
  // The library waits for ever when a segment of a block is lost, since it does not ask for it again. What
  // comes while node stands still has to fit into the guest's receive queue: 16 segments do.
  device.sdo.setBlockSize(16);
  const seen = (id) => frames.filter((f) => f.id === id);

  await check('EDS: read by the library', async () => {
    assert.equal(eds.getEntry(0x1000).value & 0xffff, 402);
    assert.equal(eds.getSubEntry(0x2100, 1).dataType, DataType.REAL32);
  });

  await check('NMT: reset, boot-up, start, heartbeat', async () => {
    frames.length = 0;
    device.nmt.resetNode(node);
    await until('boot-up', () => seen(0x700 + node).some((f) => f.data[0] === 0));
    await write(0x1017, 0, 100, DataType.UNSIGNED16);
    device.nmt.startNode(node);
    await until('operational', () => seen(0x700 + node).some((f) => f.data[0] === NmtState.OPERATIONAL));
    assert.equal(await device.nmt.getNodeState(node, timeout), NmtState.OPERATIONAL);
  });

  await check('SDO: expedited, segmented and block uploads', async () => {
    assert.equal((await read(0x1000, 0, DataType.UNSIGNED32)) & 0xffff, 402);
    const name = await read(0x1008, 0, DataType.VISIBLE_STRING);
    assert.equal(name.replace(/\0+$/, ''), 'smaservo');
    const sheet = await read(0x1021, 0, undefined, { blockTransfer: true });
    assert(sheet.toString().includes('[FileInfo]'), 'the EDS comes out of the node');
  });

  await check('SDO: expedited and block downloads, aborts', async () => {
    for (const [value, more] of [
      [6.5, {}],
      [7.25, { blockTransfer: true }],
    ]) {
      await write(0x2100, 1, value, DataType.REAL32, more);
      assert.equal(await read(0x2100, 1, DataType.REAL32), value);
    }
    await assert.rejects(write(0x2020, 2, NaN, DataType.REAL32), /06090030|6090030|value/i);
    await assert.rejects(read(0x1fff, 0, DataType.UNSIGNED8));
  });

  await check('PDO: TPDO 1 by time, TPDO 2 by SYNC, RPDO 2', async () => {
    frames.length = 0;
    await until('TPDO 1', () => seen(0x180 + node).length > 1);
    channel.send({ id: 0x80, data: Buffer.alloc(0) });
    await until('TPDO 2', () => seen(0x280 + node).length > 0);
    const target = Buffer.alloc(8);
    target.writeInt32LE(-321);
    channel.send({ id: 0x300 + node, data: target });
    await until('target', async () => (await read(0x607a, 0, DataType.INTEGER32)) === -321);
  });

  await check('EMCY: an RPDO that is too short', async () => {
    const codes = [];
    device.emcy.addListener('emergency', ({ em }) => codes.push(em.code));
    channel.send({ id: 0x300 + node, data: Buffer.alloc(2) });
    await until('EMCY 8210h', () => codes.includes(0x8210));
  });

  await check('CiA 402: enabled, a move in Profile position, disabled', async () => {
    const control = (word) => write(0x6040, 0, word, DataType.UNSIGNED16);
    const status = () => read(0x6041, 0, DataType.UNSIGNED16);
    for (const [word, state] of [
      [0x06, 0x21],
      [0x07, 0x23],
      [0x0f, 0x27],
    ]) {
      await control(word);
      await until(`state ${state}`, async () => ((await status()) & 0x6f) === state);
    }
    await write(0x6060, 0, 1, DataType.INTEGER8);
    await until('mode', async () => (await read(0x6061, 0, DataType.INTEGER8)) === 1);
    await write(0x607a, 0, 800, DataType.INTEGER32);
    await control(0x3f);
    await until('acknowledged', async () => (await status()) & 0x1000);
    await control(0x0f);
    await until('reached', async () => (await status()) & 0x400);
    const position = await read(0x6064, 0, DataType.INTEGER32);
    assert(Math.abs(position - 800) < 150, `at ${position} um`);
    await control(0);
    await until('disabled', async () => ((await status()) & 0x4f) === 0x40);
  });

  await check('LSS: selected by its identity, asked, left', async () => {
    const identity = [];
    for (const sub of [1, 2, 3, 4]) {
      identity.push(await read(0x1018, sub, DataType.UNSIGNED32));
    }
    device.nmt.stopNode(node);
    const [vendorId, productCode, revisionNumber, serialNumber] = identity;
    const identified = { vendorId, productCode, revisionNumber, serialNumber };
    await device.lss.switchModeSelective({ ...identified, timeout });
    assert.equal(await device.lss.inquireSerialNumber(timeout), serialNumber);
    device.lss.switchModeGlobal(LssMode.OPERATION);
    device.nmt.startNode(node);
  });

  device.stop();
  channel.stop();
}

main().then(
  () => process.exit(0),
  (error) => {
    console.error(error);
    process.exit(1);
  },
);
