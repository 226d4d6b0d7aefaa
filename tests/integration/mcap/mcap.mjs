// Reads a recording, and writes a bag of ROS 2, by the libraries of MCAP's and Foxglove's makers.
//   node mcap.mjs indexed|streamed FILE   what it holds, as JSON; messages as they were written
//   node mcap.mjs check FILE              every message against its schema, Foxglove's also against Foxglove's
//   node mcap.mjs bag FILE                writes topics given on standard input: {TOPIC: {type, messages: [[ns, {}]]}}
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { createRequire } from 'node:module';

const require = createRequire(path.join(process.env.STILLGRID_BUILD_DIR, 'tests/integration/mcap/here.js'));
const { McapIndexedReader, McapStreamReader, McapWriter } = require('@mcap/core');
const { decompress } = require('fzstd');

const decompressHandlers = { zstd: (bytes, size) => decompress(bytes, new Uint8Array(Number(size))) };
const text_of = (bytes) => new TextDecoder('utf-8', { fatal: true }).decode(bytes);
const plain = (value) => JSON.parse(JSON.stringify(value, (key, part) => (typeof part === 'bigint' ? Number(part)
  : part instanceof Map ? Object.fromEntries(part) : part)));

/** What readers find, one way or the other. */
class Found {
  constructor() {
    this.topics = {};
    this.metadata = {};
  }
  channel(channel, schema) {
    this.topics[channel.topic] ??= { schema_name: schema.name, schema_encoding: schema.encoding,
      schema: text_of(schema.data), encoding: channel.messageEncoding, messages: [] };
  }
  message(topic, message) {
    const text = text_of(message.data);
    JSON.parse(text);
    this.topics[topic].messages.push([String(message.logTime), message.sequence, text]);
  }
}

async function read_indexed(file) {
  const bytes = fs.readFileSync(file);
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, length) => new Uint8Array(bytes.buffer, bytes.byteOffset + Number(offset), Number(length)),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const found = new Found();
  for (const channel of reader.channelsById.values())
    found.channel(channel, reader.schemasById.get(channel.schemaId));
  for await (const message of reader.readMessages({ validateCrcs: true }))
    found.message(reader.channelsById.get(message.channelId).topic, message);
  for await (const record of reader.readMetadata()) found.metadata[record.name] = plain(record.metadata);
  return { ...found, is_whole: true, statistics: plain(reader.statistics), chunks: plain(reader.chunkIndexes) };
}

function read_streamed(file) {
  const reader = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  const found = new Found();
  const schemas = new Map();
  const channels = new Map();
  reader.append(fs.readFileSync(file));
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === 'Schema') schemas.set(record.id, record);
    if (record.type === 'Channel') {
      channels.set(record.id, record);
      found.channel(record, schemas.get(record.schemaId));
    }
    if (record.type === 'Message') found.message(channels.get(record.channelId).topic, record);
    if (record.type === 'Metadata') found.metadata[record.name] = plain(record.metadata);
  }
  return { ...found, is_whole: reader.done() };
}

function without_descriptions(schema) {
  if (Array.isArray(schema)) return schema.map(without_descriptions);
  if (typeof schema !== 'object' || schema === null) return schema;
  return Object.fromEntries(Object.entries(schema)
    .filter(([key, value]) => !(typeof value === 'string' && (key === 'description' || key === '$comment')))
    .map(([key, value]) => [key, without_descriptions(value)]));
}

async function check(file) {
  const Ajv = require('ajv').default;
  const foxglove = require('@foxglove/schemas/jsonschema');
  const ajv = new Ajv({ strict: false });
  const checked = {};
  for (const [topic, { schema_name, schema, messages }] of Object.entries((await read_indexed(file)).topics)) {
    const ours = JSON.parse(schema);
    const rules = [ajv.compile(ours)];
    if (schema_name.startsWith('foxglove.')) {
      const theirs = foxglove[schema_name.slice('foxglove.'.length)];
      assert.deepEqual(without_descriptions(ours), without_descriptions(theirs));
      rules.push(ajv.compile(theirs));
    }
    for (const [, , text] of messages)
      for (const is_valid of rules)
        assert.ok(is_valid(JSON.parse(text)), `${topic}: ${text.slice(0, 200)}: ${ajv.errorsText(is_valid.errors)}`);
    checked[topic] = messages.length;
  }
  return checked;
}

async function write_bag(file) {
  const { parse } = require('@foxglove/rosmsg');
  const { MessageWriter } = require('@foxglove/rosmsg2-serialization');
  const parts = [];
  let size = 0n;
  const writable = {
    position: () => size,
    write: async (bytes) => {
      parts.push(Buffer.from(bytes));
      size += BigInt(bytes.length);
    },
  };
  const writer = new McapWriter({ writable });
  await writer.start({ profile: 'ros2', library: 'of a test' });
  for (const [topic, { type, definition, messages }] of Object.entries(JSON.parse(fs.readFileSync(0, 'utf8')))) {
    const schemaId = await writer.registerSchema({ name: type, encoding: 'ros2msg', data: Buffer.from(definition) });
    const channelId = await writer.registerChannel({ schemaId, topic, messageEncoding: 'cdr', metadata: new Map() });
    const serialised = new MessageWriter(parse(definition, { ros2: true }));
    for (const [k, [stamp, message]] of messages.entries()) {
      const data = serialised.writeMessage(message);
      await writer.addMessage({ channelId, sequence: k, logTime: BigInt(stamp), publishTime: BigInt(stamp), data });
    }
  }
  await writer.end();
  fs.writeFileSync(file, Buffer.concat(parts));
  return {};
}

const [verb, file] = process.argv.slice(2);
const verbs = { indexed: read_indexed, streamed: read_streamed, check, bag: write_bag };
process.stdout.write(JSON.stringify(await verbs[verb](file)));
