// Publishes a MuJoCo model, so that a hand feels its bodies at 1 kHz.
//
//   publish_mujoco MODEL.xml SESSION [--lockstep]
//
// Beside it: haptic_server --session SESSION --device ..., with --lockstep if this has it.
#include <mujoco/mujoco.h>
#include <stillgrid/stillgrid.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace {

constexpr double kNear_m = 0.15;  // bodies so near the tool may be touched in two periods
constexpr std::uint32_t kMaxPushes = 64;

void require(int code, const char* what) {
  if (code >= 0) return;
  std::fprintf(stderr, "publish_mujoco: %s: %s\n", what, stillgrid_last_error());
  std::exit(2);
}

/// The model as spheres, in the frames of its bodies.
struct Spheres {
  std::vector<double> local_m, radii_m;
  std::vector<std::uint32_t> bodies;

  void add(std::uint32_t body, const double* centre_m, double radius_m) {
    local_m.insert(local_m.end(), centre_m, centre_m + 3);
    radii_m.push_back(radius_m);
    bodies.push_back(body);
  }
  [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(bodies.size()); }
};

/// Spheres of one radius on a lattice that touches all sides of a box, no farther apart than the
/// radius. A capsule is such a box, which is as long as its axis.
void fill_box(const mjModel* m, int geom, const double half_m[3], double radius_m, Spheres& out) {
  int counts[3];
  for (int a = 0; a < 3; ++a)
    counts[a] = 1 + static_cast<int>(std::ceil(2.0 * (half_m[a] - radius_m) / radius_m - 1e-9));
  for (int x = 0; x < counts[0]; ++x)
    for (int y = 0; y < counts[1]; ++y)
      for (int z = 0; z < counts[2]; ++z) {
        const int at[3] = {x, y, z};
        double in_geom_m[3], in_body_m[3];
        for (int a = 0; a < 3; ++a)
          in_geom_m[a] = counts[a] == 1
                             ? 0.0
                             : (half_m[a] - radius_m) * (2.0 * at[a] / (counts[a] - 1.0) - 1.0);
        mju_rotVecQuat(in_body_m, in_geom_m, m->geom_quat + 4 * geom);
        mju_addTo3(in_body_m, m->geom_pos + 3 * geom);
        out.add(static_cast<std::uint32_t>(m->geom_bodyid[geom]), in_body_m, radius_m);
      }
}

Spheres spheres_of(const mjModel* m) {
  Spheres out;
  for (int geom = 0; geom < m->ngeom; ++geom) {
    const double* size_m = m->geom_size + 3 * geom;
    switch (m->geom_type[geom]) {
      case mjGEOM_PLANE:
        break;
      case mjGEOM_SPHERE:
        out.add(static_cast<std::uint32_t>(m->geom_bodyid[geom]), m->geom_pos + 3 * geom,
                size_m[0]);
        break;
      case mjGEOM_CAPSULE: {
        const double half_m[3] = {size_m[0], size_m[0], size_m[0] + size_m[1]};
        fill_box(m, geom, half_m, size_m[0], out);
        break;
      }
      case mjGEOM_BOX:
        fill_box(m, geom, size_m, std::min({size_m[0], size_m[1], size_m[2]}), out);
        break;
      default:
        std::fprintf(stderr, "publish_mujoco: geom %d is no sphere, capsule, box or plane\n", geom);
        std::exit(1);
    }
  }
  return out;
}

std::vector<stillgrid_plane> planes_of(const mjModel* m, const mjData* d) {
  std::vector<stillgrid_plane> out;
  for (int geom = 0; geom < m->ngeom; ++geom) {
    if (m->geom_type[geom] != mjGEOM_PLANE) continue;
    const double* turn = d->geom_xmat + 9 * geom;
    stillgrid_plane plane{
        {turn[2], turn[5], turn[8]}, 0.0, 0, static_cast<std::uint32_t>(m->geom_bodyid[geom])};
    plane.offset_m = mju_dot3(plane.normal, d->geom_xpos + 3 * geom);
    out.push_back(plane);
  }
  return out;
}

/// A number of the model's <custom>, or what stands for it.
std::vector<double> custom(const mjModel* m, const char* name, std::vector<double> otherwise) {
  const int id = mj_name2id(m, mjOBJ_NUMERIC, name);
  if (id < 0) return otherwise;
  const double* first = m->numeric_data + m->numeric_adr[id];
  std::copy_n(first, std::min<std::size_t>(otherwise.size(), m->numeric_size[id]),
              otherwise.begin());
  return otherwise;
}

class Simulation {
 public:
  explicit Simulation(const mjModel* model)
      : m_(model),
        d_(mj_makeData(model)),
        spheres_(spheres_of(model)),
        steps_(std::max(
            1, static_cast<int>(std::lround(custom(model, "stillgrid_period_s", {0.033})[0] /
                                            model->opt.timestep)))) {
    mj_forward(m_, d_);
    positions_m_.resize(spheres_.local_m.size());
    velocities_m_s_ = positions_m_;
  }
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;
  ~Simulation() { mj_deleteData(d_); }

  void open(const char* session, bool is_lockstep) {
    const std::vector<double> numbers = custom(m_, "stillgrid_material", {500.0, 1.0, 0.3});
    const stillgrid_material material{numbers[0], numbers[1], numbers[2]};
    const std::vector<stillgrid_plane> planes = planes_of(m_, d_);
    stillgrid_scene scene{};
    scene.struct_size = sizeof scene;
    scene.clock = is_lockstep ? STILLGRID_VIRTUAL_TIME : STILLGRID_REAL_TIME;
    scene.session = session;
    scene.name = m_->names;  // the first of them is the model's
    scene.period_s = period_s();
    scene.sphere_capacity = spheres_.count();
    scene.gives_inertia = 1;
    scene.material_count = 1;
    scene.materials = &material;
    scene.plane_count = static_cast<std::uint32_t>(planes.size());
    scene.planes = planes.data();
    require(stillgrid_publisher_open(&scene, &publisher_), "open");
    stillgrid_shapes shapes{};
    shapes.struct_size = sizeof shapes;
    shapes.count = spheres_.count();
    shapes.radii_m = spheres_.radii_m.data();
    shapes.bodies = spheres_.bodies.data();
    require(stillgrid_publisher_set_shapes(publisher_, &shapes), "set_shapes");
  }

  /// One period after another, until the haptic_server of a run in virtual time ends.
  void run() {
    mj_step1(m_, d_);
    show_state();
    for (std::uint64_t time_ns = 0;;) {
      const int code = stillgrid_publisher_wait(publisher_, &time_ns);
      require(code, "wait");
      if (code == STILLGRID_AGAIN) continue;
      if (code == STILLGRID_NOTHING) break;
      for (int i = 0; i < steps_; ++i) {
        apply_pushes();
        mj_step2(m_, d_);
        mj_step1(m_, d_);  // what follows from the state
        show_state();
      }
      require(stillgrid_publisher_publish(publisher_, time_ns), "publish");
    }
    stillgrid_publisher_close(publisher_);
  }

 private:
  [[nodiscard]] double period_s() const { return steps_ * m_->opt.timestep; }

  void place(std::vector<double>& positions_m) const {
    for (std::uint32_t i = 0; i < spheres_.count(); ++i) {
      const std::uint32_t body = spheres_.bodies[i];
      double* position_m = positions_m.data() + 3 * i;
      mju_rotVecMat(position_m, spheres_.local_m.data() + 3 * i, d_->xmat + 9 * body);
      mju_addTo3(position_m, d_->xpos + 3 * body);
    }
  }

  void show_state() {
    place(positions_m_);
    for (std::uint32_t i = 0; i < spheres_.count(); ++i) {
      const auto body = static_cast<int>(spheres_.bodies[i]);
      double turn_move[6], arm_m[3];
      mj_objectVelocity(m_, d_, mjOBJ_XBODY, body, turn_move, 0);
      mju_sub3(arm_m, positions_m_.data() + 3 * i, d_->xpos + 3 * body);
      mju_cross(velocities_m_s_.data() + 3 * i, turn_move, arm_m);
      mju_addTo3(velocities_m_s_.data() + 3 * i, turn_move + 3);
    }
    require(stillgrid_publisher_set_spheres(publisher_, spheres_.count(), positions_m_.data(),
                                            velocities_m_s_.data()),
            "set_spheres");
    tell_responses();
  }

  /// The bodies near the tool, of those that can move.
  [[nodiscard]] std::vector<int> near_tool() {
    std::vector<int> bodies;
    stillgrid_tool tool{};
    tool.struct_size = sizeof tool;
    const int code = stillgrid_publisher_tool(publisher_, 0, &tool);
    require(code, "tool");
    if (code == STILLGRID_NOTHING) return bodies;
    for (std::uint32_t i = 0; i < spheres_.count(); ++i) {
      const auto body = static_cast<int>(spheres_.bodies[i]);
      const double gap_m =
          mju_dist3(tool.position_m, positions_m_.data() + 3 * i) - spheres_.radii_m[i];
      if (gap_m < kNear_m && m_->body_weldid[body] != 0 &&
          (bodies.empty() || bodies.back() != body))
        bodies.push_back(body);
    }
    return bodies;
  }

  void tell_responses() {
    std::vector<stillgrid_response> responses;
    for (const int body : near_tool()) responses.push_back(response_of(body));
    require(stillgrid_publisher_set_responses(
                publisher_, static_cast<std::uint32_t>(responses.size()), responses.data()),
            "set_responses");
  }

  /// J M^-1 J^T of the body's own six coordinates: joints are in it, contacts are not.
  [[nodiscard]] stillgrid_response response_of(int body) const {
    stillgrid_response out{};
    out.body = static_cast<std::uint32_t>(body);
    mju_copy3(out.centre_m, d_->xipos + 3 * body);
    double turn_move[6];
    mj_objectVelocity(m_, d_, mjOBJ_BODY, body, turn_move, 0);  // at its centre of mass
    mju_copy3(out.velocity, turn_move + 3);
    mju_copy3(out.velocity + 3, turn_move);
    const int nv = m_->nv;
    std::vector<double> jacobian(6 * nv), solved(6 * nv);
    mj_jacBodyCom(m_, d_, jacobian.data(), jacobian.data() + 3 * nv, body);
    mj_solveM(m_, d_, solved.data(), jacobian.data(), 6);
    mju_mulMatMatT(out.inverse_inertia, solved.data(), jacobian.data(), 6, nv, 6);
    return out;
  }

  void apply_pushes() {
    std::vector<stillgrid_push> pushes(kMaxPushes);
    std::uint32_t count = kMaxPushes;
    require(stillgrid_publisher_pushes(publisher_, m_->opt.timestep, pushes.data(), &count),
            "pushes");
    mju_zero(d_->xfrc_applied, 6 * m_->nbody);
    for (const stillgrid_push& push : std::span(pushes).first(count)) {
      double* wrench = d_->xfrc_applied + 6 * push.body;
      double arm_m[3], torque_N_m[3];
      mju_sub3(arm_m, push.point_m, d_->xipos + 3 * push.body);
      mju_cross(torque_N_m, arm_m, push.force_N);
      mju_addTo3(wrench, push.force_N);
      mju_addTo3(wrench + 3, torque_N_m);
      mju_addTo3(wrench + 3, push.torque_N_m);
    }
  }

  const mjModel* m_;
  mjData* d_;
  Spheres spheres_;
  int steps_;
  std::vector<double> positions_m_, velocities_m_s_;
  stillgrid_publisher* publisher_ = nullptr;
};

}  // namespace

int main(int argc, char** argv) {
  bool is_lockstep = false;
  for (int i = 3; i < argc; ++i)
    if (std::string(argv[i]) == "--lockstep") is_lockstep = true;
  char error[500] = "expected MODEL.xml SESSION";
  mjModel* model = argc < 3 ? nullptr : mj_loadXML(argv[1], nullptr, error, sizeof error);
  if (model == nullptr) {
    std::fprintf(stderr, "publish_mujoco: %s\n", error);
    return 1;
  }
  Simulation simulation(model);
  simulation.open(argv[2], is_lockstep);
  simulation.run();
  mj_deleteModel(model);
  return 0;
}
