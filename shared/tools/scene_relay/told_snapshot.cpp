#include "shared/tools/scene_relay/told_snapshot.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "shared/collision/field_history.hpp"
#include "shared/tools/scene_relay/arrays.hpp"
#include "shared/tools/scene_relay/told_scene.hpp"

namespace stillgrid::scene_relay {
namespace {

void require(bool is_sound, const char* what) {
  if (!is_sound) throw MessageError(std::string("a snapshot is refused: ") + what);
}

/// Of how anything gives way: a speck of 1e-12 kg in steps of 0.1 s.
constexpr double kLargestResponse = 1e12;

FieldMotion motion_of(const proto::FieldRecord& record) {
  FieldMotion motion{};
  motion.state = told(record.history[0]);
  copy(record.predicted_velocity_m_s, motion.predicted_velocity_m_s);
  copy(record.predicted_angular_velocity_rad_s, motion.predicted_angular_velocity_rad_s);
  motion.response = record.response;
  return motion;
}

void check_fields(const ToldSnapshot& snapshot, const SnapshotLimits& limits) {
  require(snapshot.fields.size() == limits.moving_fields, "another number of fields");
  for (const FieldMotion& field : snapshot.fields) {
    require(collision::is_sound(state_of(field.state)) &&
                are_bounded(field.predicted_velocity_m_s) &&
                are_bounded(field.predicted_angular_velocity_rad_s),
            "a field's place or motion");
    require(field.response == 0 || field.response + std::size_t{1} <= snapshot.responses.size(),
            "a field's response");
  }
}

void check_response(const ToldSnapshot& snapshot, const SnapshotLimits& limits) {
  require(snapshot.modes.size() <= proto::kMaxModes &&
              snapshot.turning.size() <= proto::kMaxTurningBodies &&
              snapshot.responses.size() <=
                  publication::response_capacity(limits.moving_capacity, limits.moving_fields),
          "more modes, turning bodies or responses than there may be");
  for (const auto& mode : snapshot.modes)
    require(are_bounded(std::array{mode.inertia_share, mode.push, mode.displacement,
                                   mode.at_velocity, mode.damping_share}),
            "a mode");
  for (const auto& body : snapshot.turning)
    require(are_bounded(body.centre_m) && are_bounded(body.velocity_m_s) &&
                are_bounded(body.turns, kLargestResponse),
            "a turning body");
  for (const proto::SphereResponse& response : snapshot.responses)
    for (const std::array<float, 3>& mode : response.modes)
      require(are_bounded(mode, kLargestResponse), "a response");
}

}  // namespace

ToldSnapshot told(const reading::SceneSnapshot& snapshot, std::uint64_t tool_time_ns) {
  const proto::SnapshotHeader& header = snapshot.header;
  ToldSnapshot result{.snapshot_id = snapshot.snapshot_id,
                      .state_time_ns = header.state_time_ns[0],
                      .publish_time_ns = header.publish_time_ns[0],
                      .tool_time_ns = tool_time_ns,
                      .step_ns = header.step_ns,
                      .contacts = header.contacts,
                      .prediction_ns = header.prediction_ns,
                      .tool_work_J = header.tool_work_J,
                      .motions = std::vector<Motion>(snapshot.spheres.size()),
                      .labels = std::vector<Label>(snapshot.spheres.size()),
                      .modes = {},
                      .turning = {},
                      .responses = snapshot.responses,
                      .fields = {}};
  for (std::size_t i = 0; i < snapshot.spheres.size(); ++i) {
    const proto::SphereRecord& record = snapshot.spheres[i];
    copy(record.newest.position_m, result.motions[i].position_m);
    copy(record.newest.velocity_m_s, result.motions[i].velocity_m_s);
    copy(record.predicted_velocity_m_s, result.motions[i].predicted_velocity_m_s);
    result.labels[i] = {record.radius_m, record.material, record.body, record.response};
  }
  for (std::size_t i = 0; i < std::min<std::size_t>(header.mode_count, proto::kMaxModes); ++i)
    result.modes.push_back(std::bit_cast<stillgrid_relay1_Mode>(header.modes[i]));
  for (std::size_t i = 0; i < std::min<std::size_t>(header.turning_count, proto::kMaxTurningBodies);
       ++i) {
    const proto::TurningBody& body = header.turning[i];
    auto& turning = result.turning.emplace_back();
    turning.body = body.body;
    copy(body.centre_m, turning.centre_m);
    copy(body.velocity_m_s, turning.velocity_m_s);
    std::memcpy(turning.turns, body.turns.data(), sizeof turning.turns);
  }
  for (proto::SphereResponse& response : result.responses)
    std::fill(response.modes.begin() + static_cast<std::ptrdiff_t>(result.modes.size()),
              response.modes.end(), std::array<float, 3>{});
  for (const proto::FieldRecord& record : snapshot.fields)
    result.fields.push_back(motion_of(record));
  return result;
}

void check(const ToldSnapshot& snapshot, const SnapshotLimits& limits) {
  require(snapshot.motions.size() <= limits.moving_capacity &&
              snapshot.labels.size() == snapshot.motions.size(),
          "more spheres than its scene has room for");
  require(std::abs(snapshot.tool_work_J) <= proto::kLargestNumber, "the tool's work");
  require(snapshot.prediction_ns <= 100'000'000'000, "a prediction of more than 100 s");
  check_response(snapshot, limits);
  check_fields(snapshot, limits);
  for (const Motion& motion : snapshot.motions)
    require(are_bounded(motion.position_m) && are_bounded(motion.velocity_m_s) &&
                are_bounded(motion.predicted_velocity_m_s),
            "a sphere's place or velocity");
  for (const Label& label : snapshot.labels)
    require(label.radius_m > 0.0F && double{label.radius_m} <= proto::kLargestNumber &&
                (label.material < limits.material_count || label.material == proto::kFieldPoint) &&
                label.response <= snapshot.responses.size(),
            "a sphere's radius, material or response");
}

}  // namespace stillgrid::scene_relay
