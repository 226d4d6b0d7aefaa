// The hand by mouse: taken in the page, it moves the tool of a running session. One story, in order.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { parseArgs } from 'node:util';
import { need_browser, open_browser, open_page } from './browser.mjs';
import { kBuild, Session } from './servers.mjs';

const { values: options } = parseArgs({ options: { screenshots: { type: 'string' } } });
need_browser('chromium');
if (options.screenshots) fs.mkdirSync(options.screenshots, { recursive: true });
const session = new Session();
let viewer, browser, page, errors;

const until = (script, argument, of = page) => of.waitForFunction(script, argument, { polling: 50 });
const text = (id, of = page) => of.locator(`#${id}`).textContent();
const take = async (label, of = page) => {
  await of.locator('#mouse-take').click();
  await until((wanted) => document.getElementById('mouse-take').textContent === wanted, label, of);
};
const state = (wanted, of = page) =>
  until((words) => document.getElementById('mouse-state').textContent.startsWith(words), wanted, of);
const look = (name, of = page) => options.screenshots
  && of.screenshot({ path: path.join(options.screenshots, `${name}.png`) });

/// The tool of the newest frame, as the viewer tells it.
const tool = () => page.evaluate(async () => {
  const { decode } = await import('./api.js');
  const answer = await fetch('api/frame?number=latest');
  return decode(await answer.arrayBuffer()).tool;
});
const tool_when = async (condition, what) => {
  for (const end_ms = Date.now() + 20000; ;) {
    const now = await tool();
    if (condition(now)) return now;
    assert.ok(Date.now() < end_ms, `${what}: ${JSON.stringify(now)}`);
  }
};
const middle = async () => {
  const box = await page.locator('#scene-canvas').boundingBox();
  return [box.x + 0.5 * box.width, box.y + 0.4 * box.height];
};

before(async () => {
  viewer = await session.scene_viewer('--session', session.name);
  session.sim_server('wall');
  session.haptic_server('mouse');
  // Small: where the processor draws, a large picture takes longer than the device waits for the page.
  ({ browser, page, errors } = await open_browser(kBuild, 560, 420, { colorScheme: 'dark' }));
});

after(async () => {
  await browser?.close();
  await session.end();
});

test('a page offers the hand, which nobody holds yet', async () => {
  await page.goto(viewer.url);
  await until(() => !document.getElementById('mouse').hidden);
  await state('Nobody holds the hand');
  assert.equal(await text('mouse-force'), '0.00 N');
});

test('the keyboard takes it, and a drag moves the tool in the plane of the view', async () => {
  await page.keyboard.press('f');  // from the front: right is x, up is z
  await page.locator('#mouse-take').focus();
  await page.keyboard.press('Enter');
  await state('You hold the hand.');
  const before_m = (await tool()).position_m;
  const [x, y] = await middle();
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 100, y, { steps: 5 });
  await page.mouse.up();
  const after = await tool_when(({ position_m }) => position_m[0] > before_m[0] + 0.02, 'to the right');
  assert.ok(Math.abs(after.position_m[1] - before_m[1]) < 2e-3, 'no depth');
  assert.ok(Math.abs(after.position_m[2] - before_m[2]) < 2e-3, 'no height');
});

test('the wheel moves it along the view', async () => {
  const before_m = (await tool()).position_m;
  await page.mouse.wheel(0, -200);
  await tool_when(({ position_m }) => position_m[1] > before_m[1] + 1.5e-3, 'away');
  await page.mouse.wheel(0, 200);
  await tool_when(({ position_m }) => Math.abs(position_m[1] - before_m[1]) < 0.5e-3, 'back');
});

test('keys turn it, and shift moves the mouse alone', async () => {
  await page.keyboard.down('ArrowRight');
  await tool_when(({ orientation_xyzw }) => Math.abs(orientation_xyzw[2]) > 0.2, 'turned about z');
  await page.keyboard.up('ArrowRight');
  const before_m = (await tool()).position_m;
  const [x, y] = await middle();
  await page.keyboard.down('Shift');
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x - 200, y, { steps: 5 });
  await page.keyboard.up('Shift');
  await page.mouse.move(x - 201, y);
  await page.mouse.up();
  await page.waitForTimeout(300);
  const moved_m = Math.abs((await tool()).position_m[0] - before_m[0]);
  assert.ok(moved_m < 2e-3, `${moved_m} m`);
});

test('pressed into the wall it is felt: a number, and an arrow', async () => {
  const [x, y] = await middle();
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x - 100, y, { steps: 5 });
  await page.mouse.move(x - 100, y + 260, { steps: 20 });
  await until(() => parseFloat(document.getElementById('mouse-force').textContent) > 0.5);
  await look('pressed');
  await page.mouse.up();
});

test('a second page cannot take it away, and is told', async () => {
  const second = await open_page(browser, 390, 844, { colorScheme: 'light', hasTouch: true });
  await second.page.goto(viewer.url);
  await until(() => !document.getElementById('mouse').hidden, null, second.page);
  await look('telephone', second.page);
  await second.page.locator('#mouse-take').click();
  await until(() => document.getElementById('said').textContent.startsWith('another page holds the hand'), null, second.page);
  assert.equal(await text('mouse-take', second.page), 'Take the hand');
  assert.equal(await text('mouse-take'), 'Let go');
  await second.page.close();
});

test('a page that hangs lets go: the tool stays, without force', async () => {
  await page.route('**/api/mouse?*', (route) => new Promise(() => {}));
  await tool_when(({ device }) => (device.status & 2) === 0, 'nobody holds it');
  const { position_m } = await tool_when(({ force_N }) => Math.hypot(...force_N) === 0, 'no force');
  await page.waitForTimeout(200);
  const later_m = (await tool()).position_m;
  assert.ok(Math.hypot(...later_m.map((x, i) => x - position_m[i])) < 1e-3, `${position_m} then ${later_m}`);
  await state('You hold the hand; the device does not hear you');
  await page.unroute('**/api/mouse?*');
});

test('Escape lets go, and a page that closes does', async () => {
  await state('You hold the hand.');
  await page.locator('#scene-canvas').focus();
  await page.keyboard.press('Escape');
  await state('Nobody holds the hand');
  await look('free');
  await page.locator('#mouse-take').click();
  await state('You hold the hand.');
  await page.goto('about:blank');
  await page.goto(viewer.url);
  await state('Nobody holds the hand');
  await page.locator('#mouse-take').click();
  await state('You hold the hand.');  // at once, though the page before was another one
  assert.deepEqual(errors.filter((line) => !line.includes('409')), []);
});
