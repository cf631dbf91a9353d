// Opens the view of a replay in a headless browser: every panel, in light and dark, pause, step and seek, a restart of the
// daemon, a page that stops reading for 10 s, and the same reports with and without a page.
//   node tests/view/check.js BIN DRIVE OUT [CONFIG] [--quick] [--firefox]
// --quick leaves out the screenshots in both colours and the cost. --firefox uses Firefox instead of Chromium, as --quick
// does; WebGL needs a display there, which may be virtual (xvfb-run -a).
import {execFileSync, spawn} from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import puppeteer from 'puppeteer-core';
import {WebSocket} from 'ws';

const firefox = process.argv.includes('--firefox'), quick = firefox || process.argv.includes('--quick');
const [bin, drive, out, base] = process.argv.slice(2).filter(argument => !argument.startsWith('--'));
const port = 20000 + Math.floor(Math.random() * 20000), url = `http://127.0.0.1:${port}/`;
fs.mkdirSync(out, {recursive: true});
const config = path.join(out, 'infused.toml');
fs.writeFileSync(config, `[view]\nport = ${port}\n` + (base ? fs.readFileSync(base, 'utf8') : '[calibration]\nmonitor = true\n'));
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
  process.on('exit', () => child.kill());
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

const browser = await puppeteer.launch(firefox ?
  {product: 'firefox', protocol: 'webDriverBiDi', executablePath: '/usr/bin/firefox-esr', headless: true, extraPrefsFirefox: {'webgl.force-enabled': true}} :
  {executablePath: '/usr/bin/chromium', headless: true,
    args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']});
const errors = [];
async function newPage(scheme) {
  const page = await browser.newPage();
  page.on('console', m => { if (m.type() === 'error' && !/ERR_CONNECTION|WebSocket connection/.test(m.text())) errors.push(m.text()); });
  page.on('pageerror', e => errors.push(e.message));
  await page.setViewport({width: 1280, height: 860});
  if (!firefox) await page.emulateMediaFeatures([{name: 'prefers-color-scheme', value: scheme}]);
  return page;
}
async function load(page) {
  return waitFor(() => page.goto(url).then(() => true, () => false));
}
const text = (page, selector) => page.$eval(selector, e => e.textContent).catch(() => '');

// Without a page, and with one: the reports are the same.
const plain = path.join(out, 'plain.jsonl'), watched = path.join(out, 'watched.jsonl');
execFileSync(replay()[0], [...replay('--rate', 'max').slice(1), '--reports', plain], {stdio: 'ignore'});

let run = start('--rate', quick ? '0.2' : '1', '--reports', watched);
const page = await newPage('light');
check('the page loads', await load(page));
check('the sweep is shown', await waitFor(async () => /returns shown/.test(await text(page, '#sweep'))), await text(page, '#sweep'));
// The drive has waited: its first report is there, too.
check('the drive began with the page', await page.evaluate('player.history.first - driveStart') < 1.5);
if (!quick) {
  for (const [name, width, height] of [['1920', 1920, 1080], ['1280', 1280, 860], ['820', 820, 1180], ['390', 390, 844]]) {
    for (const scheme of ['light', 'dark']) {
      await page.emulateMediaFeatures([{name: 'prefers-color-scheme', value: scheme}]);
      await page.setViewport({width, height});
      for (const panel of width < 1100 ? ['scene', 'cameras', 'calibration', 'plan', 'health'] : ['']) {
        if (panel) await page.evaluate(`layout.open('${panel}')`);
        await sleep(500);
        await page.screenshot({path: path.join(out, `${name}-${scheme}${panel && '-'}${panel}.png`)});
      }
    }
  }
  await page.emulateMediaFeatures([{name: 'prefers-color-scheme', value: 'light'}]);
  await page.setViewport({width: 1280, height: 860});
}
// One screen: four panels and a strip; each can be enlarged, and what was chosen is remembered.
const seen = () => page.$$eval('section', all => all.filter(e => e.offsetWidth > 0).map(e => e.id).join(' '));
check('one screen has four panels', await seen() === 'scene cameras calibration plan', await seen());
check('nothing is beyond the window', await page.evaluate('document.documentElement.scrollHeight <= innerHeight && document.documentElement.scrollWidth <= innerWidth'));
await page.$eval('#plan .enlarge', e => e.click());
check('a panel is enlarged', await seen() === 'plan' && await page.evaluate('place("plan").offsetWidth > 0.9 * innerWidth'), await seen());
await page.reload();
check('and is so after a reload', await waitFor(async () => await seen() === 'plan'), await seen());
await page.keyboard.press('Escape');
check('and the others come back', await seen() === 'scene cameras calibration plan');
check('after a reload it is drive time', await waitFor(async () => Math.abs(await page.evaluate('health ? shownTime() - driveStart - health.drive_s : 9')) < 2),
  await text(page, '#time'));
await page.evaluate(`layout.open('health')`);
check('health lists the lidar', await waitFor(async () => /sweeps\/s/.test(await text(page, '#health'))));
check('odometry is shown', /Odometry/.test(await text(page, '#health')));
await page.evaluate(`layout.enlarge('')`);
check('the level is that of HEALTH', await waitFor(async () => await page.evaluate(`place('level').textContent.endsWith(health.level)`)));
check('every sensor has a chip', await page.evaluate(`[...health.sensors, ...health.streams].every(s => place('strip').textContent.includes(s.device))`));
// Legends, and values under the pointer, against what the page draws.
for (const [colour, legend] of [['0', /distance from the lidar, m/], ['1', /height above ground, m/], ['2', /reflectivity, %/], ['3', /ring/]]) {
  await page.select('#colour', colour);
  check('its colours have a legend', legend.test(await text(page, '#scene-legend')), await text(page, '#scene-legend'));
}
await waitFor(() => page.evaluate('Boolean(scene.frame && scene.drawnProjection)'));
await page.click('#pause');
await sleep(1500);
const target = await page.evaluate(() => {
  const {header, points} = scene.frame, box = scene.canvas.getBoundingClientRect();
  for (let i = 0; i < header.points; i += 7) {
    const T = header.T_vehicle_lidar, v = [points.x[i], points.y[i], points.z[i]].map(c => 0.01 * c);
    const at = [0, 4, 8].map(r => T[r] * v[0] + T[r + 1] * v[1] + T[r + 2] * v[2] + T[r + 3]), pixel = scene.pixel(scene.drawnProjection, ...at);
    if (pixel && pixel[0] > 20 && pixel[1] > 60 && pixel[0] < box.width - 20 && pixel[1] < box.height - 20) {
      return {x: box.x + pixel[0], y: box.y + pixel[1], range: Math.hypot(...v)};
    }
  }
  return null;
});
await page.mouse.move(target.x, target.y);
check('the pointer shows a return', await waitFor(async () => /range [\d.]+ m, height -?[\d.]+ m, reflectivity \d+ %, ring \d+, sweep at/.test(await text(page, '#scene-value')), 3000),
  `${await text(page, '#scene-value')} (one there: ${target.range.toFixed(2)} m)`);
const drawn = await page.evaluate(() => {  // pixels that are neither background nor grid
  scene.draw();
  const gl = scene.gl, pixels = new Uint8Array(4 * scene.canvas.width * scene.canvas.height);
  gl.readPixels(0, 0, scene.canvas.width, scene.canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return pixels.reduce((count, value, i) => count + (i % 4 === 0 && Math.max(value, pixels[i + 1], pixels[i + 2]) > 100 ? 1 : 0), 0);
});
check('the returns are drawn', drawn > 1000, `${drawn} pixels`);
const before_pan = await page.evaluate('[...scene.target]');
await page.keyboard.down('Shift');
await page.mouse.down();
await page.mouse.move(target.x + 40, target.y + 30);
await page.mouse.up();
await page.keyboard.up('Shift');
check('the view is moved', (await page.evaluate('[...scene.target]')).some((v, i) => Math.abs(v - before_pan[i]) > 0.1));
await page.click('#reset');
check('and reset', (await page.evaluate('[...scene.target]')).every(v => v === 0));
await page.click('#pause');
const cameras = await page.$$eval('#images canvas', all => all.length);
if (cameras > 0) {
  check('the lidar is on the image', await waitFor(async () => /[1-9]\d* returns/.test(await text(page, '#images'))), await text(page, '#images .note'));
  const canvas = await page.$('#images canvas'), box = await canvas.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  check('the pointer shows a pixel', await waitFor(async () => /pixel \d+, \d+: red \d+/.test(await text(page, '#images .value')), 3000), await text(page, '#images .value'));
  // The profile of the dependence: six charts, or why there are none; asked for while it is seen only.
  const profile = () => page.evaluate(`([...player.history.entries].find(([key]) => key.startsWith('profile:'))?.[1] ?? []).at(-1)?.value.header ?? null`);
  check('a profile of the dependence comes', await waitFor(async () => await profile() !== null));
  const {reason, profiles} = await profile();
  if (reason) {
    check('without a profile the reason is shown', await waitFor(async () => (await text(page, '#calibration')).includes(reason)), reason);
  } else {
    const names = Object.keys(profiles);
    check('it has six axes for each calibration', await waitFor(async () => await page.$$eval('#calibration .profiles svg', all => all.length) === 6 * cameras) &&
      names.includes('use') && names.includes('saved') &&
      names.every(name => profiles[name].length === 6 && profiles[name].every(axis => axis.length === 25 && axis.every(Number.isFinite))), names.join(', '));
    check('whose middle is the dependence at that calibration', names.every(name => profiles[name].every(axis => axis[12] === profiles[name][0][12])));
  }
  await page.evaluate(`layout.enlarge('scene')`);
  await sleep(500);
  const count = () => page.evaluate(`[...player.history.entries].filter(([key]) => key.startsWith('profile:')).reduce((sum, [, list]) => sum + list.length, 0)`);
  const had = await count();
  await sleep(3000);
  check('no profile is made while the panel is closed', await count() === had, `${had} before`);
  await page.evaluate(`layout.enlarge('')`);
}
await page.evaluate('document.activeElement.blur()');
await page.keyboard.press(' ');
await sleep(1500);
const paused = await text(page, '#cursor');
await sleep(2500);
check('a pause holds the replay', /^connected/.test(await text(page, '#connection')) && /paused/.test(paused) && paused === await text(page, '#cursor'), paused);
await page.keyboard.press(' ');
await page.click('#finish');
check('a run to the end ends there', await waitFor(async () => /s the end$/.test(await text(page, '#cursor')), 120000), await text(page, '#cursor'));
check('reports are the same with a page', await waitFor(() => fs.readFileSync(plain).equals(fs.readFileSync(watched))),
  `${fs.statSync(watched).size} bytes`);
// The daemon stays: a page that is opened now has the reports of the whole drive, and its last sweep.
await page.reload();
check('the end is shown after a reload', await waitFor(async () => /s the end$/.test(await text(page, '#cursor'))), await text(page, '#cursor'));
check('with the last sweep', await waitFor(async () => /returns shown/.test(await text(page, '#sweep'))));
check('and the course from the start', await page.evaluate('course.states.get("health")[0].t - driveStart') < 1.5);
// Scrubbing: the time under the pointer is shown at once.
const strip = await (await page.$('#timeline')).boundingBox(), middle = await page.evaluate('[timeline.left, timeline.right]');
await page.mouse.click(strip.x + (middle[0] + middle[1]) / 2, strip.y + 20);
const range = await page.evaluate('[timeline.range.first, timeline.range.last, player.cursor, driveStart]');
check('scrubbing shows the time under the pointer', Math.abs(range[2] - (range[0] + range[1]) / 2) < 0.02 * (range[1] - range[0]), await text(page, '#cursor'));
await page.keyboard.press('End');
await stop(run);
check('the page says that the daemon has ended', await waitFor(async () => /ended/.test(await text(page, '#connection'))));
run = start('--rate', '1');
check('and finds the next one', await waitFor(async () => /^connected/.test(await text(page, '#connection'))));

await stop(run);
await page.close();

// Step and seek; and whatever is asked for, the reports are the same.
const lines = fs.readFileSync(plain, 'utf8').trim().split('\n');
const stamps = kind => lines.filter(line => line.startsWith(`{"class":"${kind}"`)).map(line => Number(/"stamp":"?(\d+)/.exec(line)[1]) / 1e9);
const sweeps = stamps('SWEEP'), begun = sweeps[0], ended = sweeps[sweeps.length - 1];
const period = sweeps.slice(1).map((t, i) => t - sweeps[i]).sort((a, b) => a - b)[sweeps.length >> 1];
const sought = path.join(out, 'sought.jsonl');
run = start('--rate', '0.25', '--reports', sought);
{
  const view = await newPage('light');
  await load(view);
  const shown = () => view.evaluate('scene.frame ? seconds(scene.frame.header.stamp) : 0');
  check('a slow replay is shown', await waitFor(async () => await shown() > 0));
  await view.keyboard.press(' ');
  await sleep(1000);
  const seen = [await shown()];
  for (let k = 0; k < 5; ++k) {
    await view.keyboard.press('ArrowRight');
    await waitFor(async () => await shown() !== seen[k], 3000);
    await sleep(200);
    seen.push(await shown());
  }
  const steps = seen.slice(1).map((t, i) => t - seen[i]);
  check('a step is one sweep', steps.every(step => Math.abs(step - period) < 0.25 * period), steps.map(s => s.toFixed(3)).join(' '));
  await view.keyboard.press('ArrowLeft');
  check('and one back', await shown() === seen[seen.length - 2]);
  const jump = async t => {
    await view.evaluate(`place('goto').value = ${t} - driveStart; place('goto').dispatchEvent(new Event('change'))`);
  };
  const target = begun + 0.6 * (ended - begun);
  await jump(target);
  check('a seek runs on to its time and holds', await waitFor(async () => Math.abs(await shown() - target) < 3 * period, 180000) &&
    (await sleep(1000), Math.abs(await shown() - target) < 3 * period), `${(await shown() - begun).toFixed(2)} s of ${(target - begun).toFixed(2)} s`);
  await jump(seen[2]);
  check('a seek back shows what was there', await shown() === seen[2] && /looking back/.test(await text(view, '#cursor')));
  const early = lines.some(line => line.startsWith('{"class":"ALERT"') && Number(/"stamp":"?(\d+)/.exec(line)[1]) / 1e9 <= seen[2]);
  check('and no alert that was raised later', early || await text(view, '#alerts') === '', await text(view, '#alerts'));
  await view.screenshot({path: path.join(out, 'looking-back.png')});
  const alerts = lines.filter(line => line.startsWith('{"class":"ALERT"') && line.includes('"raised"'))
    .map(line => Number(/"stamp":"?(\d+)/.exec(line)[1]) / 1e9).filter(t => t > target + 1);
  if (alerts.length > 0) {
    await view.evaluate('player.follow()');
    await view.click('#next');
    check('the next alert is found', await waitFor(async () => await view.evaluate('player.cursor !== null && !player.seekingAlert'), 180000) &&
      Math.abs(await view.evaluate('player.cursor') - alerts[0]) < 0.001, `${(alerts[0] - begun).toFixed(1)} s`);
    await view.screenshot({path: path.join(out, 'alert.png')});
    check('and shown', (await text(view, '#alerts')).length > 0, await text(view, '#alerts p'));
  }
  await view.evaluate('player.follow()');
  await jump(ended + 1000);
  await waitFor(async () => /s the end$/.test(await text(view, '#cursor')), 120000);
  check('reports are the same with steps and seeks', fs.readFileSync(plain).equals(fs.readFileSync(sought)));
  await stop(run);
  await waitFor(async () => /ended/.test(await text(view, '#connection')));
  await jump(seen[1]);
  // What is older is kept more coarsely (history.js).
  check('after the end one can still look back', Math.abs(await shown() - seen[1]) < 10 * period, `${(await shown() - seen[1]).toFixed(2)} s beside`);
  await view.close();
}

// Without waiting: the drive ends by itself, though nobody looks.
run = start('--no-wait', '--rate', 'max');
check('a replay that does not wait ends with the drive', await Promise.race([run.ended.then(() => true), sleep(120000).then(() => false)]));

// A client that reads nothing for 10 s, beside another (that a slow one loses messages: view_server_test.cpp).
run = start('--no-wait', '--rate', '0.25');
await waitFor(() => fetch(url).then(() => true, () => false));
function client() {
  const socket = new WebSocket(url.replace('http', 'ws') + 'stream', {origin: url.slice(0, -1)});
  const state = {socket, messages: 0, lost: 0, open: true};
  socket.on('message', (data, binary) => {
    ++state.messages;
    const message = binary ? {} : JSON.parse(data);
    if (message.class === 'LOST') state.lost += message.count;
  });
  socket.on('close', () => { state.open = false; });
  socket.on('error', () => { state.open = false; });
  return state;
}
const stopped = client(), brisk = client();
await waitFor(() => stopped.messages > 10 && brisk.messages > 10);
if (!quick || firefox) await sleep(5000);  // the pipeline itself has its memory
stopped.socket._socket.pause();
const memory = () => Number(/VmRSS:\s+(\d+)/.exec(fs.readFileSync(`/proc/${run.child.pid}/status`, 'utf8'))[1]) / 1024;
const memoryBefore = memory();
const before = {stopped: stopped.messages, brisk: brisk.messages};
await sleep(10000);
check('the other page goes on while one is stopped', brisk.messages > before.brisk + 20 && brisk.lost === 0, `${brisk.messages - before.brisk} messages`);
check('memory of the daemon does not grow for it', memory() < memoryBefore + 50, `${(memory() - memoryBefore).toFixed(1)} MB`);
const resumed = stopped.messages;
stopped.socket._socket.resume();
check('a page that was stopped for 10 s goes on', await waitFor(() => stopped.open && stopped.messages > resumed + 20),
  `${stopped.messages - resumed} messages, ${stopped.lost} lost`);
stopped.socket.terminate();
brisk.socket.terminate();
await stop(run);

// Cost: processor time of the daemon at real time, and what a page receives.
for (const watchedBy of quick ? [] : [0, 1]) {
  const daemon = start('--no-wait', '--rate', '1');
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
  const before = cpuSeconds(daemon.child.pid), at = Date.now(), received = bytes;
  await sleep(5000);
  const seconds = (Date.now() - at) / 1000;
  console.log(`cost   ${watchedBy} pages: ${(100 * (cpuSeconds(daemon.child.pid) - before) / seconds).toFixed(0)} % of a core, ` +
    `${((bytes - received) / seconds / 1e6).toFixed(1)} MB/s`);
  await view.close();
  await stop(daemon);
}
check('no errors in the console', errors.length === 0, errors.slice(0, 3).join(' | '));
await browser.close();
process.exit(failures ? 1 : 0);
