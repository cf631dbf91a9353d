// Reads MCAP files with Foxglove's readers, which share no code with infuse: by the index and as a stream, CRCs
// included. Decodes every message against its schema and encodes it again, compares the schemas with those of ROS 2
// Humble, and prints the number of messages of each topic. Exits with 1 at the first difference.
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

  const counts = new Map();
  let last = 0n;
  for await (const message of indexed.readMessages({ validateCrcs: true })) {
    const { topic } = indexed.channelsById.get(message.channelId);
    const [reader, writer] = codecs.get(message.channelId);
    assert.ok(message.logTime >= last, "not in order of time");
    last = message.logTime;
    const decoded = reader.readMessage(message.data);
    const again = writer.writeMessage(decoded);
    assert.equal(Buffer.compare(again, message.data), 0, `${topic}: encoded otherwise`);
    counts.set(topic, (counts.get(topic) ?? 0) + 1);
  }
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
