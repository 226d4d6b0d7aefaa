// The picture: bodies as spheres or surfaces, both snapshots and the displayed one, planes, voxels, tool.
import * as THREE from 'three';
import { Camera } from './camera.js';
import { body_colour } from './palette.js';
import { make_planes } from './planes.js';
import { round_up } from './plot_canvas.js';
import { SphereSet } from './sphere_set.js';
import { Surfaces } from './surfaces.js';
import { tool_centres, ToolView } from './tool_view.js';
import { VoxelBoxes } from './voxel_boxes.js';

export const kGhostColours = { newest: '#57c7ff', previous: '#ff9d5c' };

/// The smallest box round points, as its middle and its diagonal.
function extent(points_m) {
  const box = new THREE.Box3();
  const point = new THREE.Vector3();
  for (let i = 0; i + 2 < points_m.length; i += 3) {
    point.fromArray(points_m, i);
    if (Number.isFinite(point.x + point.y + point.z)) box.expandByPoint(point);
  }
  const size_m = box.isEmpty() ? 0 : box.getSize(new THREE.Vector3()).length();
  return { centre_m: box.isEmpty() ? new THREE.Vector3() : box.getCenter(new THREE.Vector3()),
    size_m: Math.max(size_m, 0.1) };
}

export class SceneView {
  scales = {};  // of the legend
  spheres_shown = 0;

  /// switches: which parts are shown, by name.
  constructor(canvas, switches) {
    this.canvas = canvas;
    this.switches = switches;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.world = new THREE.Scene();
    this.world.background = new THREE.Color('#0e1216');
    const sun = new THREE.DirectionalLight('#ffffff', 2.1);
    sun.position.set(0.6, -1, 2);
    this.world.add(new THREE.HemisphereLight('#dfe9f5', '#39404a', 1.5), sun);
    this.camera = new Camera(canvas, () => { this.dirty = true; });
    this.content = new THREE.Group();
    this.world.add(this.content);
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
    this.#resize();
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    this.renderer.setSize(width, height, false);
    this.camera.resize(width, height);
    this.dirty = true;
  }

  /// scene: of /api/scene. around_m: points that are to be seen at first, beside the tool, if any.
  set_scene(scene, around_m, tool) {
    this.world.remove(this.content);
    this.content.traverse((object) => {
      object.geometry?.dispose();
      object.material?.dispose();
    });
    this.content = new THREE.Group();
    this.world.add(this.content);

    const { radius_m, body, count: moving, static_position_m: static_m } = scene.spheres;
    const moving_m = radius_m.slice(0, moving);
    // Surfaces of another scene, or of one whose spheres have not come yet, fit no numbers.
    const skins = scene.surfaces?.spheres === radius_m.length ? scene.surfaces.bodies : [];
    const still_m = skins.flatMap(({ vertices }) => vertices.flatMap((vertex) => vertex.still_m ?? []));
    const { centre_m, size_m } = extent([
      ...around_m, ...static_m, ...still_m, ...tool?.position_m ?? [],
      ...tool ? tool_centres(scene.tool_spheres, tool) : []]);
    this.solid = new SphereSet(moving_m);
    this.solid.colour((i) => body_colour(body[i]));
    this.static_spheres = new SphereSet(radius_m.slice(moving));
    this.static_spheres.colour((i) => body_colour(body[moving + i]));
    Object.assign(this, { body, static_body: body.slice(moving), static_place_m: static_m,
      static_voxels: scene.static_voxels });
    this.ghosts = {};
    for (const [name, colour] of Object.entries(kGhostColours)) {
      this.ghosts[name] = new SphereSet(moving_m, { ghost: true, colour });
    }
    this.surfaces = new Surfaces(skins, static_m);
    this.voxels = new VoxelBoxes();
    this.tool = new ToolView(scene.tool_spheres, size_m);
    this.tool.metres_per_N = round_up(size_m / 25);
    this.others = new Map();  // by the name of the hand
    this.size_m = size_m;
    const planes = make_planes(scene.planes, centre_m, size_m);
    this.planes = planes.group;
    this.scales = { metres_per_N: this.tool.metres_per_N,
      cell_m: scene.planes.length ? planes.cell_m : null };
    this.content.add(this.solid.mesh, this.static_spheres.mesh, this.ghosts.newest.mesh, this.ghosts.previous.mesh,
      this.surfaces.object, this.voxels.object, this.tool.object, this.planes);
    // The same scene once more, of a simulation that was started again: who looks at it goes on so.
    const known = `${scene.name} ${radius_m.length}`;
    if (known !== this.known) this.camera.home(centre_m, size_m);
    this.known = known;
    this.dirty = true;
  }

  /// frame: of /api/frame. ticks: a TickHistory whose ticks begin .. end are the tool's path.
  place(frame, ticks, begin, end) {
    const { switches } = this;
    const { newest = [], previous = [], displayed = [], voxels, voxel_count } = frame.arrays;
    // Without a hand nothing is displayed: then the newest snapshot is what there is.
    const shown = displayed.length ? displayed : newest;
    // As surfaces: bodies that have none are spheres there, too.
    const hides = (body) => !switches.spheres && (!switches.surfaces || this.surfaces.skinned.has(body));
    this.spheres_shown = this.static_spheres.place(this.static_place_m, (i) => hides(this.static_body[i])) +
      this.solid.place(shown, (i) => !switches.displayed || hides(this.body[i]));
    const is_skinned = switches.surfaces && switches.displayed;
    this.surfaces.show(is_skinned);
    if (is_skinned && shown.length) this.surfaces.place(shown);
    for (const [name, centres] of [['newest', newest], ['previous', previous]]) {
      this.ghosts[name].mesh.visible = switches[name];
      if (switches[name]) this.ghosts[name].place(centres);
    }
    this.voxels.object.visible = switches.voxels;
    if (switches.voxels) {
      this.voxels.place([{ box_m: voxels, count: voxel_count }, this.static_voxels], switches.voxel_edge_m);
    }
    this.planes.visible = switches.planes;
    this.tool.object.visible = Boolean(frame.tool);
    if (frame.tool) {
      this.tool.place(frame.tool);
      this.tool.path.visible = switches.path;
      if (switches.path) this.tool.place_path(ticks.columns.position_m, begin, end);
      this.camera.tool_at(frame.tool.position_m);
    }
    this.#place_others(frame.others ?? []);
    this.dirty = true;
  }

  /// The tools of the session's other hands, each with its force.
  #place_others(others) {
    for (const other of this.others.values()) other.object.visible = false;
    for (const { name, tool, tool_spheres } of others) {
      if (!this.others.has(name)) {
        const view = new ToolView(tool_spheres, this.size_m);
        view.metres_per_N = this.tool.metres_per_N;
        view.path.visible = false;
        this.others.set(name, view);
        this.content.add(view.object);
      }
      this.others.get(name).object.visible = true;
      this.others.get(name).place(tool);
    }
  }

  render() {
    if (!this.dirty) return;
    this.dirty = false;
    this.renderer.render(this.world, this.camera.camera);
  }
}
