// Opens the view of a replay in headless Chromium: every panel, in light and dark, a restart of the daemon, a page that
// stops reading, and the same reports with and without a page.
//   node tests/view/check.js BIN DRIVE OUT [CHROMIUM]
import {execFileSync, spawn} from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import puppeteer from 'puppeteer-core';

const [bin, drive, out, chromium = '/usr/bin/chromium'] = process.argv.slice(2);
const port = 20000 + Math.floor(Math.random() * 20000), url = `http://127.0.0.1:${port}/`;
fs.mkdirSync(out, {recursive: true});
const config = path.join(out, 'infused.toml');
fs.writeFileSync(config, `[view]\nport = ${port}\n[calibration]\nmonitor = true\n`);
let failures = 0;
function check(name, good, figures = '') {
  console.log(`${good ? 'ok    ' : 'FAILED'} ${name} ${figures}`);
  failures += good ? 0 : 1;
}
const sleep = ms => new Promise(done => setTimeout(done, ms));
const replay = (...more) => [path.join(bin, 'infused'), '--replay', drive, '--config', config, '--socket',
  path.join(out, 'view.sock'), '--json', ...more];
function start(...more) {
  const [program, ...rest] = replay('--view', ...more);
  const child = spawn(program, rest, {stdio: 'ignore'});
  return {child, ended: new Promise(done => child.on('exit', done))};
}
function stop(run) { run.child.kill('SIGINT'); return run.ended; }
async function waitFor(condition, limit = 20000) {
  for (const end = Date.now() + limit; Date.now() < end; await sleep(100)) if (await condition()) return true;
  return false;
}
const cpuSeconds = pid => {
  const fields = fs.readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ');
  return (Number(fields[11]) + Number(fields[12])) / 100;
};

const browser = await puppeteer.launch({executablePath: chromium, headless: true,
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']});
const errors = [];
async function newPage(scheme) {
  const page = await browser.newPage();
  page.on('console', m => { if (m.type() === 'error' && !/ERR_CONNECTION|WebSocket connection/.test(m.text())) errors.push(m.text()); });
  page.on('pageerror', e => errors.push(e.message));
  await page.setViewport({width: 1280, height: 860});
  await page.emulateMediaFeatures([{name: 'prefers-color-scheme', value: scheme}]);
  return page;
}
async function load(page) {
  return waitFor(() => page.goto(url).then(() => true, () => false));
}
const text = (page, selector) => page.$eval(selector, e => e.textContent).catch(() => '');

// Without a page, and with one: the reports are the same.
const plain = path.join(out, 'plain.jsonl'), watched = path.join(out, 'watched.jsonl');
execFileSync(replay()[0], [...replay('--rate', 'max').slice(1), '--reports', plain], {stdio: 'ignore'});

let run = start('--rate', '2', '--reports', watched);
const page = await newPage('light');
check('the page loads', await load(page));
check('the sweep is shown', await waitFor(async () => /returns shown/.test(await text(page, '#sweep'))), await text(page, '#sweep'));
for (const scheme of ['light', 'dark']) {
  await page.emulateMediaFeatures([{name: 'prefers-color-scheme', value: scheme}]);
  for (const panel of ['cameras', 'scene', 'calibration', 'motion', 'health']) {
    await page.click(`nav button[data-panel=${panel}]`);
    await sleep(700);
    await page.screenshot({path: path.join(out, `${panel}-${scheme}.png`)});
  }
}
check('health lists the lidar', /sweeps\/s/.test(await text(page, '#health')));
check('odometry is shown', /speed, m\/s/.test(await text(page, '#motion')));
const cameras = await page.$$eval('#cameras canvas', all => all.length);
if (cameras > 0) {
  check('the lidar is on the image', await waitFor(async () => /[1-9]\d* returns in view/.test(await text(page, '#cameras'))),
    await text(page, '#cameras .tools .dim'));
}
await page.keyboard.press('1');
await page.keyboard.press(' ');
await sleep(1500);
const paused = await text(page, '#time');
await sleep(2500);
check('a pause holds the replay', paused === await text(page, '#time'), paused);
await page.keyboard.press(' ');
await run.ended;
check('reports are the same with a page', fs.readFileSync(plain).equals(fs.readFileSync(watched)),
  `${fs.statSync(watched).size} bytes`);
check('the page says that the daemon has ended', await waitFor(async () => /ended/.test(await text(page, '#connection'))));
run = start('--rate', '1');
check('and finds the next one', await waitFor(async () => /^connected/.test(await text(page, '#connection'))));

await stop(run);
await page.close();

// Cost: processor time of the daemon at real time, and what a page receives.
for (const watchedBy of [0, 1]) {
  const begun = start('--rate', '1');
  const view = await newPage('light');
  let bytes = 0;
  if (watchedBy) {
    const session = await view.createCDPSession();
    await session.send('Network.enable');
    session.on('Network.webSocketFrameReceived', event => {
      const data = event.response.payloadData;
      bytes += event.response.opcode === 2 ? data.length * 3 / 4 : data.length;
    });
    await load(view);
  } else {
    await waitFor(() => fetch(url).then(() => true, () => false));
  }
  await sleep(1000);
  const before = cpuSeconds(begun.child.pid), at = Date.now(), received = bytes;
  await sleep(5000);
  const seconds = (Date.now() - at) / 1000;
  console.log(`cost   ${watchedBy} pages: ${(100 * (cpuSeconds(begun.child.pid) - before) / seconds).toFixed(0)} % of a core, ` +
    `${((bytes - received) / seconds / 1e6).toFixed(1)} MB/s`);
  await view.close();
  await stop(begun);
}
check('no errors in the console', errors.length === 0, errors.slice(0, 3).join(' | '));
await browser.close();
process.exit(failures ? 1 : 0);
