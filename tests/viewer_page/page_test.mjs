// The viewer's page in a browser, both servers in real time behind it. One story, in order.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { kThemes } from '../../shared/tools/scene_viewer/page/theme.js';
import { look_at, need_browser, open_browser } from './browser.mjs';
import { kBuild, kHand, Session } from './servers.mjs';

need_browser('chromium');
const kScene = 'tissue_and_blocks';
const session = new Session();
const saved = path.join(session.folder, 'saved.view');
let sim, hand, viewer, page, errors, strangers, browser;

const text = (id) => page.locator(`#${id}`).textContent();
const number = async (id) => Number(await text(id));
/// Waits until a script of the page gives true.
const until = (script, argument) => page.waitForFunction(script, argument, { polling: 50 });
const until_text = (id, wanted) =>
  until(([where, what]) => document.getElementById(where).textContent === what, [id, wanted]);
const until_above = (id, least) =>
  until(([where, what]) => Number(document.getElementById(where).textContent) > what, [id, least]);

/// What was changed is drawn: by the next but one frame of the browser.
const drawn = () => page.evaluate(() =>
  new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
/// Of the light of a living scene, what one without a simulation has at most. The banner before it is bright: without
/// it the scene has less than half.
const kDimmed = 0.8;
/// What the button would do.
const until_button = (label) =>
  until((wanted) => document.getElementById('play').getAttribute('aria-label') === wanted, label);
const pause = async () => {
  await page.keyboard.press('End');  // live, also where the test before ended early
  await until_button('Pause');
  await page.keyboard.press(' ');
  await until_button('Play');
  await drawn();
};

before(async () => {
  const surfaces = await session.surfaces(kScene);
  viewer = await session.scene_viewer('--session', session.name, '--surfaces', surfaces, '--save', saved);
  ({ browser, page, errors, strangers } = await open_browser(kBuild, 1024, 640, { colorScheme: 'dark' }));
});

after(async () => {
  await browser?.close();
  await session.end();
});

test('a page that is opened first waits for its servers', async () => {
  await page.goto(viewer.url);
  await until(() => document.getElementById('banner').textContent.startsWith('waiting for a sim_server'));
  sim = session.sim_server(kScene);
  hand = session.haptic_server(kHand);
  await until_text('sim-badge', 'simulation alive');
  await until_text('hand-badge', 'hand alive');
});

test('the scene is drawn, surfaces first, and then every sphere of it', async () => {
  await until_text('shown-spheres', '0 of 405 spheres');
  assert.equal(await text('scene-name'), kScene);
  await drawn();
  const skin = await look_at(page, '#scene-canvas');
  await page.locator('#show-surfaces').uncheck();
  await drawn();
  const bare = await look_at(page, '#scene-canvas');
  assert.ok(skin.light > 1.1 * bare.light, `${bare.light} bare, ${skin.light} with surfaces`);
  await page.locator('#show-spheres').check();
  await until_text('shown-spheres', '405 of 405 spheres');
  await drawn();
  const shown = await look_at(page, '#scene-canvas');
  assert.ok(shown.colours > 1000, `${shown.colours} colours`);
  assert.ok(bare.light < 0.9 * shown.light, `${bare.light} without spheres, ${shown.light} with them`);
});

test('figures change as the servers go on', async () => {
  await until_above('number-snapshot_id', await number('number-snapshot_id') + 3);
  await until_above('number-rate', 0);
  await until_above('number-force', 0.1);
  await until_above('number-contacts', 0);
});

test('what the device tells has its line', async () => {
  await until(() => /^gripper open \d+\.\d mm, force -?\d\.\d\d N$/.test(document.getElementById('device').textContent));
});

/// How many pixels of a plot, below its title, have a line's colour, faint at its edges.
const count_coloured = (plot, colour) => page.locator(`#plot-${plot}`).evaluate((canvas, [red, green, blue]) => {
  const kTitle = 16;
  const { data } = canvas.getContext('2d').getImageData(0, kTitle, canvas.width, canvas.height - kTitle);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) {
    if (data[i + 3] > 100 && Math.max(Math.abs(data[i] - red), Math.abs(data[i + 1] - green),
      Math.abs(data[i + 2] - blue)) < 12) ++count;
  }
  return count;
}, colour.match(/[0-9a-f]{2}/g).map((digits) => parseInt(digits, 16)));

test('every plot has its lines', async () => {
  const end_ms = Date.now() + 30000;  // on a busy machine the hand is late at the tissue
  for (const [plot, line] of [['force', 'norm'], ['force', 'y'], ['age', 'age'], ['age', 'mark'], ['time', 'work'],
    ['time', 'wake']]) {
    for (let count = 0; count <= 10;) {
      count = await count_coloured(plot, kThemes.dark.plot[line]);
      assert.ok(count > 10 || Date.now() < end_ms, `${plot}: ${count} pixels of ${line}`);
      await drawn();
    }
  }
  assert.equal(await count_coloured('flags', kThemes.dark.plot.age), 0);  // by which the colour tells
});

/// 'hidden', or '' for shown: what lies over the picture.
const set_overlays = (visibility) => page.evaluate((value) => {
  for (const id of ['show', 'views', 'legend', 'said', 'tooltip']) document.getElementById(id).style.visibility = value;
}, visibility);
const picture = async () => {
  await drawn();
  return (await page.locator('#scene-canvas').screenshot()).toString('base64');
};

test('each switch changes the picture, and back', async () => {
  // In the midst of a touch: the arrow of half a newton is as short as the tool's ball is wide.
  await until(() => {
    if (!(Number(document.getElementById('number-force').textContent) > 1.0)) return false;
    document.getElementById('play').click();
    return true;
  });
  await set_overlays('hidden');
  const press_twice = async (key) => {
    await page.keyboard.press(key);
    await page.keyboard.press(key);
  };
  let before;  // once the path goes up to the frame, whose last ticks come after it
  for (let next = await picture(); next !== before; next = await picture()) {
    before = next;
    await press_twice('t');
  }
  const seen = new Set([before]);
  for (const key of ['n', 'p', 'd', 'l', 'v', 't', 'a']) {
    await page.keyboard.press(key);
    const other = await picture();
    assert.ok(!seen.has(other), `${key} shows nothing of its own`);
    seen.add(other);
    await page.keyboard.press(key);
  }
  assert.ok(await picture() === before, 'all as it was');
  const { yellow } = await look_at(page, '#scene-canvas');
  assert.ok(yellow > 20, `${yellow} pixels of the force's arrow`);
  await set_overlays('');
});

test('paused, the picture stands while history goes on', async () => {
  await pause();
  const frame = await page.locator('#time').getAttribute('title');
  const picture = await page.locator('#scene-canvas').screenshot();
  const last = await page.locator('#timeline').getAttribute('max');
  await until((before) => Number(document.getElementById('timeline').max) > before + 10, Number(last));
  assert.equal(await page.locator('#time').getAttribute('title'), frame);
  assert.ok(picture.equals(await page.locator('#scene-canvas').screenshot()));
});

test('scrubbing shows older snapshots, a step at a time too, and live leads back', async () => {
  const snapshot_id = await number('number-snapshot_id');
  await page.keyboard.press('Shift+ArrowLeft');
  await until((newer) => Number(document.getElementById('number-snapshot_id').textContent) < newer, snapshot_id);
  const frame = await page.locator('#time').getAttribute('title');
  await page.keyboard.press('ArrowRight');
  await until((before) => document.getElementById('time').title === before, `frame ${Number(frame.slice(6)) + 1}`);
  await page.locator('#timeline').focus();
  await page.keyboard.press('Home');
  await until(() => document.getElementById('timeline').value === document.getElementById('timeline').min);
  await page.locator('#live').click();
  await until_above('number-snapshot_id', snapshot_id);
});

test('the camera turns, and the help opens', async () => {
  await pause();
  const before_turn = await page.locator('#scene-canvas').screenshot();
  await page.keyboard.press('u');
  await drawn();
  assert.ok(!before_turn.equals(await page.locator('#scene-canvas').screenshot()));
  await page.keyboard.press('End');
  await page.keyboard.press('?');
  assert.ok(await page.locator('#help').isVisible());
  await page.keyboard.press('Escape');
  assert.ok(!await page.locator('#help').isVisible());
});

test('a simulation over a relay has its line, and is silent while the relay hears nothing', async () => {
  await page.keyboard.press('End');
  assert.equal(await text('relay'), '');
  const { light } = await look_at(page, '#scene-canvas');
  session.set_relay_figures('scene', { connected: 1n, round_trip_ns: 20340000n, clock_bound_ns: 104000n, received: 12345n,
    lost: 12n });
  await until_text('relay', 'simulation over a relay connected, round trip 20.3 ms, clock +0.000 ms ± 0.104 ms, '
    + '12,345 received, 12 lost');
  assert.equal(await text('sim-badge'), 'simulation alive');
  session.set_relay_figures('scene', { connected: 0n, received: 12345n, lost: 12n });
  await until_text('sim-badge', 'simulation silent');
  await until_text('banner', 'simulation silent: its relay hears nothing of it');
  await until_text('relay', 'simulation over a relay silent: the other side is not heard, 12,345 received, 12 lost');
  await drawn();
  const dimmed = await look_at(page, '#scene-canvas');
  assert.ok(dimmed.light < kDimmed * light, `${dimmed.light} silent, ${light} alive`);
  session.set_relay_figures('scene', { relay_id: 0n });
  await until_text('sim-badge', 'simulation alive');
  await until_text('relay', '');
  await until(() => document.getElementById('banner').hidden);
});

test('a killed simulation is shown as such, and another one as alive', async () => {
  const { light } = await look_at(page, '#scene-canvas');
  sim.kill('SIGKILL');
  await until_text('sim-badge', 'simulation dead');
  await until_text('banner', 'simulation dead');
  let flagged = 0;  // the loop lets the force fade
  for (let i = 0; i < 100 && flagged === 0; ++i) flagged = await count_coloured('flags', kThemes.dark.plot.flag);
  assert.ok(flagged > 0, 'a strip of a flag');
  await drawn();
  const dimmed = await look_at(page, '#scene-canvas');
  assert.ok(dimmed.light < kDimmed * light, `${dimmed.light} dead, ${light} alive`);
  assert.equal(await text('hand-badge'), 'hand alive');
  sim = session.shell(await text('banner-command'));  // what the page says that helps
  await until_text('sim-badge', 'simulation alive');
  await until(() => document.getElementById('banner').hidden && document.getElementById('banner-help').hidden);
  await until_text('shown-spheres', '405 of 405 spheres');
});

test('a killed hand is shown as such', async () => {
  session.kill_worker(hand);
  await until_text('hand-badge', 'hand dead');
  await until_text('banner', 'hand dead');
  assert.match(await text('banner-command'), new RegExp(`haptic_server --session ${session.name} --device phantom:`));
});

test('voxels of what never moves are shown too', async () => {
  await session.interrupt(sim);
  fs.writeFileSync(path.join(session.folder, 'still.toml'),
    fs.readFileSync(session.scene_file('moving_sphere'), 'utf8')
      .replace('"prescribed"', '"static"').replace(/^velocity_m_s .*$/gm, ''));
  sim = session.sim_server('still');
  await until_text('shown-spheres', '1 of 1 spheres');
  await pause();
  await set_overlays('hidden');
  const bare = await picture();
  await page.keyboard.press('v');
  await until_text('voxel-most', '1');
  const boxed = await picture();
  assert.ok(boxed !== bare, 'a voxel of the one sphere');
  const level = page.locator('#voxel-level');
  await set_overlays('');
  await level.selectOption({ index: 1 });
  await set_overlays('hidden');
  assert.ok(await picture() === boxed, 'of one level, the only one');
  assert.notEqual(await level.inputValue(), '');
  await page.keyboard.press('v');
  assert.ok(await picture() === bare, 'as it was');
  await set_overlays('');
});

test('all of this was without an error, and without another host', async () => {
  assert.deepEqual(errors, []);
  assert.deepEqual(strangers, []);
});

test('a viewer that is gone is told', async () => {
  await session.interrupt(sim, viewer.child);
  await until(() => document.getElementById('banner').textContent.startsWith('viewer is gone'));
});

test('another viewer in its place, which has another key, is told', async () => {
  await page.route('**/api/status?*', (route) => route.fulfill({ status: 403, body: 'another key' }));
  await until(() => document.getElementById('banner').textContent.startsWith('viewer was started anew'));
  await page.unroute('**/api/status?*');
});

/// The bytes of a saved view's frame, where they are in it.
function place_of_frame(view, wanted) {
  const kHead = 16, kFrame = 2;
  for (let at = kHead, number = 0; ; at += 8 + view.readUInt32LE(at + 4)) {
    if (view.readUInt32LE(at) === kFrame && ++number === wanted) return at + 8;
  }
}

test('a saved view opens without servers, plays, and tells which frame is damaged', async () => {
  const view = fs.readFileSync(saved);
  view.fill(0xff, place_of_frame(view, 2), place_of_frame(view, 2) + 4);
  fs.writeFileSync(saved, view);
  const { url } = await session.scene_viewer('--open', saved);
  await page.goto('about:blank');  // ends what the page before still asks of the viewer that is gone
  errors.length = 0;
  await page.goto(url);
  await until_text('source', 'saved view');
  // It begins before the servers came, and plays at once.
  await until(() => Number(document.getElementById('time').title.slice(6)) > 1);
  await until(() => Number(document.getElementById('timeline').max) > 10);
  await page.locator('#timeline').evaluate((slider) => {
    slider.value = Math.floor((Number(slider.min) + Number(slider.max)) / 2);
    slider.dispatchEvent(new Event('input'));
  });
  await until_text('shown-spheres', '0 of 405 spheres');
  const frame = Number((await page.locator('#time').getAttribute('title')).slice(6));
  await page.keyboard.press(' ');
  await until((from) => Number(document.getElementById('time').title.slice(6)) > from + 10, frame);
  assert.deepEqual(errors, []);
  assert.deepEqual(strangers, []);

  await page.keyboard.press('Home');
  await page.keyboard.press('ArrowRight');
  await until_text('banner', 'frame 2 of this file is damaged');
  await page.keyboard.press('ArrowRight');
  await until(() => document.getElementById('time').title === 'frame 3' &&
    !document.getElementById('banner').textContent.includes('damaged'));
});

test('what fails at first is tried again, and told while it lasts', async () => {
  const rows = Array.from({ length: 200 }, (_, i) => `${i / 1000},${i / 1e4},0,0`);
  const recording = path.join(session.folder, 'recording.csv');
  fs.writeFileSync(recording, ['time_s,x_m,y_m,z_m', ...rows, ''].join('\n'));
  const { url } = await session.scene_viewer('--recording', recording);
  await page.route('**/api/ticks?*', (route) => route.abort(), { times: 1 });
  await page.route('**/api/frame?*', (route) => route.fulfill({ body: 'no frame' }));
  await page.goto(url);
  await until(() => document.getElementById('banner').textContent.startsWith('the frame cannot be shown'));
  await page.unroute('**/api/frame?*');
  await until_text('scene-name', 'recording.csv');
  await until(() => document.getElementById('force-scale').textContent !== '' &&
    document.getElementById('banner').hidden);
});
