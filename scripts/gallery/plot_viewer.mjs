#!/usr/bin/env node
// Pictures of the viewer's page, both servers in real time behind it.
import path from 'node:path';
import { need_browser, open_browser } from '../../tests/viewer_page/browser.mjs';
import { kBuild, kHand, kRoot, Session } from '../../tests/viewer_page/servers.mjs';

const kUsage = `scripts/gallery/plot_viewer.mjs [--charts FOLDER] [--only NAME]

Starts both servers on a scene in real time with a simulated hand, opens the viewer's page in Debian's
Chromium, waits until the hand presses, and writes a picture of 1280 x 720 pixels. Half a minute each.
  --charts FOLDER   where to; default: docs/charts
  --only NAME       viewer (tissue_and_blocks), or viewer_ and another shipped scene; default: all
Environment: STILLGRID_BUILD_DIR, default build/release.`;

/// Where each hand of a scene for two goes.
const two_hands = (scene) => Object.fromEntries(['left', 'right'].map((name) => [
  name, `phantom:profile=touchx,path=${kRoot}/sim_server/scene/scenes/${scene}.${name}.csv`]));

/// least_N: so hard the hand presses in the picture, of snapshot 400 at least, or of `from`. keys: pressed before it
/// is taken.
const kPictures = {
  viewer: { scene: 'tissue_and_blocks', device: kHand, least_N: 1.2, keys: [] },
  viewer_block_pinched: {
    scene: 'block_pinched', hands: two_hands('block_pinched'), least_N: 0.4, from: 1100, keys: [] },
  viewer_cloth_held_by_two: {
    scene: 'cloth_held_by_two', hands: two_hands('cloth_held_by_two'), least_N: 0.02, from: 1100, keys: [] },
  viewer_laparoscopy: {
    scene: 'laparoscopy', device: 'phantom:profile=premium15,path=stroke,depth_m=0.03,pivot_x_m=0,pivot_y_m=0,pivot_z_m=-0.11',
    least_N: 0.9, keys: ['s', 'm'] },
  viewer_pillars: {
    scene: 'pillars', device: 'phantom:profile=premium15,hand=light,path=press,centre_z_m=-0.03,depth_m=0.03,period_s=2',
    least_N: 0.5, keys: [] },
  viewer_threads: {
    scene: 'threads', device: 'phantom:profile=premium15,path=circle,centre_z_m=0,depth_m=0', least_N: 0.1, keys: [] },
  viewer_wall: { scene: 'wall', device: 'phantom:profile=premium15,path=tap', least_N: 1.0, keys: [] },
};

function parse(words) {
  const options = { charts: path.join(kRoot, 'docs', 'charts'), names: Object.keys(kPictures) };
  while (words.length > 0) {
    const [option, value] = words.splice(0, 2);
    if (option === '-h' || option === '--help') {
      console.log(kUsage);
      process.exit(0);
    }
    if (option === '--charts' && value) options.charts = value;
    else if (option === '--only' && value in kPictures) options.names = [value];
    else throw new Error(`${option} ${value ?? ''}: see --help`);
  }
  return options;
}

async function draw(name, charts) {
  const { scene, device, hands, least_N, from = 400, keys } = kPictures[name];
  const session = new Session();
  let browser;
  try {
    const surfaces = await session.surfaces(scene);
    const { url } = await session.scene_viewer('--session', session.name, '--surfaces', surfaces,
      ...hands ? ['--hand', 'left'] : []);
    const opened = await open_browser(kBuild, 1280, 720);
    ({ browser } = opened);
    const { page } = opened;
    page.setDefaultTimeout(120000);
    session.sim_server(scene);
    if (!hands) session.haptic_server(device);
    for (const [hand, own] of Object.entries(hands ?? {})) session.haptic_server(own, '--hand', hand);
    await page.goto(url);
    for (const key of keys) await page.keyboard.press(key);
    const above = (id, least) => page.waitForFunction(([where, what]) =>
      Number(document.getElementById(where).textContent) > what, [id, least], { polling: 20 });
    await above('number-snapshot_id', from);  // the plots are full
    await above('number-force', least_N);
    await page.keyboard.press(' ');
    await page.mouse.move(640, 700);
    await page.waitForTimeout(1000);  // ticks and plots of this frame
    const file = path.join(charts, `${name}.png`);
    await page.screenshot({ path: file });
    console.log(`picture: ${file}`);
  } finally {
    await browser?.close();
    await session.end();
  }
}

need_browser('chromium');
try {
  const { charts, names } = parse(process.argv.slice(2));
  for (const name of names) await draw(name, charts);
} catch (error) {
  console.error(`plot_viewer: ${error.message.split('\n')[0]}`);
  process.exit(1);
}
