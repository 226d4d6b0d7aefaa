#pragma once

#include <Eigen/Core>
#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/detection.hpp"
#include "sim_server/contact/predicted_contacts.hpp"
#include "sim_server/dynamics/integrators/integrator.hpp"
#include "sim_server/dynamics/solvers/budget.hpp"
#include "sim_server/dynamics/step/energy_account.hpp"
#include "sim_server/dynamics/step/energy_watch.hpp"
#include "sim_server/dynamics/step/predicted_part.hpp"
#include "sim_server/dynamics/step/prediction.hpp"
#include "sim_server/dynamics/step/sleeping.hpp"
#include "sim_server/dynamics/step/tool_motion.hpp"
#include "sim_server/dynamics/ticks/ticked_world.hpp"
#include "sim_server/scene/scene_description.hpp"
#include "sim_server/snapshot/moving_fields.hpp"
#include "sim_server/snapshot/moving_snapshot.hpp"

namespace stillgrid::dynamics {

/// Of one hand.
struct ToolReport {
  std::uint64_t time_ns = 0;  // of the latest sample that a step took, 0: none
  double work_J = 0.0;        // that the tool has given the world in all steps up to that one's end
};

/// What one step did and what each of its phases cost.
struct StepReport {
  SolveReport solve;  // iterations of all substeps, the worst residual
  int substeps = 0;
  bool out_of_budget = false;  // so that its end was computed by one iteration
  bool stopped = false;        // by the budget, before its end: the world is where a part ended
  int crossings_left = 0;      // substeps in which spheres may have passed through one another
  int contacts = 0;            // that touch at the step's end
  int sleeping_spheres = 0;    // at the step's end
  std::array<ToolReport, proto::kMaxHands> tools{};  // by hand
  std::chrono::nanoseconds detect{}, respond{}, integrate{};

  void note_work(const EnergyByHand_J& work_J);
  /// Takes the times of samples.
  void note_times(std::span<const std::optional<ToolSample>> samples);
};

/// Asked for a tool's newest sample; none: there is no tool.
using TakeTool = std::function<std::optional<ToolSample>()>;

/// The longest part of a step, halved until it is shorter than one of `length` by more than the
/// rounding of its ends: parts that begin where spheres would have crossed have any length.
[[nodiscard]] inline double halved_below(double longest, double length) noexcept {
  while (longest > 0.75 * length) longest /= 2.0;
  return longest;
}

/// A scene's world and all that moves it on.
class Simulation {
 public:
  explicit Simulation(const scene::SceneDescription& scene);
  /// The same from another state. Pre: `world` is build_world(scene), moved.
  Simulation(const scene::SceneDescription& scene, bodies::World world);

  /// Advances the world by step_s.
  ///
  /// The engine takes velocity Verlet in ticks of 1 ms at most, and implicit Euler in one tick or
  /// as many as `substeps` (docs/algorithms/explicit_step.md, implicit_step.md). It divides ticks
  /// so that fast bodies, and tools on their straight paths, cross no body. A tick that ends behind
  /// the budget's deadline is the last: time runs late. Each tick takes the newest sample of each
  /// tool.
  ///
  /// Other methods take the step in one part. A part that does not converge is halved, down to an
  /// eighth; the next step begins with half as many. A part also ends where spheres would pass each
  /// other (docs/algorithms/fast_bodies.md), at most 64 times. The report counts crossings that are
  /// left. Contacts are found again where forces led a sphere off its path. The tool is asked for
  /// again before each part. A step whose budget is spent goes to its end in one iteration.
  ///
  /// A tick or part in which a sleeping body would be touched wakes it first
  /// (docs/algorithms/sleeping.md). A step of a scene in which everything sleeps and the tool is
  /// far only takes time on. A sample that is no later than the last changes nothing, to the bit.
  ///
  /// Throws std::domain_error if the state is not finite: that step is not part of the world.
  ///
  /// take_tools: by hand; those beyond are away.
  StepReport step(double step_s, std::span<const TakeTool> take_tools, Budget budget = {});
  /// The same of the first hand alone.
  StepReport step(double step_s, const TakeTool& take_tool, Budget budget = {}) {
    return step(step_s, std::span(&take_tool, 1), budget);
  }

  /// Adds to the snapshot of the last step where the next one of step_s would lead, for one hand,
  /// in place of what it had for another (docs/algorithms/predict.md): the tools of the others go
  /// on as they move. The world stays as it is. Nothing is predicted when the budget is spent; of
  /// more than a thousand spheres what is near the hand's tool (PredictedPart).
  [[nodiscard]] publication::SnapshotPrediction predict_next(double step_s,
                                                             const Budget& budget = {},
                                                             std::size_t hand = 0);

  /// Counts iterations and products of the last predict_next(). Zero if it solved no system.
  [[nodiscard]] const SolveReport& prediction_work() const noexcept { return prediction_work_; }

  /// Who shares the work of a large scene; must outlive this. No byte depends on it.
  void share_work(const WorkSharing& sharing) {
    if (ticked_) ticked_->share_work(sharing);
  }

  /// Makes later calls of step() throw std::domain_error when the world has gained energy that no
  /// tool and no prescribed body gave (EnergyWatch). Pre: only step() changes the world.
  void watch_energy();
  /// Throws likewise if the world has gained energy by now.
  void judge_energy();

  /// Accounts for energy from now on. No step comes out otherwise for it.
  void account_energy();
  /// Of all steps since then; none if it was not asked for.
  [[nodiscard]] std::optional<EnergyAccount> energy_account();

  /// State of contacts: with the world, another simulation of the scene continues from it. Empty by
  /// methods that the engine does not have; they ignore it.
  [[nodiscard]] std::vector<std::byte> contact_state() const;
  /// Pre: the simulation that wrote it had the scene and the world of this one.
  void set_contact_state(std::span<const std::byte> state);

  [[nodiscard]] const bodies::World& world() const noexcept { return world_; }
  /// A change of it is taken up by the next step.
  [[nodiscard]] bodies::World& world() noexcept {
    is_world_changed_ = true;
    return world_;
  }
  [[nodiscard]] const contact::Detection& detection() const noexcept { return detection_; }
  /// All moving spheres as they are, ready to publish, and all moving fields.
  [[nodiscard]] const collision::VoxelGrid& snapshot() const noexcept {
    return detection_.spheres().grid();
  }
  [[nodiscard]] std::span<const proto::FieldRecord> field_records() const noexcept {
    return moving_fields_.records();
  }

 private:
  /// A part of a step, as shares of it, and what limits it.
  struct Part {
    double start = 0.0, end = 1.0;
    bool must_advance = false;  // though the solver did not converge
    bool may_shorten = true;    // to keep spheres from crossing
    bool must_end = false;      // the step: its budget is spent
    int widened = 0;            // how often its contacts were found again for wider ways
  };
  /// What came of an attempt: done, or how much of it to try, or to try it again.
  struct Attempt {
    bool advanced = false;
    double share = 1.0;  // less than 1: spheres would cross beyond it
    bool woke = false;   // who woke is yet to be reckoned with
    bool again = false;  // with the contacts of wider ways, which were found
  };

  /// What a step was asked for, and what it has come to.
  struct Step {
    double length_s;
    std::span<const TakeTool> take_tools;
    Budget budget;
    StepReport report = {};
  };

  /// By hand, as tools_.
  using ToolSamples = std::array<std::optional<ToolSample>, proto::kMaxHands>;

  StepReport step_in_ticks(Step& step);
  TickedWorld::Report run_ticks(Step& step);
  void note_ticks(const TickedWorld::Report& ticked, StepReport& report);
  void show_ticks(const TickedWorld::Report& ticked);
  [[nodiscard]] std::vector<std::optional<ToolPose>> tool_poses() const;
  [[nodiscard]] std::vector<ContactMemory> stretched_contacts() const;
  [[nodiscard]] ContactMemories* memories() const {
    return integrator_ ? integrator_->memories() : nullptr;
  }
  void place_tools(Step& step);
  void take(std::size_t hand, const std::optional<ToolSample>& sample, Step& step);
  StepReport pass(double step_s, StepReport& report);
  [[nodiscard]] ToolSamples later_samples(const Step& step) const;
  void redirect(const ToolSamples& samples, double from);
  [[nodiscard]] const std::vector<contact::ToolSphereMotion>& tools_over(double start, double end);
  void find_contacts(double step_s, Part& part);
  void find_tool_contacts(const Part& part);
  Attempt advance(Part& part, Step& step);
  [[nodiscard]] EnergyFlow flow_of(const Part& part, double duration_s);
  void take_prediction(double duration_s);
  void take_bodies(double duration_s);
  enum class Strays { kNone, kAgain, kShorter };
  Strays look_for_strays(Part& part, double duration_s);
  [[nodiscard]] contact::Ways ways_to(std::span<const bodies::SphereMotion> end,
                                      std::span<const bodies::RigidBody> end_bodies,
                                      double duration_s) const;
  bool wake_touched(const contact::Ways& ways);
  void note_sleep();
  [[nodiscard]] Energies energies_now();

  bodies::World world_;
  contact::Detection detection_;
  snapshot::MovingSnapshot snapshot_;
  snapshot::MovingFields moving_fields_;
  scene::Method method_;
  std::optional<TickedWorld> ticked_;       // methods of the engine
  std::unique_ptr<Integrator> integrator_;  // all others; null with ticked_
  IntegratorTraits traits_;
  std::vector<ToolMotion> tools_;                        // by hand
  std::vector<contact::ToolSphereMotion> tool_spheres_;  // of all, as asked for last
  std::optional<Sleeping> sleeping_;
  std::optional<EnergyAccount> account_;
  std::optional<EnergyWatch> watch_;
  EnergyByHand_J tool_work_J_{};  // in all steps
  std::vector<contact::Contact> led_contacts_;
  std::unique_ptr<Prediction> prediction_;
  std::vector<bodies::SphereMotion> start_, end_;  // of every sphere over a part
  std::vector<bodies::RigidBody> end_bodies_;      // where fields would be, if there are any
  bool swings_ = false;                            // something prescribed does
  PredictedPart predicted_part_;
  SolveReport prediction_work_;
  contact::PredictedContacts predicted_contacts_;
  int substeps_ = 1;  // that the end of the last step took, were it all alike

  bool is_world_changed_ = false;  // outside of step()
  bool has_driven_ = false;        // a prescribed motion that leads somewhere
  int still_steps_ = 0;       // in turn that ended with everything sleeping, as far as they count
  bool passes_ = false;       // the last step only took time on
  double predicted_s_ = 0.0;  // from such steps; zero: nothing
};

}  // namespace stillgrid::dynamics
