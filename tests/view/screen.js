// A screenshot of the one screen at a time of a replay, as large as a desktop's browser.
//   node tests/view/screen.js BIN DRIVE CONFIG FIGURE.jpg SECONDS
import {spawn} from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import puppeteer from 'puppeteer-core';

const [bin, drive, base, figure, seconds] = process.argv.slice(2), until = Number(seconds);
const port = 20000 + Math.floor(Math.random() * 20000), config = path.join(path.dirname(base), 'screen.toml');
fs.writeFileSync(config, `[view]\nport = ${port}\n${fs.readFileSync(base, 'utf8')}`);
const daemon = spawn(path.join(bin, 'infused'), ['--replay', drive, '--config', config, '--socket',
  path.join(path.dirname(base), 'screen.sock'), '--view', '--json'], {stdio: 'ignore'});
const sleep = ms => new Promise(done => setTimeout(done, ms));
let browser = null, shown = false;
try {
  browser = await puppeteer.launch({executablePath: '/usr/bin/chromium', headless: true, protocolTimeout: 0,
    args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']});
  const page = await browser.newPage();
  await page.setViewport({width: 1600, height: 1000});
  const opened = () => page.goto(`http://127.0.0.1:${port}/`, {waitUntil: 'domcontentloaded', timeout: 60000}).then(() => true, () => false);
  for (let k = 0; k < 100 && !await opened(); ++k) await sleep(200);
  const begun = () => page.evaluate('player.history.newest !== null').catch(() => false);
  for (let k = 0; k < 300 && !await begun(); ++k) await sleep(200);
  await page.evaluate(t => player.goTo(driveStart + t), until - 4);  // from there at its pace: profiles come every two seconds
  await page.evaluate('scene.accumulate = 10');
  const time = () => page.evaluate('player.history.newest - driveStart');
  for (let k = 0; k < 3000 && await time() < until - 0.3; ++k) await sleep(200);
  await page.evaluate('player.pause(true)');
  await sleep(3000);
  shown = await time() >= until - 0.3;
  await page.screenshot({path: figure, type: 'jpeg', quality: 82});
} finally {
  await browser?.close();
  daemon.kill('SIGINT');
}
if (!shown) console.error(`the replay did not reach ${until} s`);
process.exit(shown ? 0 : 1);
