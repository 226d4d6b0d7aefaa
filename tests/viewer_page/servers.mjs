// Starts Stillgrid's programs for a script, and leaves none behind.
import { spawn } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import readline from 'node:readline';
import { fileURLToPath } from 'node:url';

export const kRoot = fileURLToPath(new URL('../..', import.meta.url));
export const kBuild = process.env.STILLGRID_BUILD_DIR ?? path.join(kRoot, 'build', 'release');
const kMemory = `/dev/shm/stillgrid-${process.geteuid()}`;

/// A session of its own, and a folder for what is written.
export class Session {
  name = `page-${process.pid}`;
  folder = fs.mkdtempSync(path.join(os.tmpdir(), 'stillgrid-page-'));
  #running = new Set();

  /// What a user would do with a line that the page tells.
  shell(line) {
    return this.#run('sh', '-c', `exec ${line}`);
  }

  #start(program, ...options) {
    return this.#run(path.join(kBuild, 'bin', program), ...options);
  }

  #run(...words) {
    // pdeathsig: a script that is killed takes them along.
    const child = spawn('setpriv', ['--pdeathsig', 'KILL', ...words],
      { stdio: ['ignore', 'pipe', 'pipe'] });
    child.said = '';
    child.stderr.on('data', (data) => { child.said += data; });
    child.ended = new Promise((resolve) => child.on('exit', resolve));
    this.#running.add(child);
    child.ended.then(() => this.#running.delete(child));
    return child;
  }

  /// Ends the child that does the work, which its guardian outlives.
  kill_worker(daemon) {
    const children = fs.readFileSync(`/proc/${daemon.pid}/task/${daemon.pid}/children`, 'utf8');
    process.kill(Number(children.trim().split(' ')[0]), 'SIGKILL');
  }

  /// Writes into a server's segment what a relay would tell of it there (docs/protocol.md): of the
  /// names given, the others being 0.
  set_relay_figures(kind, figures) {
    const kNames = ['relay_id', 'connected', 'clock_offset_ns', 'clock_bound_ns', 'round_trip_ns', 'received',
      'received_bytes', 'lost'];
    const kRelay = 128, kBytes = 128;
    const bytes = Buffer.alloc(kBytes);
    for (const [name, value] of Object.entries({ relay_id: 1n, ...figures })) {
      bytes.writeBigInt64LE(value, 8 * kNames.indexOf(name));
    }
    const file = fs.openSync(path.join(kMemory, `${this.name}-${kind}`), 'r+');
    fs.writeSync(file, bytes, 0, kBytes, kRelay);
    fs.closeSync(file);
  }

  /// Of a scene that ships, of a file in the session's folder, or of one by its whole path.
  scene_file(scene) {
    if (path.isAbsolute(scene)) return scene;
    const own = path.join(this.folder, `${scene}.toml`);
    return fs.existsSync(own) ? own : path.join(kRoot, 'sim_server', 'scene', 'scenes', `${scene}.toml`);
  }

  sim_server(scene) {
    return this.#start('sim_server', '--scene', this.scene_file(scene), '--session', this.name);
  }

  haptic_server(device, ...more) {
    return this.#start('haptic_server', '--session', this.name, '--device', device, ...more);
  }

  /// A scene's surfaces, for scene_viewer.
  async surfaces(scene) {
    const file = path.join(this.folder, `${path.basename(scene, '.toml')}.json`);
    const child = this.#start('sim_server', '--scene', this.scene_file(scene), '--surfaces', file);
    if (await child.ended !== 0) throw new Error(child.said);
    return file;
  }

  /// { child, url } once its page is served.
  async scene_viewer(...options) {
    const child = this.#start('scene_viewer', '--port', '0', ...options);
    const lines = readline.createInterface({ input: child.stdout });
    const url = await new Promise((resolve, reject) => {
      lines.once('line', resolve);
      child.ended.then(() => reject(new Error(child.said)));
    });
    return { child, url };
  }

  /// As Ctrl-C does, each.
  async interrupt(...children) {
    for (const child of children) child.kill('SIGINT');
    await Promise.all(children.map((child) => child.ended));
  }

  async end() {
    const left = [...this.#running];
    for (const child of left) child.kill('SIGKILL');
    await Promise.all(left.map((child) => child.ended));
    fs.rmSync(this.folder, { recursive: true });
    for (const file of fs.existsSync(kMemory) ? fs.readdirSync(kMemory) : []) {
      if (['-', '+'].some((mark) => file.startsWith(this.name + mark))) fs.rmSync(path.join(kMemory, file));
    }
  }
}

/// A light hand that presses into tissue_and_blocks again and again, beside the middle, where the tissue pushes aside too.
export const kHand = 'phantom:profile=premium15,hand=light,path=press,centre_y_m=0.02,centre_z_m=0,depth_m=0.06,' +
  'period_s=2,gripper_m=0.04,grip_N=1';
