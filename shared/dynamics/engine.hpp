#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "shared/collision/smooth_cover.hpp"
#include "shared/collision/tool_proxy.hpp"
#include "shared/dynamics/ball_motion.hpp"
#include "shared/dynamics/contact_listing.hpp"
#include "shared/dynamics/contact_solver.hpp"
#include "shared/dynamics/description.hpp"
#include "shared/dynamics/energy_losses.hpp"
#include "shared/dynamics/engine_method.hpp"
#include "shared/dynamics/field_contacts.hpp"
#include "shared/dynamics/joint_forces.hpp"
#include "shared/dynamics/scene_state.hpp"
#include "shared/dynamics/sleep.hpp"
#include "shared/dynamics/spectrum_bound.hpp"
#include "shared/dynamics/spring_table.hpp"

namespace stillgrid::dynamics {

class CoupledStep;

/// A tick of physics: the period of the haptic loop.
inline constexpr double kTick_s = 1e-3;
/// Returns the number of ticks in which velocity Verlet takes a step of step_s.
[[nodiscard]] int ticks_of(double step_s);

/// Pose of a driven body at the end of a tick. Within the tick it moves evenly.
struct DrivenPose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  // used in the tick in which it appears
  bool is_here = true;                                     // false: it is away and never touches
};

/// The mean force of all contacts of two bodies over a substep. Frame: the world's.
struct ContactForce {
  int body_a = 0, body_b = 0;  // numbers of bodies, as Description::Sphere::body; a < b
  int contacts = 0;
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();     // on body a
  Eigen::Vector3d torque_N_m = Eigen::Vector3d::Zero();  // on body a, about centre_m
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();    // centre of pressure
};

/// Simulates a scene tick by tick: nodes on springs, rigid bodies and their contacts.
///
/// Small steps divide a tick into substeps. A substep is one step of position Verlet.
/// Contacts, friction and their impulses on bodies are solved implicitly at its middle. An
/// EngineMethod may advance the whole scene at once instead, in one CoupledStep or in parts.
///
/// The result of step() depends on the state, the driven poses and the Description alone. It reads
/// no clock, and its results are equal to the bit on every run and every instruction set.
///
/// Thread: one. Realtime: step() does not lock or throw; it allocates only while the number of
/// near pairs grows beyond all ticks before.
class Engine {
 public:
  /// Throws std::invalid_argument where an index is out of range or a mass is not positive.
  Engine(Description description, SceneState state, EngineMethod method = {});
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  /// Advances by a tick of tick_s. There is one pose in driven for each driven body, in the order
  /// of the Description. given_substeps is 0 for the number that stability asks for.
  void step(std::span<const DrivenPose> driven = {}, double tick_s = kTick_s,
            int given_substeps = 0);

  /// Shares the work of later ticks. Pre: sharing outlives the engine.
  void share_work(const WorkSharing& sharing) { live_.sharing = balls_.sharing = &sharing; }

  /// Once stop is true, a tick by a CoupledStep ends at its next iteration. The state is then to
  /// be set anew. Pre: stop outlives the engine, or is null.
  void stop_at(const std::atomic<bool>* stop) { stop_ = stop; }

  /// Changes positions and velocities; contacts keep their friction, and all bodies wake. Pre: of
  /// this Description.
  void set_state(SceneState state);
  void set_gravity(const Eigen::Vector3d& gravity_m_s2);

  /// Writes all that later steps depend on as one block. Realtime: yes, where the block has had the
  /// size before.
  void save(std::vector<std::byte>& block) const;
  /// Continues from a block of an engine of the same Description, to the bit. Throws
  /// std::invalid_argument where the block is not one of such an engine, and stays as it is.
  void load(std::span<const std::byte> block);

  [[nodiscard]] const Description& description() const noexcept { return description_; }
  [[nodiscard]] const SceneState& state() const noexcept { return state_; }
  [[nodiscard]] const ContactListing& listing() const noexcept { return listing_; }
  /// Reactions of the last tick, one for each driven body.
  [[nodiscard]] std::span<const DrivenReaction> reactions() const noexcept { return reactions_; }
  /// Substeps of the last tick: as many as the stiffness of springs and joints asks for, or more
  /// where spheres meet at high speed.
  [[nodiscard]] int substeps() const noexcept { return substeps_; }
  /// Returns the substeps that stiffness asks for in the next tick.
  [[nodiscard]] int needed_substeps(double tick_s) { return substeps_by_stiffness(tick_s); }
  /// Figures of the last tick by a CoupledStep.
  [[nodiscard]] const SolveFigures& solve() const noexcept { return solve_; }
  /// Contacts that pushed in the last substep.
  [[nodiscard]] int touching() const;
  /// Writes the forces between bodies in the last substep, sorted by their numbers, of the contacts
  /// that pushed. Those of bodies that sleep, and of driven bodies with fixtures, are not listed.
  void list_contact_forces(std::vector<ContactForce>& forces) const;
  /// Returns the energy of the springs of contacts and of friction at the current positions, J.
  /// Before the first tick it lists contacts, which allocates.
  [[nodiscard]] double contact_energy_J() const;
  [[nodiscard]] const Sleep& sleep() const noexcept { return sleep_; }
  /// Measures losses from the next tick on. No other result depends on it.
  void count_losses() { counts_losses_ = true; }
  /// Losses of the last tick; zero without count_losses().
  [[nodiscard]] const EnergyLosses& losses() const noexcept { return meter_.losses(); }

 private:
  /// A sphere that is no ball, with all that its place is computed from.
  struct OtherSphere {
    std::int32_t place, rigid, node_count;
    std::array<int, 4> nodes;
    std::array<double, 4> weights;
    Eigen::Vector3d local_m;
    double arm_m;  // length of local_m
    Vector4 base;  // see ContactListing::base()
  };
  struct PoseOfOther {
    Eigen::Matrix3d axes;
    double speed_m_s, spin_rad_s;
  };
  /// A half-space of another side, its velocity, and the scale of its field's map.
  struct Seen {
    collision::HalfSpace space;
    Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
    double map_scale = 1.0;
    collision::SeenSurface surface;
  };
  /// A tick of a tool's sphere, and where its proxy begins it.
  struct ProxyTick {
    collision::DeviceMove device;
    Eigen::Vector3d proxy_m;
  };
  void aim_driven(std::span<const DrivenPose> driven, double tick_s);
  void begin_proxies();
  [[nodiscard]] Seen see(std::int32_t other, const Eigen::Vector3d& proxy_m, const ProxyTick& tick,
                         collision::TickPart part) const;
  std::span<collision::HalfSpace> lay(const Eigen::Vector3d& proxy_m, const ProxyTick& tick,
                                      collision::TickPart part);
  void find_touchable(std::int32_t tool);
  void move_proxies(double part_s);
  void aim_lane(ToolLane& lane, const Seen& seen, const collision::HalfSpace& space,
                const ProxyTick& tick);
  [[nodiscard]] Eigen::Vector3d turned_aside_m(const ToolLane& lane) const;
  void finish_proxies(double share = 1.0);
  [[nodiscard]] double tool_energy_J(std::size_t driven) const;
  [[nodiscard]] double behind_m(std::size_t tool) const;
  [[nodiscard]] bool listing_holds(double tick_s);
  void drift(double duration_s);
  void load_movers();
  void place_spheres(std::span<const OtherSphere> spheres, double substep_s);
  void list_contacts(double tick_s);
  bool measure_ways(double tick_s);
  [[nodiscard]] int substeps_of_pair(const RowPlace& place, std::size_t lane, bool is_plane,
                                     double tick_s) const;
  [[nodiscard]] int substeps_by_speed(double tick_s);
  [[nodiscard]] static int substeps_of_path(double lengths);
  void adopt_listing();
  void note_listed();
  void sum_forces();
  void apply_forces(double duration_s, const Vector4& falls_m_s);
  void kick(double substep_s, const Vector4& falls_m_s);
  void apply_impulses();
  void note_reactions(double substep_s);
  [[nodiscard]] int substeps_by_stiffness(double tick_s);
  [[nodiscard]] double energy_of_contacts_J(const ContactListing& listing, int rigid) const;
  void substep(double substep_s);
  void divided_tick(double tick_s, int given_substeps);
  void coupled_tick(double tick_s);
  [[nodiscard]] bool solve_part(double part_s, bool may_divide);
  void note_coupled_reactions();
  void coupled_part(double part_s, int halvings);
  void wake_all();
  void adopt_sleep();
  void wake_touched(double tick_s);
  [[nodiscard]] bool passes(double tick_s);
  [[nodiscard]] bool is_clear_of_sleepers(const Description::Sphere& sphere, double tick_s);
  void advance(double tick_s, int given_substeps);
  /// Rigid bodies that are awake and no balls.
  [[nodiscard]] std::span<const std::int32_t> others() const {
    const std::size_t balls = balls_.rigid.size();
    return listing_.rigid_order().subspan(balls, listing_.rigid_awake() - balls);
  }
  template <class Visit>
  void each_awake_node(const Visit& visit) const {
    for (const auto& [first, end] : awake_nodes_)
      for (std::size_t i = first; i < end; ++i) visit(i);
  }

  Description description_;
  std::uint64_t fingerprint_;
  SceneState state_;
  Sleep sleep_;
  std::vector<std::pair<std::size_t, std::size_t>> awake_nodes_;  // runs: first, end
  std::vector<Description::Joint> awake_joints_;
  NearPairs still_;                // sleeping spheres and fixtures, while all bodies sleep
  std::vector<Vector4> still_at_;  // their centres and radii
  bool is_still_known_ = false;
  bool may_pass_ = true;  // false: driven bodies may touch each other while all others sleep
  SpringTable springs_;
  ContactListing listing_;
  FieldContacts fields_;
  ContactBodies bodies_;
  LiveRows live_;
  std::vector<Vector4> forces_N_;             // on nodes
  std::vector<PoseOfOther> poses_of_others_;  // entries of balls are unused
  std::vector<Wrench> wrenches_;              // on rigid bodies; empty without joints
  BallList balls_;
  std::vector<OtherSphere> other_spheres_;  // those of listed contacts first
  std::size_t listed_others_ = 0;
  std::vector<std::int32_t> listed_nodes_;     // awake ones of spheres of listed contacts
  std::vector<std::uint8_t> is_listed_;        // scratch: spheres in order(), then nodes
  std::vector<std::size_t> driven_;            // rigid bodies
  std::vector<std::int32_t> driven_of_rigid_;  // -1: not driven
  std::vector<DrivenPose> poses_;              // at the end of the tick, as driven_
  std::vector<std::uint8_t> appeared_;         // in this tick, as driven_
  std::vector<std::uint8_t> is_tool_;          // whether each of driven_ has proxies
  std::vector<double> held_J_;  // tool_energy_J() of each of driven_, after the last substep
  std::vector<DrivenReaction> reactions_;     // one for each of driven_
  mutable ContactListing::Saved saved_;       // scratch of save() and load()
  SceneState loaded_;                         // scratch of load()
  std::vector<double> loaded_held_J_;         // likewise
  Sleep::Saved loaded_sleep_;                 // likewise
  std::vector<std::int32_t> touchable_;       // numbers of Description::side() near a tool's sphere
  std::vector<Vector4> moved_proxy_m_;        // at the end of the part; as SceneState::proxy_m
  bool a_tool_goes_far_ = false;              // a tool moves past a surface by more than its radius
  std::vector<Seen> seen_;                    // likewise
  std::vector<collision::HalfSpace> spaces_;  // likewise
  std::vector<collision::SeenSurface> surfaces_;  // likewise
  collision::SmoothCover cover_;
  std::vector<float> ways_m_;  // spheres in a tick, as ContactListing::order()
  double smallest_length_m_ = 0.0;
  int substeps_ = 1;            // last tick
  double substep_s_ = kTick_s;  // the last one
  bool is_stale_ = true;        // contacts must be listed before the next tick
  LossMeter meter_;
  bool counts_losses_ = false;
  SpectrumBound spring_bound_;
  JointBound joint_bound_;
  std::unique_ptr<CoupledStep> coupled_;  // null: small steps
  SolveFigures solve_;
  const std::atomic<bool>* stop_ = nullptr;
  SceneState ahead_;  // scratch
};

}  // namespace stillgrid::dynamics
