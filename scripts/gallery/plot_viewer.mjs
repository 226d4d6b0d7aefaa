#!/usr/bin/env node
// Pictures of the viewer's page, both servers in real time behind it.
import path from 'node:path';
import { need_chromium, open_browser } from '../../tests/viewer_page/browser.mjs';
import { kBuild, kHand, kRoot, Session } from '../../tests/viewer_page/servers.mjs';

const kUsage = `scripts/gallery/plot_viewer.mjs [--charts FOLDER] [--only NAME]

Starts both servers on a scene in real time with a simulated hand, opens the viewer's page in Debian's
Chromium, waits until the hand presses, and writes a picture of 1280 x 720 pixels. Half a minute each.
  --charts FOLDER   where to; default: docs/charts
  --only NAME       viewer (tissue_and_blocks), or viewer_ and another shipped scene; default: all
Environment: STILLGRID_BUILD_DIR, default build/release.`;

/// least_N: so hard the hand presses in the picture. keys: pressed before it is taken.
const kPictures = {
  viewer: { scene: 'tissue_and_blocks', device: kHand, least_N: 1.2, keys: [] },
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
  const { scene, device, least_N, keys } = kPictures[name];
  const session = new Session();
  let browser;
  try {
    const surfaces = await session.surfaces(scene);
    const { url } = await session.scene_viewer('--session', session.name, '--surfaces', surfaces);
    const opened = await open_browser(kBuild, 1280, 720);
    ({ browser } = opened);
    const { page } = opened;
    page.setDefaultTimeout(120000);
    session.sim_server(scene);
    session.haptic_server(device);
    await page.goto(url);
    for (const key of keys) await page.keyboard.press(key);
    const above = (id, least) => page.waitForFunction(([where, what]) =>
      Number(document.getElementById(where).textContent) > what, [id, least], { polling: 20 });
    await above('number-snapshot_id', 400);  // the plots are full
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

need_chromium();
try {
  const { charts, names } = parse(process.argv.slice(2));
  for (const name of names) await draw(name, charts);
} catch (error) {
  console.error(`plot_viewer: ${error.message.split('\n')[0]}`);
  process.exit(1);
}
