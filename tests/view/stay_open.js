// Replays a drive at real time, first without a page, then with one that stays open: memory of daemon and page, what the
// page receives and loses, and the pipeline's latencies.
//   node tests/view/stay_open.js BIN DRIVE OUT
import {spawn} from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import puppeteer from 'puppeteer-core';

const [bin, drive, out] = process.argv.slice(2);
fs.mkdirSync(out, {recursive: true});
const port = 20000 + Math.floor(Math.random() * 20000), config = path.join(out, 'stay_open.toml');
fs.writeFileSync(config, `[view]\nport = ${port}\n[calibration]\nmonitor = true\n`);
const sleep = ms => new Promise(done => setTimeout(done, ms));
const resident = pid => Number(/VmRSS:\s+(\d+)/.exec(fs.readFileSync(`/proc/${pid}/status`, 'utf8'))[1]) / 1024;

/// Replays the drive; calls `each` every half minute with the minutes since the start.
async function replay(each) {
  const child = spawn(path.join(bin, 'infused'), ['--replay', drive, '--config', config, '--socket',
    path.join(out, 'stay_open.sock'), '--view', '--rate', '1'], {stdio: ['ignore', 'pipe', 'pipe']});
  let text = '', ended = false;
  for (const stream of [child.stdout, child.stderr]) stream.on('data', data => { text = (text + data).slice(-20000); });
  child.on('exit', () => { ended = true; });
  const begin = Date.now();
  for (let next = begin + 30000; !ended; await sleep(200)) {
    if (Date.now() < next) continue;
    next += 30000;
    await each((Date.now() - begin) / 60000, child.pid);
  }
  console.log(text.split('\n').filter(line => /total .*p99|processor time/.test(line)).join('\n'));
}

console.log('without a page');
let memory = [];
await replay(async (minutes, pid) => memory.push(`${minutes.toFixed(1)} min ${resident(pid).toFixed(0)} MB`));
console.log(`daemon: ${memory.join(', ')}`);

console.log('with a page');
const browser = await puppeteer.launch({executablePath: '/usr/bin/chromium', headless: true,
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']});
const page = await browser.newPage();
let bytes = 0, lost = 0, errors = 0;
page.on('pageerror', () => { ++errors; });
const session = await page.createCDPSession();
await session.send('Network.enable');
session.on('Network.webSocketFrameReceived', ({response: {opcode, payloadData}}) => {
  bytes += opcode === 2 ? payloadData.length * 3 / 4 : payloadData.length;
  if (opcode === 1 && payloadData.startsWith('{"class":"LOST"')) lost += JSON.parse(payloadData).count;
});
(async () => {
  for (let open = false; !open; await sleep(200)) open = await page.goto(`http://127.0.0.1:${port}/`).then(() => true, () => false);
})();
memory = [];
await replay(async (minutes, pid) => {
  await session.send('HeapProfiler.collectGarbage');
  const {JSHeapUsedSize} = await page.metrics();
  memory.push([resident(pid), JSHeapUsedSize / 1e6]);
  console.log(`${minutes.toFixed(1)} min: daemon ${resident(pid).toFixed(0)} MB, scripts of the page ${(JSHeapUsedSize / 1e6).toFixed(0)} MB, ` +
    `${(bytes / minutes / 60e6).toFixed(1)} MB/s, ${lost} messages lost`);
});
await browser.close();
const settled = memory.slice(3), growth = settled.map(of => of[0] - settled[0][0]);
if (errors || settled.length < 2 || Math.max(...growth) > 20) {
  console.log(`FAILED: ${errors} errors in the page; the daemon grew by ${Math.max(...growth).toFixed(0)} MB after two minutes`);
  process.exit(1);
}
console.log('ok');
