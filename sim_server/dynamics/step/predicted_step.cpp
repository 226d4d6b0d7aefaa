// Where the next step of a simulation would lead.
#include <algorithm>
#include <utility>

#include "sim_server/dynamics/step/simulation.hpp"

namespace stillgrid::dynamics {

/// Contacts that friction has stretched, by key.
std::vector<ContactMemory> Simulation::stretched_contacts() const {
  std::vector<ContactMemory> stretched;
  const auto spheres = static_cast<std::int32_t>(world_.spheres.size());
  const auto set_other = [&](std::int32_t sphere, contact::Contact& pair) {
    (sphere < spheres ? pair.b : pair.other) = sphere < spheres ? sphere : sphere - spheres;
  };
  for (const ContactListing::Stretched& listed : ticked_.engine().listing().stretched()) {
    contact::Contact pair;
    pair.a = listed.sphere_a;
    pair.other = listed.plane;
    pair.is_plane = listed.plane >= 0;
    Eigen::Vector3d stretch_m = listed.stretch_m;
    if (listed.field >= 0) {
      pair.b = spheres + listed.field;
    } else if (listed.sphere_a >= spheres) {  // a fixture
      stretch_m = -stretch_m;
      pair.a = listed.sphere_b;
      set_other(listed.sphere_a, pair);
    } else if (listed.plane < 0) {
      set_other(listed.sphere_b, pair);
    }
    if (is_turned(pair)) stretch_m = -stretch_m;
    stretched.push_back({.key = key_of(pair),
                         .stiffness_N_per_m = listed.stiffness_N_per_m,
                         .stretch_m = stretch_m});
  }
  std::ranges::sort(stretched, {}, &ContactMemory::key);
  return stretched;
}

publication::SnapshotPrediction Simulation::predict_next(double step_s, const Budget& budget,
                                                         std::size_t hand) {
  prediction_work_ = {};
  if (tools_.size() > 1) {
    snapshot_.forget_predictions(detection_.spheres());
    moving_fields_.forget_predictions();
  }
  if (budget.is_late()) return {};
  tool_spheres_.clear();
  for (std::size_t other = 0; other < tools_.size(); ++other)
    if (other != hand) tools_[other].add_spheres(tool_spheres_);
  const std::size_t of_others = tool_spheres_.size();
  tools_[hand].add_spheres(tool_spheres_);
  const auto tool = std::span(std::as_const(tool_spheres_)).subspan(of_others);
  if (tool.empty() && world_.spheres.size() > PredictedPart::kMaxSpheres) return {};
  predicted_part_.choose(world_, detection_.motions(), tool);
  // What may touch by then, on lists of its own: those of the next step stay in their order.
  if (!predicted_contacts_.find(world_, detection_, predicted_part_.spheres(), step_s,
                                tool_spheres_))
    return {};
  // Of a part they are known by other numbers.
  std::vector<ContactMemory> kept;
  if (predicted_part_.is_whole()) kept = stretched_contacts();
  prediction_->look(predicted_part_.world(),
                    predicted_part_.renumbered(predicted_contacts_.contacts()), step_s, kept,
                    budget, hand);
  prediction_work_ = prediction_->work();
  for (proto::TurningBody& turning : prediction_->turning())
    turning.body = predicted_part_.scene_body(turning.body);
  snapshot_.take_predictions(predicted_part_.spheres(), prediction_->spheres(),
                             proto::kPredictionPeriods * step_s, proto::kLongestPredictionLag_s,
                             detection_.spheres());
  for (std::size_t i = 0; i < moving_fields_.fields().size(); ++i) {
    const std::size_t field = moving_fields_.fields()[i];
    if (predicted_part_.world().fields[field].rigid < 0) continue;  // it goes on as it moves
    const bodies::FieldPrediction& predicted = prediction_->fields()[field];
    moving_fields_.predict(i, predicted.predicted_velocity_m_s,
                           predicted.predicted_angular_velocity_rad_s, predicted.response);
  }
  return prediction_->snapshot();
}

}  // namespace stillgrid::dynamics
