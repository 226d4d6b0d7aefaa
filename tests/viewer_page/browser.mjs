// Debian's Chromium or Firefox, alone with this machine: what is asked of any other host is refused and noted.
import { spawn } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

const kPrograms = { chromium: ['/usr/bin/chromium'], firefox: ['/usr/bin/firefox-esr', '/usr/bin/Xvfb'] };
const kArguments = ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];

/// The folder that the build fetched playwright-core into.
export async function load_playwright(build) {
  const file = path.join(build, 'tests', 'viewer_page', 'node_modules', 'playwright-core', 'index.mjs');
  if (!fs.existsSync(file)) throw new Error(`${file}: no such file: run scripts/setup --test and scripts/build release`);
  return import(pathToFileURL(file));
}

/// Ends the program as a test that was skipped where there is no browser of that name.
export function need_browser(name) {
  const missing = kPrograms[name].find((program) => !fs.existsSync(program));
  if (!missing) return;
  console.log(`skipped: no ${missing}: run scripts/setup`);
  process.exit(77);
}

/// A display of our own: Firefox has WebGL by GLX alone where there is no graphics card. { name, end() }
async function start_display() {
  const child = spawn('setpriv', ['--pdeathsig', 'KILL', 'Xvfb', '-displayfd', '3', '-screen', '0', '1600x1200x24',
    '-nolisten', 'tcp'], { stdio: ['ignore', 'ignore', 'ignore', 'pipe'] });
  const number = await new Promise((resolve, reject) => {
    child.stdio[3].once('data', (data) => resolve(`${data}`.trim()));
    child.once('exit', (status) => reject(new Error(`Xvfb ended with ${status}`)));
  });
  return { name: `:${number}`, end: () => child.kill() };
}

/// Playwright has no Firefox but its own; Debian's is driven by the standard's protocol, WebDriver BiDi.
async function launch_firefox(playwright) {
  const display = await start_display();
  const browser = await playwright._bidiFirefox.launch({
    executablePath: kPrograms.firefox[0], headless: true, env: { ...process.env, DISPLAY: display.name },
    firefoxUserPrefs: { 'webgl.force-enabled': true, 'ui.systemUsesDarkTheme': 1, 'ui.prefersReducedMotion': 0 } });
  browser.on('disconnected', display.end);
  return browser;
}

/// { browser, page, errors, strangers }: errors of the page, hosts it asked for and did not get. name: chromium or
/// firefox. context: more of Playwright's options of a page.
export async function open_browser(build, width, height, { name = 'chromium', ...context } = {}) {
  const playwright = (await load_playwright(build)).default;
  const browser = name === 'firefox' ? await launch_firefox(playwright)
    : await playwright.chromium.launch({ executablePath: kPrograms.chromium[0], headless: true, args: kArguments });
  return { browser, ...await open_page(browser, width, height, context) };
}

/// Another page of the browser, that shares nothing with the first.
export async function open_page(browser, width, height, context = {}) {
  const page = await browser.newPage({ viewport: { width, height }, ...context });
  page.setDefaultTimeout(30000);
  const errors = [], strangers = [];
  page.on('console', (message) => { if (message.type() === 'error') errors.push(message.text()); });
  page.on('pageerror', (error) => errors.push(error.message));
  await page.route((url) => url.hostname !== '127.0.0.1', (route) => {
    strangers.push(route.request().url());
    return route.abort();
  });
  return { page, errors, strangers };
}

/// How many colours a part of the page has, how light it is on average, of 255, and how many of its
/// pixels are as yellow as the force's arrow and no body.
export async function look_at(page, selector) {
  const png = (await page.locator(selector).screenshot({ caret: 'initial' })).toString('base64');
  return page.evaluate(async (data) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const bytes = context.getImageData(0, 0, image.width, image.height).data;
    const colours = new Set(new Uint32Array(bytes.buffer)).size;
    let sum = 0, yellow = 0;
    for (let i = 0; i < bytes.length; i += 4) {
      const [red, green, blue] = bytes.subarray(i, i + 3);
      sum += red + green + blue;
      if (red > 120 && green > 0.6 * red && blue < 0.5 * red) ++yellow;
    }
    return { colours, light: sum / (0.75 * bytes.length), yellow };
  }, png);
}
