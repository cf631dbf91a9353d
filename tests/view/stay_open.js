// Replays a drive at real time: without a page, with a client that receives what a page does and draws nothing, and with
// a page that stays open. Memory of daemon and page, what is received and lost, and the pipeline's latencies.
//   node tests/view/stay_open.js BIN DRIVE OUT [without] [client] [page]        all three if none is named
import {spawn} from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import puppeteer from 'puppeteer-core';
import {WebSocket} from 'ws';

const [bin, drive, out, ...parts] = process.argv.slice(2);
const wants = part => parts.length === 0 || parts.includes(part);
fs.mkdirSync(out, {recursive: true});
const port = 20000 + Math.floor(Math.random() * 20000), config = path.join(out, 'stay_open.toml');
const address = `http://127.0.0.1:${port}`;
fs.writeFileSync(config, `[view]\nport = ${port}\n[calibration]\nmonitor = true\n`);
const sleep = ms => new Promise(done => setTimeout(done, ms));
/// MB; NaN once the process has ended.
const resident = pid => Number(/VmRSS:\s+(\d+)/.exec(fs.readFileSync(`/proc/${pid}/status`, 'utf8'))?.[1]) / 1024;
let bytes = 0, lost = 0;

/// Replays the drive; calls `page_memory` every half minute. Returns the daemon's memory, MB, at these times.
async function replay(name, page_memory = async () => '') {
  console.log(name);
  bytes = lost = 0;
  const child = spawn(path.join(bin, 'infused'), ['--replay', drive, '--config', config, '--socket',
    path.join(out, 'stay_open.sock'), '--view', '--no-wait', '--rate', '1'], {stdio: ['ignore', 'pipe', 'pipe']});
  let text = '', ended = false;
  for (const stream of [child.stdout, child.stderr]) stream.on('data', data => { text = (text + data).slice(-20000); });
  child.on('exit', () => { ended = true; });
  const begin = Date.now(), memory = [];
  for (let next = begin + 30000; !ended; await sleep(200)) {
    if (Date.now() < next) continue;
    next += 30000;
    const minutes = (Date.now() - begin) / 60000, page = await page_memory();
    memory.push(resident(child.pid));
    console.log(`${minutes.toFixed(1)} min: daemon ${memory.at(-1).toFixed(0)} MB${page}, ` +
      `${(bytes / minutes / 60e6).toFixed(1)} MB/s, ${lost} messages lost`);
  }
  console.log(text.split('\n').filter(line => /total .*p99|processor time/.test(line)).join('\n'));
  return memory;
}

/// Counts what a message of the view holds.
function count(size, text) {
  bytes += size;
  if (text?.startsWith('{"class":"LOST"')) lost += JSON.parse(text).count;
}

/// Calls `open` until it succeeds.
async function until_open(open) {
  while (!await open().then(() => true, () => false)) await sleep(200);
}

if (wants('without')) await replay('without a page');

if (wants('client')) {
  until_open(() => new Promise((opened, failed) => {
    const socket = new WebSocket(`${address.replace('http', 'ws')}/stream`, {origin: address});
    socket.on('open', () => { socket.send('{"profiles":true}'); opened(); });
    socket.on('error', failed);
    socket.on('message', (data, binary) => count(data.length, binary ? undefined : data.toString()));
  }));
  await replay('with a client that draws nothing');
}

if (wants('page')) {
  // Without a graphics card the browser draws by the processor: it gets what the daemon leaves.
  const chromium = path.join(out, 'chromium');
  fs.writeFileSync(chromium, '#!/bin/sh\nexec nice -n 19 /usr/bin/chromium "$@"\n', {mode: 0o755});
  const browser = await puppeteer.launch({executablePath: chromium, headless: true, protocolTimeout: 0,
    args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']});
  const page = await browser.newPage();
  let errors = 0;
  page.on('pageerror', () => { ++errors; });
  const session = await page.createCDPSession();
  await session.send('Network.enable');
  session.on('Network.webSocketFrameReceived', ({response: {opcode, payloadData}}) => opcode === 2
    ? count(payloadData.length * 3 / 4) : count(payloadData.length, payloadData));
  until_open(() => page.goto(`${address}/`));
  const memory = await replay('with a page', async () =>
    `, scripts of the page ${((await page.metrics()).JSHeapUsedSize / 1e6).toFixed(0)} MB`);
  await browser.close();
  const settled = memory.slice(3).filter(Number.isFinite), growth = Math.max(...settled) - settled[0];
  if (errors || !(growth <= 20)) {
    console.log(`FAILED: ${errors} errors in the page; ` + (settled.length < 2 ? 'too short to judge the memory'
      : `the daemon grew by ${growth.toFixed(0)} MB after two minutes`));
    process.exit(1);
  }
}
console.log('ok');
process.exit(0);
