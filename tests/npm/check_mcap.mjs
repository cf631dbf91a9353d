// Reads MCAP files with Foxglove's readers, which share no code with infuse: by the index and as a stream, CRCs
// included. Decodes every message against its schema and encodes it again, compares the schemas with those of ROS 2
// Humble, and prints the number of messages of each topic. The frames must be one tree (REP 105), and a number that is
// not known must have its mark: a covariance of −1. Exits with 1 at the first difference.
//
//   node check_mcap.mjs FILE.mcap...

import assert from "node:assert/strict";
import { open, readFile } from "node:fs/promises";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";
import { parse } from "@foxglove/rosmsg";
import { MessageReader, MessageWriter } from "@foxglove/rosmsg2-serialization";
import { ros2humble } from "@foxglove/rosmsg-msgs-common";

const kPackages = new Set(["builtin_interfaces", "std_msgs", "geometry_msgs", "sensor_msgs", "nav_msgs",
  "diagnostic_msgs", "tf2_msgs", "velodyne_msgs"]);
const kNotCommon = new Set(["velodyne_msgs"]); // not among the common definitions

function fieldsOf(definition) {
  return definition.definitions.filter((field) => field.isConstant !== true)
    .map(({ name, type, isArray, arrayLength, isComplex }) =>
      ({ name, type: type.replace("/msg/", "/"), isArray: isArray === true, arrayLength, isComplex: isComplex === true }));
}

// The definitions of Humble by name: "geometry_msgs/Pose".
const kHumble = new Map(Object.entries(ros2humble).map(([name, definition]) =>
  [name.replace("/msg/", "/"), definition]));

function checkSchema(schema) {
  assert.equal(schema.encoding, "ros2msg");
  const definitions = parse(new TextDecoder().decode(schema.data), { ros2: true });
  for (const definition of definitions) {
    const name = (definition.name ?? schema.name).replace("/msg/", "/");
    const [packageName] = name.split("/");
    assert.ok(kPackages.has(packageName), `${name} is of another package`);
    if (kNotCommon.has(packageName) || packageName === "builtin_interfaces") continue;
    assert.ok(kHumble.has(name), `${name} is not a type of ROS 2 Humble`);
    // Times are primitive in these readers, where the file spells them out.
    const plain = (field) => ({ ...field, type: field.type.replace("builtin_interfaces/Time", "time"),
      isComplex: field.isComplex && field.type !== "builtin_interfaces/Time" });
    assert.deepEqual(fieldsOf(definition).map(plain), fieldsOf(kHumble.get(name)).map(plain), name);
  }
  return definitions;
}

// The writer counts characters where CDR counts bytes: it cannot encode texts beyond ASCII.
function isPlain(value) {
  return typeof value === "string" ? /^[\x00-\x7f]*$/.test(value)
    : typeof value !== "object" || value === null || ArrayBuffer.isView(value) || Object.values(value).every(isPlain);
}

// No number is NaN, except a quantity whose covariance begins with −1, and the altitude of a fix without covariance.
function checkNumbers(topic, message) {
  const unknown = (value) => typeof value === "number" ? Number.isNaN(value)
    : typeof value === "object" && value !== null && !ArrayBuffer.isView(value) && Object.values(value).some(unknown);
  for (const [name, value] of Object.entries(message)) {
    const marked = message[`${name}_covariance`]?.[0] === -1 ||
      (name === "altitude" && message.position_covariance_type === 0);
    assert.ok(marked || !unknown(value), `${topic}: ${name} is NaN without a mark`);
  }
}

// Every frame of the messages hangs in one tree, map → odom → base_link → sensors; `parents`: child → parent.
function checkFrames(parents, frames) {
  const path = (frame) => parents.has(frame) ? [...path(parents.get(frame)), frame] : [frame];
  const base = path("base_link");
  assert.deepEqual(base, parents.has("odom") ? ["map", "odom", "base_link"] : parents.has("base_link") ? ["odom", "base_link"] : ["base_link"]);
  for (const frame of new Set([...frames, ...parents.keys()])) assert.equal(path(frame)[0], base[0], `${frame} is in another tree`);
}

async function streamed(path, decompressHandlers) {
  const reader = new McapStreamReader({ includeChunks: false, decompressHandlers, validateCrcs: true });
  reader.append(await readFile(path));
  let messages = 0;
  for (let record; (record = reader.nextRecord()) !== undefined;) {
    if (record.type === "Message") ++messages;
  }
  assert.ok(reader.done(), "the file does not end as it should");
  return messages;
}

async function check(path) {
  const decompressHandlers = await loadDecompressHandlers();
  const file = await open(path, "r");
  const readable = {
    size: async () => BigInt((await file.stat()).size),
    read: async (offset, size) => {
      const buffer = new Uint8Array(Number(size));
      const { bytesRead } = await file.read(buffer, 0, Number(size), Number(offset));
      assert.equal(bytesRead, Number(size));
      return buffer;
    },
  };
  const indexed = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  assert.equal(indexed.header.profile, "ros2");
  assert.ok(indexed.statistics !== undefined, "no statistics");
  assert.equal(indexed.chunkIndexes.length, indexed.statistics.chunkCount);
  for (const chunk of indexed.chunkIndexes)
    assert.ok(chunk.messageEndTime - chunk.messageStartTime <= 1_000_000_000n, "a chunk is longer than 1 s");

  const codecs = new Map();
  for (const channel of indexed.channelsById.values()) {
    assert.equal(channel.messageEncoding, "cdr");
    assert.match(channel.metadata.get("offered_qos_profiles") ?? "", /^- history: /, channel.topic);
    const latched = /durability: 1\n/.test(channel.metadata.get("offered_qos_profiles"));
    assert.equal(latched, channel.topic === "/tf_static", `${channel.topic}: transient local`);
    const definitions = checkSchema(indexed.schemasById.get(channel.schemaId));
    codecs.set(channel.id, [new MessageReader(definitions), new MessageWriter(definitions)]);
  }

  const counts = new Map(), parents = new Map(), frames = new Set();
  let last = 0n;
  for await (const message of indexed.readMessages({ validateCrcs: true })) {
    const { topic } = indexed.channelsById.get(message.channelId);
    const [reader, writer] = codecs.get(message.channelId);
    assert.ok(message.logTime >= last, "not in order of time");
    last = message.logTime;
    const decoded = reader.readMessage(message.data);
    if (isPlain(decoded)) {
      assert.equal(Buffer.compare(writer.writeMessage(decoded), message.data), 0, `${topic}: encoded otherwise`);
    }
    counts.set(topic, (counts.get(topic) ?? 0) + 1);
    checkNumbers(topic, decoded);
    if (decoded.header?.frame_id) frames.add(decoded.header.frame_id);
    for (const { header, child_frame_id: child } of decoded.transforms ?? []) {
      assert.equal(parents.get(child) ?? header.frame_id, header.frame_id, `${child} has two parents`);
      parents.set(child, header.frame_id);
    }
  }
  checkFrames(parents, frames);
  await file.close();
  let total = 0;
  for (const [id, count] of indexed.statistics.channelMessageCounts) {
    assert.equal(counts.get(indexed.channelsById.get(id).topic) ?? 0, Number(count));
    total += Number(count);
  }
  assert.equal(total, Number(indexed.statistics.messageCount));
  assert.equal(await streamed(path, decompressHandlers), total);
  for (const topic of [...counts.keys()].sort()) console.log(topic, counts.get(topic));
}

for (const path of process.argv.slice(2)) await check(path);
