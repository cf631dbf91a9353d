// Connects to a running infused with Foxglove's client, which shares no code with infuse; subscribes to every topic,
// decodes each message against the advertised schema and encodes it again. Prints the number of messages of each topic;
// exits with 1 at the first difference.
//
//   node check_viewer.mjs PORT SUBPROTOCOL SECONDS

import assert from "node:assert/strict";
import protocol from "@foxglove/ws-protocol";
import { WebSocket } from "ws";
import { parse } from "@foxglove/rosmsg";
import { MessageReader, MessageWriter } from "@foxglove/rosmsg2-serialization";

const [port, subprotocol, seconds] = process.argv.slice(2);
const socket = new WebSocket(`ws://127.0.0.1:${port}`, [subprotocol]);
const client = new protocol.FoxgloveClient({ ws: socket });
const counts = new Map();
const channels = new Map();  // by subscription
let info, times = 0;

client.on("error", (error) => { throw error; });
client.on("serverInfo", (event) => { info = event; });
client.on("time", () => { ++times; });
client.on("status", (event) => console.error("status", event.message));
client.on("advertise", (advertised) => {
  assert.equal(socket.protocol, subprotocol);
  for (const channel of advertised) {
    assert.equal(channel.encoding, "cdr");
    assert.equal(channel.schemaEncoding, "ros2msg");
    const definitions = parse(channel.schema, { ros2: true });
    channels.set(client.subscribe(channel.id),
      { topic: channel.topic, reader: new MessageReader(definitions), writer: new MessageWriter(definitions) });
  }
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const { topic, reader, writer } = channels.get(subscriptionId);
  const bytes = new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
  assert.equal(Buffer.compare(writer.writeMessage(reader.readMessage(bytes)), bytes), 0, `${topic}: encoded otherwise`);
  assert.ok(timestamp > 0n);
  counts.set(topic, (counts.get(topic) ?? 0) + 1);
});

setTimeout(() => {
  assert.equal(info?.name, "infuse");
  assert.ok(info.capabilities.includes("time") && times > 0, "a replay without times");
  for (const topic of [...counts.keys()].sort()) console.log(topic, counts.get(topic));
  process.exit(0);
}, 1000 * Number(seconds));
