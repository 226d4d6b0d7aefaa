// Debian's Chromium, alone with this machine: what is asked of any other host is refused and noted.
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

const kChromium = '/usr/bin/chromium';
const kArguments = ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];

/// The folder that the build fetched playwright-core into.
export async function load_playwright(build) {
  const file = path.join(build, 'tests', 'viewer_page', 'node_modules', 'playwright-core', 'index.mjs');
  return import(pathToFileURL(file));
}

/// Ends the program as a test that was skipped where there is no browser.
export function need_chromium() {
  if (fs.existsSync(kChromium)) return;
  console.log(`skipped: no ${kChromium}: run scripts/setup`);
  process.exit(77);
}

/// { browser, page, errors, strangers }: errors of the page, hosts it asked for and did not get.
export async function open_browser(build, width, height) {
  const { chromium } = await load_playwright(build);
  const browser = await chromium.launch({ executablePath: kChromium, headless: true, args: kArguments });
  const page = await browser.newPage({ viewport: { width, height } });
  page.setDefaultTimeout(30000);
  const errors = [], strangers = [];
  page.on('console', (message) => { if (message.type() === 'error') errors.push(message.text()); });
  page.on('pageerror', (error) => errors.push(error.message));
  await page.route((url) => url.hostname !== '127.0.0.1', (route) => {
    strangers.push(route.request().url());
    return route.abort();
  });
  return { browser, page, errors, strangers };
}

/// How many colours a part of the page has, how light it is on average, of 255, and how many of its
/// pixels are as yellow as the force's arrow and no body.
export async function look_at(page, selector) {
  const png = (await page.locator(selector).screenshot()).toString('base64');
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
