// The picture: bodies as surfaces or spheres, both snapshots and the displayed one, planes, axes, voxels, tools.
import * as THREE from 'three';
import { make_axes } from './axes.js';
import { Camera } from './camera.js';
import { hand_names, parts_of } from './hands.js';
import { body_colour } from './palette.js';
import { fit_label } from './labels.js';
import { make_planes } from './planes.js';
import { round_up } from './plot_canvas.js';
import { SphereSet } from './sphere_set.js';
import { Surfaces } from './surfaces.js';
import { tool_centres, ToolView } from './tool_view.js';
import { VoxelBoxes } from './voxel_boxes.js';

/// The smallest box round points, with its middle and its diagonal.
function extent(points_m) {
  const box = new THREE.Box3();
  const point = new THREE.Vector3();
  for (let i = 0; i + 2 < points_m.length; i += 3) {
    point.fromArray(points_m, i);
    if (Number.isFinite(point.x + point.y + point.z)) box.expandByPoint(point);
  }
  const size_m = box.isEmpty() ? 0 : box.getSize(new THREE.Vector3()).length();
  if (box.isEmpty()) box.expandByPoint(new THREE.Vector3());
  return { box, centre_m: box.getCenter(new THREE.Vector3()), size_m: Math.max(size_m, 0.1) };
}

export class SceneView {
  scales = {};  // of the legend
  spheres_shown = 0;

  /// switches: which parts are shown, by name. theme: a Theme.
  constructor(canvas, switches, theme) {
    this.canvas = canvas;
    this.switches = switches;
    this.theme = theme;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.world = new THREE.Scene();
    const sun = new THREE.DirectionalLight('#ffffff', 2.1);
    sun.position.set(0.6, -1, 2);
    this.daylight = new THREE.HemisphereLight('#ffffff', '#ffffff', 1.5);
    this.world.add(this.daylight, sun);
    this.raycaster = new THREE.Raycaster();
    this.camera = new Camera(canvas, () => { this.dirty = true; });
    this.content = new THREE.Group();
    this.world.add(this.content);
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
    this.#resize();
    this.#take_colours();
  }

  #take_colours() {
    const { picture } = this.theme.colours;
    this.world.background = new THREE.Color(picture.ground);
    this.daylight.color.set(picture.sky);
    this.daylight.groundColor.set(picture.earth);
    this.dirty = true;
  }

  /// The theme has others now.
  recolour() {
    this.#take_colours();
    if (this.shown) this.set_scene(...this.shown);
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    this.renderer.setSize(width, height, false);
    this.camera.resize(width, height);
    this.dirty = true;
  }

  /// scene: of /api/scene. around_m: points that are to be seen at first, beside the tool, if any.
  set_scene(scene, around_m, tool) {
    this.shown = [scene, around_m, tool];
    const colours = this.theme.colours;
    this.#empty();

    const { radius_m, body, count: moving, static_position_m: static_m } = scene.spheres;
    const moving_m = radius_m.slice(0, moving);
    // Surfaces of another scene, or of one whose spheres have not come yet, fit no numbers.
    const skins = scene.surfaces?.spheres === radius_m.length ? scene.surfaces.bodies : [];
    const still_m = skins.flatMap(({ vertices }) => vertices.flatMap((vertex) => vertex.still_m ?? []));
    const { box, centre_m, size_m } = extent([
      ...around_m, ...static_m, ...still_m, ...tool?.position_m ?? [],
      ...tool ? tool_centres(scene.tool_spheres, tool) : []]);
    this.solid = new SphereSet(moving_m);
    this.solid.colour((i) => body_colour(body[i]));
    this.static_spheres = new SphereSet(radius_m.slice(moving));
    this.static_spheres.colour((i) => body_colour(body[moving + i]));
    Object.assign(this, { body, static_body: body.slice(moving), static_place_m: static_m,
      static_voxels: scene.static_voxels });
    this.ghosts = {};
    for (const name of ['newest', 'previous']) {
      this.ghosts[name] = new SphereSet(moving_m, { ghost: true, colour: colours.picture[name] });
    }
    this.surfaces = new Surfaces(skins, static_m);
    this.voxels = new VoxelBoxes();
    this.hand = parts_of(scene.session).hand;
    this.tool = new ToolView(scene.tool_spheres, size_m, colours.picture);
    this.tool.metres_per_N = round_up(size_m / 25);
    this.others = new Map();  // by the name of the hand
    this.size_m = size_m;
    const planes = make_planes(scene.planes, centre_m, size_m, colours.picture);
    this.planes = planes.group;
    this.axes = make_axes(box.min.toArray(), box.max.toArray(), colours);
    this.scales = { metres_per_N: this.tool.metres_per_N,
      cell_m: scene.planes.length ? planes.cell_m : null };
    this.content.add(this.solid.mesh, this.static_spheres.mesh, this.ghosts.newest.mesh, this.ghosts.previous.mesh,
      this.surfaces.object, this.voxels.object, this.tool.object, this.planes, this.axes);
    // The same scene once more, of a simulation that was started again: who looks at it goes on so.
    const known = `${scene.name} ${radius_m.length}`;
    if (known !== this.known) this.camera.home(centre_m, size_m);
    this.known = known;
    this.dirty = true;
  }

  /// Away with what was shown.
  #empty() {
    this.world.remove(this.content);
    this.content.traverse((object) => {
      object.geometry?.dispose();
      object.material?.map?.dispose();
      object.material?.dispose();
    });
    this.content = new THREE.Group();
    this.world.add(this.content);
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
    this.axes.visible = switches.axes;
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

  /// Where a mouse draws the tool, or null.
  show_aim(aim_m) {
    this.tool?.place_aim(aim_m);
    this.dirty = true;
  }

  /// The tools of the session's other hands, each with its force.
  #place_others(others) {
    for (const other of this.others.values()) other.object.visible = false;
    const names = hand_names(this.hand, others);
    this.tool.set_hand(names.length > 1 ? this.hand : '', Math.max(names.indexOf(this.hand), 0));
    for (const { name, tool, tool_spheres } of others) {
      if (!this.others.has(name)) {
        const view = new ToolView(tool_spheres, this.size_m, this.theme.colours.picture);
        view.metres_per_N = this.tool.metres_per_N;
        view.path.visible = false;
        this.others.set(name, view);
        this.content.add(view.object);
      }
      this.others.get(name).object.visible = true;
      this.others.get(name).set_hand(name, names.indexOf(name));
      this.others.get(name).place(tool);
    }
  }

  /// What is seen at a place of the picture, -1 to 1 to the right and up: { hand } or { body }, or null.
  pick(x, y) {
    if (!this.tool) return null;
    this.raycaster.setFromCamera(new THREE.Vector2(x, y), this.camera.camera);
    const { ray } = this.raycaster;
    // A tool is seen through whatever lies in front.
    for (const [hand, view] of [[this.hand, this.tool], ...this.others]) {
      if (view.object.visible && view.spheres.nearest(ray)) return { hand };
    }
    const found = [[this.solid, this.body], [this.static_spheres, this.static_body]].flatMap(([set, bodies]) => {
      const hit = set.nearest(ray);
      return hit ? [{ body: bodies[hit.index], distance_m: hit.distance_m }] : [];
    });
    const objects = this.surfaces.object.children.filter((object) => object.visible && object.isMesh);
    if (this.planes.visible) this.planes.traverse((object) => { if (object.isMesh) objects.push(object); });
    for (const { object, distance } of this.raycaster.intersectObjects(objects, false).slice(0, 1)) {
      found.push({ body: object.userData.body, distance_m: distance });
    }
    found.sort((a, b) => a.distance_m - b.distance_m);
    return found.length ? { body: found[0].body } : null;
  }

  /// is_asked: also where nothing has changed, for who reads the canvas next.
  render(is_asked = false) {
    if (!this.dirty && !is_asked) return;
    this.dirty = false;
    const { clientHeight: height } = this.canvas;
    this.content.traverse((object) => { if (object.isSprite) fit_label(object, height); });
    this.renderer.render(this.world, this.camera.camera);
  }
}
