#pragma once

#include <Eigen/Core>
#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/step/budget.hpp"
#include "sim_server/dynamics/step/energy_account.hpp"
#include "sim_server/dynamics/step/energy_watch.hpp"
#include "sim_server/dynamics/step/tool_sample.hpp"
#include "sim_server/dynamics/ticks/ticked_world.hpp"
#include "sim_server/scene/scene_description.hpp"
#include "sim_server/snapshot/moving_fields.hpp"
#include "sim_server/snapshot/moving_snapshot.hpp"

namespace stillgrid::dynamics {

/// Figures of one hand in a step.
struct ToolReport {
  std::uint64_t time_ns = 0;  // of the latest sample that a step took, 0: none
  double work_J = 0.0;        // that the tool has given the world in all steps up to that one's end
};

/// How the systems of a step were solved.
struct SolveReport {
  bool converged = false;
  int iterations = 0;
  long products = 0;      // with a derivative
  double residual = 0.0;  // m/s, rms over nodes and rigid bodies, in the worst part
};

/// Figures of one step.
struct StepReport {
  SolveReport solve;  // iterations of all ticks, the worst residual
  int ticks = 0, substeps = 0;
  bool out_of_budget = false;    // ticks of the step are left out: time runs late
  bool stopped = false;          // by the budget: the world is as it was
  int crossings_left = 0;        // parts in which spheres may have passed through one another
  int contacts = 0;              // that touch at the step's end
  int sleeping_spheres = 0;      // at the step's end
  double last_counted_ns = 0.0;  // the last tick, by counts
  std::array<ToolReport, proto::kMaxHands> tools{};  // by hand
  std::chrono::nanoseconds integrate{};

  void note_work(const EnergyByHand_J& work_J);
  /// Takes the times of samples.
  void note_times(std::span<const std::optional<ToolSample>> samples);
};

/// Asked for a tool's newest sample; none: there is no tool.
using TakeTool = std::function<std::optional<ToolSample>()>;

/// Returns a hand's tool at the end of a tick of its path; empty: it is away.
using ToolAt = std::function<std::optional<ToolPose>(std::uint64_t number)>;

/// The paths of the tools over a step: as many ticks of 1 ms as it has, from the one after
/// `number`.
struct AlongPaths {
  std::uint64_t number = 0;
  std::span<const ToolAt> tools = {};  // one a hand; empty: tools move evenly to their samples
};

/// A scene's world and all that moves it on.
class Simulation {
 public:
  explicit Simulation(const scene::SceneDescription& scene);
  /// The same from another state. Pre: `world` is build_world(scene), moved.
  Simulation(const scene::SceneDescription& scene, bodies::World world);

  /// Advances the world by step_s.
  ///
  /// The engine takes velocity Verlet in ticks of 1 ms at most, and other methods in one tick or in
  /// as many as `substeps`. If a body swings, their ticks are 1 ms at most, too: within a tick it
  /// moves evenly. The engine divides ticks so that fast bodies, and tools on their straight paths,
  /// cross no body (docs/algorithms/fast_bodies.md). A tick that ends behind the budget's deadline
  /// is the last: time runs late. Each tick takes the newest sample of each tool.
  ///
  /// A sleeping body that would be touched in a tick wakes first (docs/algorithms/sleeping.md). A
  /// step of a scene in which everything sleeps and the tool is far only takes time on. A sample
  /// that is no later than the last changes nothing, to the bit.
  ///
  /// Throws std::domain_error if the state is not finite, or if CVODE exceeds kMaxWork in a tick:
  /// that step is not part of the world.
  ///
  /// take_tools: by hand; those beyond are away. paths: the tools keep to them. Pre: the step is as
  /// many whole ticks then, and has_ticks().
  StepReport step(double step_s, std::span<const TakeTool> take_tools, Budget budget = {},
                  const AlongPaths& paths = {});
  /// The same of the first hand alone.
  StepReport step(double step_s, const TakeTool& take_tool, Budget budget = {}) {
    return step(step_s, std::span(&take_tool, 1), budget);
  }

  /// Who shares the work of a large scene; must outlive this. No byte depends on it.
  void share_work(const WorkSharing& sharing) { ticked_.share_work(sharing); }

  /// Makes later calls of step() throw std::domain_error when the world has gained energy that no
  /// tool and no prescribed body gave (EnergyWatch). Pre: only step() changes the world.
  void watch_energy();
  /// Throws likewise if the world has gained energy by now.
  void judge_energy();

  /// Accounts for energy from now on. No step comes out otherwise for it.
  void account_energy();
  /// Returns the account of all steps since account_energy(); empty without it.
  [[nodiscard]] std::optional<EnergyAccount> energy_account();

  /// See Engine::list_contact_forces(). Bodies of the world come first, then the hands' tools.
  void list_contact_forces(std::vector<ContactForce>& forces) const {
    ticked_.engine().list_contact_forces(forces);
  }

  [[nodiscard]] std::size_t hands() const noexcept { return tools_.size(); }
  /// Whether steps can be ticks of 1 ms that another process takes too.
  [[nodiscard]] bool has_ticks() const noexcept;
  /// Writes the state from which another process continues, and returns its hash.
  std::uint64_t save_state(std::vector<std::byte>& state) const;

  /// See SceneTicks::stretches_m().
  [[nodiscard]] std::span<const Vector4> stretches_m(std::size_t hand) const noexcept {
    return ticked_.ticks().stretches_m(hand);
  }

  /// State of contacts: with the world, another simulation of the scene continues from it.
  [[nodiscard]] std::vector<std::byte> contact_state() const;
  /// Contacts stay as they are if the state is empty. Pre: the simulation that wrote it had the
  /// scene and the world of this one.
  void set_contact_state(std::span<const std::byte> state);

  [[nodiscard]] const bodies::World& world() const noexcept { return world_; }
  /// A change of it is taken up by the next step.
  [[nodiscard]] bodies::World& world() noexcept {
    is_world_changed_ = true;
    return world_;
  }
  /// All moving spheres as they are, ready to publish, and all moving fields.
  [[nodiscard]] const collision::VoxelGrid& snapshot() const noexcept { return snapshot_.grid(); }
  [[nodiscard]] std::span<const proto::FieldRecord> field_records() const noexcept {
    return moving_fields_.records();
  }

 private:
  /// A step's arguments and its report.
  struct Step {
    double length_s;
    std::span<const TakeTool> take_tools;
    Budget budget;
    AlongPaths paths = {};
    StepReport report = {};
  };

  /// By hand, as tools_.
  using ToolSamples = std::array<std::optional<ToolSample>, proto::kMaxHands>;

  void place_tools(Step& step);
  [[nodiscard]] ToolSamples later_samples(const Step& step) const;
  void redirect(const ToolSamples& samples);
  [[nodiscard]] std::vector<std::optional<ToolPose>> tool_poses() const;
  [[nodiscard]] std::vector<std::optional<ToolPose>> aim_tick(Step& step, int tick);
  TickedWorld::Report run_ticks(Step& step);
  void note_ticks(const TickedWorld::Report& ticked, StepReport& report);
  void show_ticks(const TickedWorld::Report& ticked);
  [[nodiscard]] Energies energies_now() const;

  bodies::World world_;
  snapshot::MovingSnapshot snapshot_;
  publication::MovingFields moving_fields_;
  scene::Method method_;
  TickedWorld ticked_;
  std::vector<std::optional<ToolSample>> tools_;  // by hand; none: it is away
  std::optional<EnergyAccount> account_;
  std::optional<EnergyWatch> watch_;
  EnergyByHand_J tool_work_J_{};   // in all steps
  bool swings_ = false;            // something prescribed does
  bool is_world_changed_ = false;  // outside of step()
  bool has_driven_ = false;        // a prescribed motion that leads somewhere
  int still_steps_ = 0;  // in turn that ended with everything sleeping, as far as they count
};

}  // namespace stillgrid::dynamics
