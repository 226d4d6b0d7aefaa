#include "shared/tools/scene_relay/told_snapshot.hpp"

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

void check_fields(const ToldSnapshot& snapshot, const SnapshotLimits& limits) {
  require(snapshot.fields.size() == limits.moving_fields, "another number of fields");
  for (const FieldMotion& field : snapshot.fields)
    require(collision::is_sound(state_of(field)), "a field's place or motion");
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
                      .tool_work_J = header.tool_work_J,
                      .motions = std::vector<Motion>(snapshot.spheres.size()),
                      .labels = std::vector<Label>(snapshot.spheres.size()),
                      .fields = {},
                      .state = {}};
  for (std::size_t i = 0; i < snapshot.spheres.size(); ++i) {
    const proto::SphereRecord& record = snapshot.spheres[i];
    copy(record.newest.position_m, result.motions[i].position_m);
    copy(record.newest.velocity_m_s, result.motions[i].velocity_m_s);
    result.labels[i] = {record.radius_m, record.material, record.body};
  }
  for (const proto::FieldRecord& record : snapshot.fields)
    result.fields.push_back(told(record.history[0]));
  return result;
}

/// A simulation that steps along the path has the times of its ticks.
ToldSnapshot with_state(const reading::SceneSnapshot& snapshot, const ShownTool& tool) {
  const proto::SnapshotHeader& header = snapshot.header;
  std::uint64_t tool_ns = tool.on_hands_clock(header.tool_time_ns);
  if (header.state_bytes > 0 && header.tool_time_ns != 0)
    tool_ns = tool.hands_number(header.tool_time_ns / proto::kPathTick_ns).value_or(0) *
              proto::kPathTick_ns;
  ToldSnapshot result = told(snapshot, tool_ns);
  const auto tick = tool.hands_number(header.state_tick);
  if (!tick || snapshot.state.empty()) return result;
  result.state_tick = *tick;
  result.state_hash = header.state_hash;
  result.state.resize(snapshot.state.size());
  std::memcpy(result.state.data(), snapshot.state.data(), snapshot.state.size());
  return result;
}

void check(const ToldSnapshot& snapshot, const SnapshotLimits& limits) {
  require(snapshot.motions.size() <= limits.moving_capacity &&
              snapshot.labels.size() == snapshot.motions.size(),
          "more spheres than its scene has room for");
  require(std::abs(snapshot.tool_work_J) <= proto::kLargestNumber, "the tool's work");
  require(snapshot.state.size() <= limits.state_capacity, "a state that its scene has no room for");
  check_fields(snapshot, limits);
  for (const Motion& motion : snapshot.motions)
    require(are_bounded(motion.position_m) && are_bounded(motion.velocity_m_s),
            "a sphere's place or velocity");
  for (const Label& label : snapshot.labels)
    require(label.radius_m > 0.0F && double{label.radius_m} <= proto::kLargestNumber &&
                (label.material < limits.material_count || label.material == proto::kFieldPoint),
            "a sphere's radius or material");
}

}  // namespace stillgrid::scene_relay
