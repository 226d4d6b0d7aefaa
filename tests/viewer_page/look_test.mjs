// How the viewer's page looks and is used, in a browser that is named: telephone and desktop, dark and light, names,
// hands, zoom, links, files. One story, in order.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { parseArgs } from 'node:util';
import { look_at, need_browser, open_browser, open_page } from './browser.mjs';
import { kBuild, kRoot, Session } from './servers.mjs';

const kUsage = `look_test.mjs chromium | firefox [--screenshots FOLDER]

  --screenshots FOLDER   keeps what the page looked like in each size and theme, to be looked at`;
const { values: options, positionals: [name] } = parseArgs({ allowPositionals: true,
  options: { screenshots: { type: 'string' }, help: { type: 'boolean', short: 'h' } } });
if (options.help || !['chromium', 'firefox'].includes(name)) {
  console.log(kUsage);
  process.exit(options.help ? 0 : 1);
}
need_browser(name);
if (options.screenshots) fs.mkdirSync(options.screenshots, { recursive: true });

const kSizes = { desktop: [1280, 720], telephone: [390, 844], on_its_side: [844, 390] };
const session = new Session();
const recording = path.join(session.folder, 'recording.csv');
let browser, page, errors, strangers, url;

const until = (script, argument) => page.waitForFunction(script, argument, { polling: 50 });
const text = (id) => page.locator(`#${id}`).textContent();
const title = () => page.locator('#time').getAttribute('title');
const drawn = () => page.evaluate(() =>
  new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));

/// A second of a hand that goes round, and is pushed.
function write_recording() {
  const rows = Array.from({ length: 1000 }, (_, i) => [i / 1000, 0.05 * Math.cos(i / 300), 0.05 * Math.sin(i / 300), 0,
    Math.sin(i / 50), Math.cos(i / 90), 0.5].join());
  fs.writeFileSync(recording, ['time_s,x_m,y_m,z_m,fx_N,fy_N,fz_N', ...rows, ''].join('\n'));
}

before(async () => {
  write_recording();
  const surfaces = await session.surfaces('block_pinched');
  ({ url } = await session.scene_viewer('--session', session.name, '--hand', 'left', '--surfaces', surfaces));
  session.sim_server('block_pinched');
  for (const hand of ['left', 'right']) session.haptic_server('phantom:profile=touchx,path=still', '--hand', hand);
  ({ browser, page, errors, strangers } = await open_browser(kBuild, ...kSizes.desktop, { name }));
});

after(async () => {
  await browser?.close();
  await session.end();
});

test('a recording plays at once, to its end, with plots', async () => {
  const kept = await session.scene_viewer('--recording', recording);
  await page.goto(kept.url);
  await until(() => document.getElementById('play').getAttribute('aria-label') === 'Pause');
  await until(() => document.getElementById('time').title === 'frame 30');
  await until(() => document.getElementById('play').getAttribute('aria-label') === 'Play');
  assert.equal(await page.locator('#banner').isHidden(), true, await text('banner'));
  assert.equal(await page.locator('#session-choice').isHidden(), true);
});

/// Which time the plot of the forces shows, as it says to whoever listens.
const until_shown = (wanted) => until((text_) => document.getElementById('plot-force').ariaLabel.endsWith(`: ${text_}`), wanted);

test('plots go into a shorter time by the wheel, along by a drag, and back by two clicks', async () => {
  await until_shown('10 s');
  await drawn();
  const whole = await look_at(page, '#plot-force');
  const box = await page.locator('#plot-force').boundingBox();
  const [x, y] = [box.x + 0.7 * box.width, box.y + 0.5 * box.height];
  await page.mouse.move(x, y);
  await page.mouse.wheel(0, -400);
  await until(() => /: 5\.5 s, to −1\.\d+ s$/.test(document.getElementById('plot-force').ariaLabel));
  await page.keyboard.press('0');
  await until_shown('10 s');
  await page.mouse.down();
  await page.mouse.move(x + 60, y, { steps: 3 });
  await page.mouse.up();
  await until(() => /: 10 s, to −\d\.\d+ s$/.test(document.getElementById('plot-force').ariaLabel));
  await page.mouse.move(x, y);
  await page.mouse.dblclick(x, y);
  await until_shown('10 s');
  await page.mouse.move(10, 600);
  for (let i = 0; i < 4; ++i) await page.keyboard.press('+');
  await until_shown('0.63 s');
  await drawn();
  assert.notDeepEqual(await look_at(page, '#plot-force'), whole, 'less of it is seen');
  await page.keyboard.press('0');
  await until_shown('10 s');
});

test('a link leads to its instant and its camera, in another page too', async () => {
  await page.keyboard.press('Home');
  for (let i = 0; i < 20; ++i) await page.keyboard.press('ArrowRight');
  await until(() => document.getElementById('time').title === 'frame 21');
  await page.keyboard.press('u');  // from above
  await drawn();
  await page.locator('#link').click();
  await until(() => location.hash.includes('camera='));
  const address = page.url();
  assert.match(address, /#t=0\.667&camera=(-?[\d.e-]+,){5}-?[\d.e-]+$/);
  await page.goto('about:blank');
  await page.goto(address);
  await until(() => document.getElementById('time').title === 'frame 21');
  await until(() => document.getElementById('play').getAttribute('aria-label') === 'Play');
  assert.equal(await title(), 'frame 21', 'it stands there');
  await until(() => document.getElementById('force-scale').textContent !== '');
  await page.evaluate(() => history.replaceState(null, '', '#'));
  await page.locator('#link').click();
  await until(() => location.hash.includes('camera='));
  const camera_of = (link) => link.split('camera=')[1].split(',').map(Number);
  camera_of(page.url()).forEach((x, i) => assert.ok(Math.abs(x - camera_of(address)[i]) < 1e-3, `${page.url()}, ${address}`));
  await page.evaluate(() => { location.hash = '#t=nonsense&camera=1,2&session='; });
  await drawn();
  assert.equal(await title(), 'frame 21', 'what is no link changes nothing');
});

test('picture and film are files of their kind', async () => {
  await page.evaluate(() => {  // what a click on a link would keep
    window.kept = [];
    const address_of = URL.createObjectURL;
    URL.createObjectURL = (blob) => { window.kept.push(blob); return address_of(blob); };
    HTMLAnchorElement.prototype.click = function click() { window.kept.at(-1).file = this.download; };
  });
  const kept = (i) => page.evaluate(async (at) => {
    const blob = window.kept[at];
    const bytes = new Uint8Array(await blob.arrayBuffer());
    return { file: blob.file, size: blob.size, begin: [...bytes.slice(0, 24)] };
  }, i);
  await page.locator('#picture').click();
  await until(() => window.kept.length === 1);
  const picture = await kept(0);
  assert.equal(picture.file, 'recording.csv_0.67s.png');
  assert.equal(Buffer.from(picture.begin.slice(0, 8)).toString('latin1'), '\x89PNG\r\n\x1a\n');
  const width = await page.locator('#scene-canvas').evaluate((canvas) => canvas.width);
  assert.equal(Buffer.from(picture.begin).readUInt32BE(16), width);

  let film = { size: 0 };
  // A browser that has little of the processor encodes nothing in a short film.
  for (let tries = 0; film.size === 0 && tries < 4; ++tries) {
    await page.locator('#film').click();
    assert.equal(await page.locator('#film').getAttribute('aria-pressed'), 'true');
    if (tries === 0) await page.keyboard.press(' ');
    await page.waitForTimeout(1200 * 3 ** tries);
    await page.locator('#film').click();
    await until((films) => window.kept.length === 1 + films, tries + 1);
    film = await kept(tries + 1);
  }
  assert.equal(film.file, 'recording.csv_0.67s.webm');
  assert.deepEqual(film.begin.slice(0, 4), [0x1a, 0x45, 0xdf, 0xa3], 'EBML');
  assert.ok(film.size > 2000, `${film.size} bytes`);
});

test('a scene is drawn without a window', { skip: name === 'firefox' && 'it is drawn in Chromium' }, () => {
  const file = path.join(session.folder, 'scene.png');
  const words = [`${kRoot}/scripts/gallery/plot_viewer.mjs`, '--scene', session.scene_file('organ'), '--out', file];
  const { status, stderr } = spawnSync('node', [...words, '--after-s', '0.1'], { encoding: 'utf8' });
  assert.equal(status, 0, stderr);
  const png = fs.readFileSync(file);
  assert.deepEqual([png.readUInt32BE(16), png.readUInt32BE(20)], [840, 472]);
  assert.ok(png.length > 5_000 && png.length < 150_000, `${png.length} bytes`);
  for (const [more, wanted] of [[['--only', 'x'], /--only/], [['--after-s', '0'], /--after-s: value 0/]]) {
    const refused = spawnSync('node', [...words, ...more], { encoding: 'utf8' });
    assert.equal(refused.status, 1);
    assert.match(refused.stderr, wanted);
    assert.equal(refused.stderr.trim().split('\n').length, 1);
  }
});

test('both hands have names and colours, and the plots go over to the other one', async () => {
  await page.goto(url);
  await until(() => document.querySelectorAll('#hands > div').length === 2);
  assert.match(await text('hands'), /^left\d\.\d\d Nplotted belowright\d\.\d\d NPlot$/);
  const choice = page.locator('#session-choice');
  assert.equal(await choice.inputValue(), `${session.name}+left`);
  await page.getByRole('button', { name: 'Plot hand right' }).click();
  await until((wanted) => document.getElementById('session-choice').value === wanted, `${session.name}+right`);
  await until(() => document.getElementById('hands').textContent.startsWith('left') &&
    document.getElementById('hands').textContent.endsWith('plotted below'));
  await choice.selectOption({ label: `${session.name}, hand left` });
  await until(() => document.getElementById('hands').textContent.endsWith('Plot'));
});

test('what is pointed at has its name', async () => {
  await page.keyboard.press('u');
  await drawn();
  const box = await page.locator('#scene-canvas').boundingBox();
  const names = new Set();
  for (let row = 2; row < 12; row += 2) {
    for (let column = 2; column < 7 && !(names.has('block') && names.has('floor')); ++column) {
      await page.mouse.move(box.x + (column + 0.5) / 8 * box.width, box.y + (row + 0.5) / 12 * box.height);
      await page.waitForTimeout(15);
      if (await page.locator('#tooltip').isVisible()) names.add(await text('tooltip'));
    }
  }
  for (const wanted of ['block', 'floor']) assert.ok(names.has(wanted), `${wanted} among ${[...names]}`);
  for (const found of names) assert.match(found, /^(block|stand|floor|tool of hand (left|right))$/);
  assert.equal(await text('body-count'), '3');
});

/// Texts whose contrast with what lies behind them is below WCAG's 4.5 to 1.
const faint_texts = () => page.evaluate(() => {
  const channels = (colour) => {
    const context = new OffscreenCanvas(1, 1).getContext('2d', { willReadFrequently: true });
    context.fillStyle = colour;
    context.fillRect(0, 0, 1, 1);
    return [...context.getImageData(0, 0, 1, 1).data];
  };
  const light = ([red, green, blue]) => [red, green, blue].map((value) => value / 255)
    .map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4))
    .reduce((sum, value, i) => sum + value * [0.2126, 0.7152, 0.0722][i], 0);
  const ground_of = (element) => {
    for (let at = element; at; at = at.parentElement) {
      const colour = channels(getComputedStyle(at).backgroundColor);
      if (colour[3] > 128) return colour;
    }
    return channels('white');
  };
  const faint = [];
  for (const element of document.querySelectorAll('body *')) {
    const own = [...element.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.data.trim());
    if (!own || !element.checkVisibility() || element.disabled) continue;
    const pair = [light(channels(getComputedStyle(element).color)), light(ground_of(element))].sort((a, b) => b - a);
    const ratio = (pair[0] + 0.05) / (pair[1] + 0.05);
    if (ratio < 4.5) faint.push(`${element.tagName} ${element.id} "${element.textContent.trim()}" ${ratio.toFixed(2)}`);
  }
  return faint;
});

/// Controls that stand outside the window, wholly or in part, and such as have no name or no size.
const lost_controls = () => page.evaluate(() => {
  const lost = [];
  if (document.documentElement.scrollWidth > innerWidth) lost.push(`the page is ${document.documentElement.scrollWidth} wide`);
  for (const element of document.querySelectorAll('header *, footer *, #views *, #show > summary')) {
    if (!element.matches('button, select, input, .badge, summary, h1') || !element.checkVisibility()) continue;
    const { left, right, top, bottom, width, height } = element.getBoundingClientRect();
    const is_named = element.ariaLabel || element.textContent.trim();
    if (left < 0 || right > innerWidth + 0.5 || top < 0 || bottom > innerHeight + 0.5 || width < 20 || height < 16 ||
      !is_named) lost.push(`${element.tagName} ${element.id} ${element.textContent.trim().slice(0, 20)} ${[left, top, right, bottom].map(Math.round)}`);
  }
  const { width, height } = document.getElementById('scene-canvas').getBoundingClientRect();
  if (width < 0.5 * Math.min(innerWidth, innerHeight) || height < 200) lost.push(`picture ${width} x ${height}`);
  return lost;
});

// Firefox, which draws by software more slowly, is shown every size and every theme, but not each with each.
const kFirefox = { desktop: 'dark', telephone: 'light', on_its_side: 'dark' };
for (const theme of ['dark', 'light']) {
  for (const [size, [width, height]] of Object.entries(kSizes)) {
    if (name === 'firefox' && !options.screenshots && kFirefox[size] !== theme) continue;
    test(`${size}, ${theme}: all can be read and reached, and the scene is drawn`, async () => {
      await page.setViewportSize({ width, height });
      if (await page.locator('html').getAttribute('data-theme') !== theme) await page.locator('#theme').click();
      assert.equal(await page.locator('html').getAttribute('data-theme'), theme);
      await drawn();
      assert.deepEqual(await lost_controls(), []);
      assert.equal(await page.locator('#show').evaluate((element) => element.open), size === 'desktop', 'switches in the way');
      assert.deepEqual(await faint_texts(), []);
      const { colours, light } = await look_at(page, '#scene-canvas');
      assert.ok(colours > 500, `${colours} colours`);
      assert.ok(theme === 'dark' ? light < 110 : light > 140, `${light} of 255`);
      await page.locator('#plot-flags').scrollIntoViewIfNeeded();
      const plot = await look_at(page, '#plot-force');
      assert.ok(plot.colours > 20, `${plot.colours} colours of a plot`);
      if (options.screenshots) {
        await page.locator('#numbers').scrollIntoViewIfNeeded();
        await page.waitForTimeout(1500);
        await page.screenshot({ path: path.join(options.screenshots, `${name}_${size}_${theme}.png`), caret: 'initial' });
      }
    });
  }
}

test('the theme is the system\'s until it is chosen, and a finger\'s tap names a body', { skip: name === 'firefox' &&
  'Firefox is not told by this protocol of another system, nor has it fingers' }, async () => {
  const finger = await open_page(browser, ...kSizes.telephone, { hasTouch: true, isMobile: true, colorScheme: 'light' });
  const root = finger.page.locator('html');
  await finger.page.goto(url);
  assert.equal(await root.getAttribute('data-theme'), 'light');
  await finger.page.emulateMedia({ colorScheme: 'dark' });
  await finger.page.waitForFunction(() => document.documentElement.dataset.theme === 'dark');
  await finger.page.locator('#theme').tap();
  await finger.page.reload();
  assert.equal(await root.getAttribute('data-theme'), 'light', 'chosen, and kept');
  await finger.page.waitForFunction(() => document.querySelectorAll('#hands > div').length === 2);
  assert.deepEqual(await finger.page.evaluate(() => [...document.querySelectorAll('header button, footer button')]
    .filter((button) => button.offsetHeight < 36).map(({ id }) => id)), [], 'high enough for a finger');
  const live = await finger.page.locator('#live').boundingBox();
  assert.ok(live.y < (await finger.page.locator('#play').boundingBox()).y + 1, 'all buttons of the foot are in one row');
  const box = await finger.page.locator('#scene-canvas').boundingBox();
  await finger.page.touchscreen.tap(box.x + 0.5 * box.width, box.y + 0.55 * box.height);
  await finger.page.waitForFunction(() => !document.getElementById('tooltip').hidden);
  assert.match(await finger.page.locator('#tooltip').textContent(), /^(block|stand|floor)$/);
  if (options.screenshots) await finger.page.screenshot({ path: path.join(options.screenshots, 'finger_light.png') });
  assert.deepEqual([...finger.errors, ...finger.strangers], []);
});

test('all of this was without an error, and without another host', () => {
  // In Firefox Playwright itself adds a style where it takes a screenshot, and is refused.
  assert.deepEqual(errors.filter((line) => name === 'chromium' || !line.includes('inline style')), []);
  assert.deepEqual(strangers, []);
});
