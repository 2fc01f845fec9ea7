// What npm's MCAP library, which shares nothing with ours, finds in a file, beside the CSV text that
// should be in it; and files that it writes.
'use strict';
const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');
const { createRequire } = require('node:module');

const library = createRequire(path.join(process.env.SMASERVO_MCAP_PACKAGES, 'package.json'));
const { McapIndexedReader, McapStreamReader, McapWriter } = library('@mcap/core');
const { crc32 } = library('@foxglove/crc');
const zstd = library('@foxglove/wasm-zstd');
const lz4 = library('lz4js');

const decompressHandlers = {
  zstd: (bytes, size) => new Uint8Array(zstd.decompress(bytes, Number(size))),
};
exports.ready = zstd.isLoaded;

/** Header and rows of CSV text. */
function table(csv) {
  const lines = csv.split('\n');
  assert.equal(lines.pop(), '', 'the last line has an end');
  return { names: lines[0].split(','), rows: lines.slice(1).map((line) => line.split(',')) };
}
exports.table = table;

/** All records of a file, in order; the reader checks the checksums of chunks. */
function records(bytes) {
  const reader = new McapStreamReader({ decompressHandlers, includeChunks: true });
  reader.append(bytes);
  const all = [];
  for (let record; (record = reader.nextRecord()); ) {
    all.push(record);
  }
  return { all, done: reader.done() };
}

/** The bytes before the record that ends the data, whose checksum it has. */
function dataSection(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let at = 8;
  while (bytes[at] !== 0x0f) {
    at += 9 + Number(view.getBigUint64(at + 1, true));
  }
  return bytes.subarray(0, at);
}

/** What a field of CSV is as a member of the object: nothing where it is empty. */
function member(type, field) {
  const number = Number(field);
  return type === 'number' && field !== '' && Number.isFinite(number) ? number : field;
}

/** Checks a file against the CSV text of the same trace. Returns what its metadata say. */
exports.check = async function check(file, csv, { timeless = false } = {}) {
  const bytes = fs.readFileSync(file);
  const { names, rows } = table(csv);
  const reader = await McapIndexedReader.Initialize({
    readable: {
      size: async () => BigInt(bytes.length),
      read: async (offset, size) => bytes.subarray(Number(offset), Number(offset + size)),
    },
    decompressHandlers,
  });
  const { all, done } = records(bytes);
  assert.ok(done, 'the file has its end');
  assert.deepEqual(
    all.filter((r) => r.type === 'DataEnd').map((r) => r.dataSectionCrc),
    [crc32(dataSection(bytes))],
    'the checksum of the data',
  );

  assert.equal(reader.channelsById.size, 1);
  const [channel] = reader.channelsById.values();
  assert.equal(channel.topic, '/trace');
  assert.equal(channel.messageEncoding, 'json');
  const schema = reader.schemasById.get(channel.schemaId);
  assert.equal(schema.encoding, 'jsonschema');
  const { type, properties } = JSON.parse(new TextDecoder().decode(schema.data));
  assert.equal(type, 'object');
  assert.deepEqual(Object.keys(properties), names, 'columns in their order');
  for (const property of Object.values(properties)) {
    // What Foxglove takes.
    assert.ok(property.type === 'number' || property.type === 'string', property.type);
  }

  const statistics = reader.statistics;
  assert.equal(Number(statistics.messageCount), rows.length);
  assert.equal(statistics.channelCount, 1);
  assert.equal(statistics.schemaCount, 1);
  assert.equal(statistics.chunkCount, reader.chunkIndexes.length);
  assert.equal(statistics.chunkCount, all.filter((r) => r.type === 'Chunk').length);
  assert.equal(Number(statistics.channelMessageCounts.get(channel.id) ?? 0n), rows.length);

  // By the index, as Foxglove reads.
  let count = 0;
  for await (const message of reader.readMessages()) {
    const object = JSON.parse(new TextDecoder('utf-8', { fatal: true }).decode(message.data));
    const row = rows[count];
    const wanted = {};
    names.forEach((name, i) => {
      if (row[i] !== '') {
        wanted[name] = member(properties[name].type, row[i]);
      }
    });
    assert.deepEqual(object, wanted, `row ${count}`);
    for (const [name, value] of Object.entries(object)) {
      assert.equal(typeof value, properties[name].type, `${name} in row ${count}`);
      if (Object.is(value, 0)) {
        assert.ok(!row[names.indexOf(name)].startsWith('-'), 'sign of zero');
      }
    }
    assert.equal(message.sequence, count);
    assert.equal(message.logTime, message.publishTime);
    if (!timeless) {
      assert.ok(Math.abs(Number(message.logTime) - 1e9 * Number(object.time_s)) <= 1, `time ${count}`);
    }
    ++count;
  }
  assert.equal(count, rows.length);
  if (rows.length > 0 && !timeless) {
    const times = rows.map((row) => Number(row[names.indexOf('time_s')]));
    assert.ok(Math.abs(Number(statistics.messageStartTime) - 1e9 * times[0]) <= 1);
    assert.ok(Math.abs(Number(statistics.messageEndTime) - 1e9 * times.at(-1)) <= 1);
  }
  const metadata = [];
  for await (const record of reader.readMetadata()) {
    metadata.push(record);
  }
  assert.deepEqual(
    metadata.map((m) => m.name),
    ['smaservo'],
  );
  return { rows: count, properties, metadata: Object.fromEntries(metadata[0].metadata) };
};

/** Writes the rows by npm's library, on a channel whose messages are JSON. */
exports.write = async function write(file, csv, options = {}) {
  const { names, rows } = table(csv);
  const parts = [];
  let position = 0n;
  const writer = new McapWriter({
    writable: {
      position: () => position,
      write: async (bytes) => {
        parts.push(Buffer.from(bytes));
        position += BigInt(bytes.length);
      },
    },
    useChunks: options.chunked ?? false,
    chunkSize: 10_000,
    compressChunk: {
      zstd: (bytes) => ({ compression: 'zstd', compressedData: zstd.compress(bytes) }),
      lz4: (bytes) => ({ compression: 'lz4', compressedData: Uint8Array.from(lz4.compress(bytes)) }),
    }[options.compression],
  });
  await writer.start({ profile: '', library: 'test' });
  await writer.addMetadata({ name: 'other', metadata: new Map([['key', 'value']]) });
  const encode = (object) => new TextEncoder().encode(JSON.stringify(object));
  const properties = Object.fromEntries(
    names.map((name, i) => [name, { type: Number.isFinite(Number(rows[0][i])) ? 'number' : 'string' }]),
  );
  const schemaId = options.schemaless
    ? 0
    : await writer.registerSchema({
        name: 'Trace',
        encoding: 'jsonschema',
        data: encode({ type: 'object', properties }),
      });
  const channel = (topic, messageEncoding) =>
    writer.registerChannel({ topic, messageEncoding, schemaId, metadata: new Map() });
  const channelId = await channel(options.topic ?? '/trace', 'json');
  const otherId = options.other ? await channel('/other', options.other) : undefined;
  for (const [i, row] of rows.entries()) {
    const object = {};
    names.forEach((name, k) => {
      object[name] = row[k] === '' ? null : member(properties[name].type, row[k]);
    });
    const time = BigInt(Math.round(1e9 * Number(object.time_s ?? i)));
    const message = { sequence: i, logTime: time, publishTime: time };
    await writer.addMessage({ ...message, channelId, data: encode(object) });
    if (otherId !== undefined) {
      await writer.addMessage({ ...message, channelId: otherId, data: encode({ x: i }) });
    }
  }
  await writer.addAttachment({
    name: 'a',
    logTime: 0n,
    createTime: 0n,
    mediaType: 'text/plain',
    data: encode('attached'),
  });
  await writer.end();
  fs.writeFileSync(file, Buffer.concat(parts));
};
