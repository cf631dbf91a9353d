// Opens the view of a replay in headless Firefox: the page loads and draws. WebGL needs a display there, which
// may be virtual.
//   xvfb-run -a node tests/view/firefox.js BIN DRIVE OUT [CONFIG]
import {spawn} from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import puppeteer from 'puppeteer-core';

const [bin, drive, out, base] = process.argv.slice(2);
const port = 20000 + Math.floor(Math.random() * 20000), config = path.join(out, 'firefox.toml');
fs.mkdirSync(out, {recursive: true});
fs.writeFileSync(config, `[view]\nport = ${port}\n` + (base ? fs.readFileSync(base, 'utf8') : ''));
const daemon = spawn(path.join(bin, 'infused'), ['--replay', drive, '--config', config, '--socket', path.join(out, 'firefox.sock'),
  '--view', '--no-wait', '--rate', '0.25', '--json'], {stdio: 'ignore'});
const sleep = ms => new Promise(done => setTimeout(done, ms));
let good = false, returns = '', failure = '';
let browser = null;
try {
  browser = await puppeteer.launch({product: 'firefox', executablePath: '/usr/bin/firefox-esr', protocol: 'webDriverBiDi',
    headless: true, extraPrefsFirefox: {'webgl.force-enabled': true}});
  const page = await browser.newPage();
  page.on('pageerror', e => { failure = e.message; });
  await page.setViewport({width: 1280, height: 860});
  for (let k = 0; k < 50 && !good; ++k, await sleep(200)) good = await page.goto(`http://127.0.0.1:${port}/`).then(() => true, () => false);
  for (let k = 0; k < 100 && !/returns shown/.test(returns); ++k, await sleep(200)) returns = await page.$eval('#sweep', e => e.textContent);
  await sleep(1000);
  await page.screenshot({path: path.join(out, 'firefox.png')});
  // Pixels that are neither background nor grid: the returns.
  const drawn = await page.evaluate(() => {
    scene.draw();
    const gl = scene.gl, pixels = new Uint8Array(4 * scene.canvas.width * scene.canvas.height);
    gl.readPixels(0, 0, scene.canvas.width, scene.canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    let count = 0;
    for (let i = 0; i < pixels.length; i += 4) count += Math.max(pixels[i], pixels[i + 1], pixels[i + 2]) > 100 ? 1 : 0;
    return count;
  });
  good &&= drawn > 1000 && failure === '';
  console.log(`${good ? 'ok    ' : 'FAILED'} Firefox draws: ${returns}, ${drawn} pixels ${failure}`);
} finally {
  await browser?.close();
  daemon.kill('SIGINT');
}
process.exit(good ? 0 : 1);
