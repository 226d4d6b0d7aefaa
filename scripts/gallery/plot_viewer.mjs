#!/usr/bin/env node
// Pictures by the viewer: of its page, and of scenes alone, both servers in real time behind it.
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';
import { need_browser, open_browser } from '../../tests/viewer_page/browser.mjs';
import { kBuild, kHand, kRoot, Session } from '../../tests/viewer_page/servers.mjs';

const kUsage = `scripts/gallery/plot_viewer.mjs [--charts FOLDER] [--only NAME]
scripts/gallery/plot_viewer.mjs --scene FILE.toml --out PICTURE.png [--device SPEC] [--after-s S]

Starts both servers on a scene in real time with a simulated hand, opens the viewer's page in Debian's
Chromium without a window, waits until the hand presses, and writes a picture: of the page, or of the scene
alone. Half a minute each.
  --charts FOLDER   where to; default: docs/charts
  --only NAME       pages, scenes, or one of them: viewer, viewer_telephone, scene_ and a shipped scene that
                    docs/gallery.md shows; default: all
  --scene FILE      a picture of this scene, after S seconds; without --device no hand is in it
  --out PICTURE     where to
  --device SPEC     of haptic_server, as phantom:path=press,centre_z_m=0
  --after-s S       of the simulation; default: 2
Environment: STILLGRID_BUILD_DIR, default build/release.`;

const kScenePixels = [840, 472];
const kMaxBytes = 150_000;

/// Where the hand of a scene goes.
const hand_of = (scene) => `phantom:profile=touchx,path=${kRoot}/sim_server/scene/scenes/${scene}.hand.csv`;

/// Where each hand of a scene for two goes.
const two_hands = (scene) => Object.fromEntries(['left', 'right'].map((name) => [
  name, `phantom:profile=touchx,path=${kRoot}/sim_server/scene/scenes/${scene}.${name}.csv`]));

const kTissue = { scene: 'tissue_and_blocks', device: kHand, least_N: 1.2, from: 1600 };
/// least_N: so hard the hand presses in the picture, of snapshot `from` at least. page: of the whole page;
/// pixels, theme: of that.
const kPictures = {
  viewer: { ...kTissue, from: 10000, page: true, pixels: [1280, 720], theme: 'dark' },
  viewer_telephone: { ...kTissue, from: 10000, page: true, pixels: [390, 844], theme: 'light' },
  scene_tissue_and_blocks: kTissue,
  scene_threads: {
    scene: 'threads', device: 'phantom:profile=premium15,path=circle,centre_z_m=0,depth_m=0', least_N: 0.005, from: 2000 },
  scene_organ: { scene: 'organ', device: 'phantom:path=press,centre_z_m=0', least_N: 0.1, from: 2000 },
  scene_laparoscopy: {
    scene: 'laparoscopy', device: 'phantom:profile=premium15,path=stroke,depth_m=0.03,pivot_x_m=0,pivot_y_m=0,pivot_z_m=-0.11',
    least_N: 0.5, from: 200 },
  scene_pendulum_chain: {
    scene: 'pendulum_chain', device: 'phantom:profile=touchx,path=stroke,centre_z_m=0,depth_m=0', least_N: 0.1, from: 400 },
  scene_sewn_ball: { scene: 'sewn_ball', device: hand_of('sewn_ball'), from: 400 },
  scene_pillars: {
    scene: 'pillars', device: 'phantom:profile=premium15,hand=light,path=press,centre_z_m=-0.03,depth_m=0.03,period_s=2',
    least_N: 0.5, from: 100 },
  scene_moving_sphere: { scene: 'moving_sphere', device: 'phantom:path=still,centre_z_m=0', least_N: 0.1 },
  scene_block_pinched: { scene: 'block_pinched', hands: two_hands('block_pinched'), least_N: 0.4, from: 4400 },
  scene_cloth_held_by_two: {
    scene: 'cloth_held_by_two', hands: two_hands('cloth_held_by_two'), least_N: 0.02, from: 2500 },
  scene_wall: { scene: 'wall', device: 'phantom:profile=premium15,path=tap', least_N: 1.0, from: 30 },
};

/// Those that --only asks for.
function names_of(only) {
  const names = Object.keys(kPictures);
  if (only === 'pages') return names.filter((name) => kPictures[name].page);
  if (only === 'scenes') return names.filter((name) => !kPictures[name].page);
  if (only !== undefined && !names.includes(only)) {
    throw new Error(`--only: value ${only}: expected pages, scenes, ${names.join(', ')}`);
  }
  return only === undefined ? names : [only];
}

function parse() {
  const text = { type: 'string' };
  const { values } = parseArgs({ options: { charts: text, only: text, scene: text, out: text, device: text,
    'after-s': text, help: { type: 'boolean', short: 'h' } } });
  if (values.help) {
    console.log(kUsage);
    process.exit(0);
  }
  if (!values.scene !== !values.out) throw new Error('--scene, --out: expected both, or none of them');
  for (const name of values.scene ? ['charts', 'only'] : ['device', 'after-s']) {
    if (values[name] !== undefined) throw new Error(`--${name}: expected ${values.scene ? 'no' : 'a'} --scene with it`);
  }
  const after_s = Number(values['after-s'] ?? 2);
  if (!(after_s > 0 && after_s < 3600)) throw new Error(`--after-s: value ${values['after-s']}: expected seconds`);
  if (values.scene && !fs.existsSync(values.scene)) throw new Error(`--scene: ${values.scene}: no such file`);
  return { ...values, after_s };
}

async function start_viewer(session, { scene, hands }) {
  const surfaces = await session.surfaces(scene);
  const { url } = await session.scene_viewer('--session', session.name, '--surfaces', surfaces,
    ...hands ? ['--hand', 'left'] : []);
  return url;
}

function start_servers(session, { scene, device, hands }) {
  session.sim_server(scene);
  if (device) session.haptic_server(device);
  for (const [hand, own] of Object.entries(hands ?? {})) session.haptic_server(own, '--hand', hand);
}

/// What the button "Picture" would keep.
async function picture_of_scene(page) {
  await page.evaluate(() => {
    URL.createObjectURL = (blob) => { window.kept = blob; return 'blob:kept'; };
    HTMLAnchorElement.prototype.click = () => {};
  });
  await page.locator('#picture').click();
  await page.waitForFunction(() => window.kept);
  return Buffer.from(await page.evaluate(async () => [...new Uint8Array(await window.kept.arrayBuffer())]));
}

/// With so few colours as a picture of flat bodies needs.
function write_small(png, file) {
  const whole = path.join(fs.mkdtempSync(path.join(os.tmpdir(), 'stillgrid-picture-')), 'whole.png');
  try {
    fs.writeFileSync(whole, png);
    const shrink = fileURLToPath(new URL('shrink_png.py', import.meta.url));
    const { status, stderr } = spawnSync(shrink, [whole, file, '--max-bytes', kMaxBytes], { encoding: 'utf8' });
    if (status !== 0) throw new Error(stderr.trim() || `${shrink}: exit status ${status}`);
  } finally {
    fs.rmSync(path.dirname(whole), { recursive: true });
  }
  console.log(`picture: ${file}`);
}

async function draw(picture, file) {
  const { least_N, from = 0, after_s = 0, page: is_page, pixels = [1280, 720], theme = 'light' } = picture;
  const session = new Session();
  let browser;
  try {
    const url = await start_viewer(session, picture);
    const opened = await open_browser(kBuild, ...pixels, { colorScheme: theme });
    ({ browser } = opened);
    const { page } = opened;
    page.setDefaultTimeout(120000);
    await page.goto(url);
    start_servers(session, picture);  // once it is looked at: what comes first is soon over
    const above = (id, least) => page.waitForFunction(([where, what]) =>
      Number(document.getElementById(where).textContent) > what, [id, least], { polling: 20 });
    await above('number-snapshot_id', from);
    await page.waitForTimeout(1000 * after_s);
    if (least_N) await above('number-force', least_N);
    await page.keyboard.press(' ');
    await page.mouse.move(pixels[0] / 2, pixels[1] - 20);
    if (!is_page) {
      await page.evaluate(([width, height]) => Object.assign(document.getElementById('view').style, {
        position: 'fixed', left: 0, top: 0, width: `${width}px`, height: `${height}px` }), kScenePixels);
    }
    await page.waitForTimeout(1500);  // ticks and plots of this frame
    write_small(is_page ? await page.screenshot() : await picture_of_scene(page), file);
  } finally {
    await browser?.close();
    await session.end();
  }
}

need_browser('chromium');
try {
  const { charts = path.join(kRoot, 'docs', 'charts'), only, scene, out, device, after_s } = parse();
  if (scene) await draw({ scene: path.resolve(scene), device, after_s }, out);
  else for (const name of names_of(only)) await draw(kPictures[name], path.join(charts, `${name}.png`));
} catch (error) {
  console.error(`plot_viewer: ${error.message.split('\n')[0]}`);
  process.exit(1);
}
