#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/tool_segment.hpp"
#include "shared/library/body_modes.hpp"
#include "shared/publication/moving_records.hpp"
#include "shared/publication/scene_segment.hpp"
#include "shared/rendering/mode_response.hpp"
#include "shared/rendering/placed_tool.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::library {

/// What one hand's tool does to the bodies over a step, and what is published of it.
///
/// A push is the contact law's at the end of the step, to which the body has given way: of a body
/// without a response the law's at its beginning. The same modes go into the snapshot, so that the
/// hand feels between two steps what the engine's next step will do of it.
/// Nothing is allocated after construction. Thread: one.
class HandPushes {
 public:
  explicit HandPushes(std::size_t moving_capacity);

  /// bodies: by number, each with its modes of this step. is_tried: predicted velocities are those
  /// of a trial of the step, with the last step's pushes held. Pre: moving was placed.
  void find(const proto::SceneHeader& scene, const proto::ToolState& tool,
            publication::MovingRecords& moving, std::span<BodyModes> bodies, double step_s,
            bool is_tried);
  /// There is no tool.
  void clear() noexcept;
  /// The pushes were those of the step that has ended: what they did is known by work_J().
  void end_step() noexcept;

  /// Of each body that is touched, in the order in which it was found.
  [[nodiscard]] std::span<const stillgrid_push> pushes() const noexcept { return pushes_; }

  /// What the pushes did over the step, by which the spheres have moved. Pre: placed anew, before
  /// end_step().
  [[nodiscard]] double work_J(publication::MovingRecords& moving) const noexcept;

  /// Writes where the spheres go into their records, and tells the snapshot how they give way.
  /// predicted: 3 values a sphere, or none. The spans last until the next find().
  [[nodiscard]] publication::SnapshotPrediction predict(publication::MovingRecords& moving,
                                                        double step_s,
                                                        std::span<const double> predicted);

 private:
  struct Near {
    double distance_m;
    std::uint32_t sphere;
    BodyModes* body;
  };
  /// A body that gives way: its modes are numbers first to first + count of the snapshot's.
  struct Chosen {
    BodyModes* body;
    int first;
  };
  struct SpherePush {
    std::uint32_t sphere;
    Eigen::Vector3d force_N;
  };
  using Modes = display::ModeDisplacements;

  void find_near(std::span<const rendering::PlacedToolSphere> tool,
                 publication::MovingRecords& moving, std::span<BodyModes> bodies);
  void choose(publication::MovingRecords& moving);
  void sum_pushes(const proto::SceneHeader& scene, const rendering::ToolPose& pose,
                  std::span<const rendering::PlacedToolSphere> tool,
                  const rendering::TouchedSpheres& touched, publication::MovingRecords& moving);
  [[nodiscard]] const Chosen* chosen_of(std::uint32_t body) const noexcept;
  /// Where the held pushes lead, of each mode, with whatever else acts.
  void lead(publication::MovingRecords& moving, double step_s, bool is_tried);
  /// The modes' displacements that move the chosen body's near spheres by velocity(sphere) over
  /// the step, as nearly as modes can.
  template <class Velocity>
  void fit(const Chosen& chosen, double step_s, publication::MovingRecords& moving,
           Velocity&& velocity, Modes& displacements) const;
  void add_modes(const Chosen& chosen, double step_s, const Modes& now, const Modes& whole,
                 const Modes& push);
  void add_to_predicted(publication::MovingRecords& moving, double step_s,
                        const Modes& displacements) const;

  rendering::ToolSpheres placed_{};
  std::vector<Near> near_;
  std::vector<Chosen> chosen_;
  std::vector<proto::SphereResponse> responses_;
  std::vector<std::uint32_t> responding_;  // the sphere of each response
  std::vector<proto::ResponseMode> modes_;
  std::vector<proto::TurningBody> turning_;
  rendering::TouchedSpheres touched_;
  Modes now_ = Modes::Zero(), held_ = now_, led_ = now_;  // at the velocity; by the last pushes;
                                                          // where these lead
  bool is_tried_ = false;
  rendering::ModeResponse response_;
  rendering::ResponseSolver solver_;
  std::vector<stillgrid_push> pushes_, before_;  // of this step, and of the one before
  std::vector<SpherePush> sphere_pushes_;
};

}  // namespace stillgrid::library
