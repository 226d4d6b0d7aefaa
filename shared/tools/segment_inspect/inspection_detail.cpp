#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "proto/device_plugin.h"
#include "shared/reading/snapshot.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/segment_inspect/inspection_text.hpp"

namespace stillgrid::segment_inspect {
namespace {

constexpr std::size_t kMaxMaterials = 8, kMaxPlanes = 8, kMaxFields = 8;  // shown; --json has all

/// One line: a name, and what is to say of it.
std::string line(std::string_view name, const std::string& value) {
  return fmt::format("  {:<16} {}\n", name, value);
}

std::string ms_text(std::optional<double> seconds) {
  return seconds ? fmt::format("{:.1f} ms", *seconds * 1e3) : "-";
}

template <class T, std::size_t N>
std::string vector_text(const std::array<T, N>& values, const char* unit = "") {
  return fmt::format("({:.4g}){}", fmt::join(values, ", "), unit);
}

std::string more_text(std::size_t count, std::size_t shown) {
  return count > shown ? line("", fmt::format("and {} more: see --json", count - shown)) : "";
}

std::string header_lines(const reading::SegmentSummary& summary) {
  if (!summary.header) return {};
  const proto::SegmentHeader& header = *summary.header;
  const std::string measured =
      summary.measured_rate_hz ? fmt::format("{:.1f} Hz", *summary.measured_rate_hz) : "-";
  std::string text =
      line("segment",
           fmt::format("version {}, {} clock, {}, epoch {}", header.version, name_of(header.clock),
                       size_text(header.size_bytes), hexadecimal(header.epoch))) +
      line("rate",
           fmt::format("declared {:.1f} Hz, measured {}", rate_of(header.period_ns), measured)) +
      line("snapshot_id", std::to_string(header.latest));
  if (summary.relay) text += line("over a relay", relay_text(*summary.relay));
  if (header.clock == proto::Clock::kVirtual) {
    const auto promise = [](std::uint64_t time_ns) {
      return time_ns == proto::kNever
                 ? "never"
                 : fmt::format("{:.6f} s", static_cast<double>(time_ns) * 1e-9);
    };
    text += line("promises",
                 fmt::format("next sample {}, next event {}", promise(header.lockstep_sample_ns),
                             promise(header.lockstep_event_ns)));
  }
  return text;
}

std::string field_lines(std::span<const publication::SceneField> fields) {
  std::string text;
  for (std::size_t i = 0; i < std::min(fields.size(), kMaxFields); ++i) {
    const proto::FieldBody& body = fields[i].body;
    text += line(
        fmt::format("field {}", i),
        fmt::format("{}, cells of {:.4g} m, {} bricks, {} of them fine, {}, material {}, "
                    "body {}",
                    body.moving != 0 ? "moving" : "static",
                    body.shape.brick_m / float{proto::kBrickCells},
                    fmt::join(body.shape.bricks, " x "), body.shape.fine_count,
                    size_text(8 * fields[i].field.layout.total_words), body.material, body.body));
  }
  return text + more_text(fields.size(), kMaxFields);
}

std::string fixed_lines(const publication::SceneView& view) {
  const proto::SceneHeader& scene = view.scene();
  std::string text = line("scene", reading::printable(scene.name.data()));
  for (std::size_t i = 0; i < std::min<std::size_t>(scene.material_count, kMaxMaterials); ++i) {
    const proto::Material& material = scene.materials[i];
    text += line(fmt::format("material {}", i),
                 fmt::format("{:g} N/m, {:g} N s/m, friction {:g} above {:g} m/s",
                             material.stiffness_N_per_m, material.damping_N_s_per_m,
                             material.friction, material.slip_speed_m_s));
  }
  text += more_text(scene.material_count, kMaxMaterials);
  for (std::size_t i = 0; i < std::min<std::size_t>(scene.plane_count, kMaxPlanes); ++i) {
    const proto::Plane& plane = scene.planes[i];
    text +=
        line(fmt::format("plane {}", i),
             fmt::format("normal {}, offset {:g} m, material {}, body {}",
                         vector_text(plane.normal), plane.offset_m, plane.material, plane.body));
  }
  text += more_text(scene.plane_count, kMaxPlanes) + field_lines(view.fields());
  for (std::size_t i = 0; i < scene.tool_sphere_count; ++i)
    text += line(fmt::format("tool sphere {}", i),
                 fmt::format("at {}, radius {:g} m", vector_text(scene.tool[i].position_m, " m"),
                             scene.tool[i].radius_m));
  return text +
         line("device", fmt::format("at {}, scale {:g}", vector_text(scene.device.position_m, " m"),
                                    scene.device.scale));
}

std::string grid_lines(const reading::SceneSnapshot& snapshot, std::uint32_t static_spheres) {
  const proto::GridShape& grid = snapshot.header.grid;
  const reading::GridOccupancy& filled = snapshot.occupancy;
  const double share = filled.cells == 0 ? 0.0
                                         : 100.0 * static_cast<double>(filled.occupied_cells) /
                                               static_cast<double>(filled.cells);
  std::string text =
      line("spheres", fmt::format("{} moving, {} static", grid.sphere_count, static_spheres));
  if (filled.cells == 0) return text + line("grid", "empty, or not consistent");
  for (std::uint32_t i = 0; i < grid.level_count; ++i)
    text += line(i == 0 ? "grid" : "",
                 fmt::format("{} cells, voxels of {:g} m", fmt::join(grid.levels[i].cells, " x "),
                             grid.levels[i].voxel_m));
  return text + line("occupancy",
                     fmt::format("{} of {} cells ({:.1f} %), {} spheres in the fullest",
                                 filled.occupied_cells, filled.cells, share, filled.fullest_cell));
}

std::string scene_lines(const reading::ObservedSegment& segment) {
  const auto snapshot = reading::read_snapshot(*segment.scene, 0);
  const std::string fixed = fixed_lines(*segment.scene);
  if (!snapshot) return fixed + line("snapshot", "none yet, or overtaken at each attempt");
  const std::uint64_t now_ns = realtime::monotonic_ns();
  const proto::SnapshotHeader& header = snapshot->header;
  const auto age = [&](std::uint64_t time_ns) {
    return ms_text(reading::age_of(time_ns, segment.summary.header->clock, now_ns));
  };
  std::string tool_age = "none";
  if (header.tool_time_ns != 0)
    tool_age = fmt::format(
        "{} at publication",
        ms_text(static_cast<double>(header.publish_time_ns[0] - header.tool_time_ns) * 1e-9));
  std::string ages;
  for (std::size_t i = 0; i < header.history_count; ++i)
    ages += (i == 0 ? "" : ", ") + age(header.publish_time_ns[i]);
  return fixed +
         line("snapshot",
              fmt::format("{}, {} contacts, step cost {}", snapshot->snapshot_id, header.contacts,
                          ms_text(static_cast<double>(header.step_ns) * 1e-9))) +
         line("age",
              fmt::format("state {}, published {}, tool sample {}", age(header.state_time_ns[0]),
                          age(header.publish_time_ns[0]), tool_age)) +
         line("history",
              fmt::format("{} snapshots, published {} ago", header.history_count, ages)) +
         grid_lines(*snapshot, segment.scene->static_grid().shape.sphere_count);
}

/// Of what the device tells, nothing of the rest.
std::string device_lines(const proto::DeviceFigures& device) {
  constexpr std::array<std::pair<std::uint32_t, std::string_view>, 5> kStatus = {
      {{STILLGRID_STATUS_MOTORS_ON, "motors on"},
       {STILLGRID_STATUS_ENABLED, "enabled"},
       {STILLGRID_STATUS_CALIBRATED, "calibrated"},
       {STILLGRID_STATUS_HOT, "hot"},
       {STILLGRID_STATUS_FAULT, "fault"}}};
  std::string status, text;
  for (const auto& [bit, name] : kStatus)
    if ((device.status_known & bit) != 0)
      status += fmt::format("{}{}{}", status.empty() ? "" : ", ",
                            (device.status & bit) != 0 ? "" : "not ", name);
  if (!status.empty()) text += line("status", status);
  if ((device.told & STILLGRID_STATE_TEMPERATURE) != 0)
    text += line("temperature", fmt::format("{:.1f} C", device.temperature_C));
  if ((device.told & STILLGRID_STATE_GRIPPER) != 0)
    text += line("gripper", fmt::format("open {:.4g} m, force {:.4g} N", device.gripper_m,
                                        device.gripper_force_N));
  if ((device.told & STILLGRID_STATE_AXES) != 0)
    text += line("axes", vector_text(device.axes, " of 1"));
  return text;
}

std::string tool_lines(const reading::ObservedSegment& segment) {
  const auto snapshot = reading::read_tool(*segment.tool);
  if (!snapshot) return line("state", "none yet, or overtaken at each attempt");
  const proto::ToolState& state = snapshot->state;
  const auto age_s =
      reading::age_of(state.time_ns, segment.summary.header->clock, realtime::monotonic_ns());
  return line("tick", fmt::format("{}, age {}", state.tick, ms_text(age_s))) +
         line("position", vector_text(state.position_m, " m")) +
         line("orientation", vector_text(state.orientation_xyzw, " (x, y, z, w)")) +
         line("velocity", vector_text(state.velocity_m_s, " m/s")) +
         line("force", vector_text(state.force_N, " N")) +
         line("buttons", fmt::format("{:#x}", state.buttons)) + device_lines(state.device);
}

std::string writer_text(const reading::SegmentSummary& summary) {
  if (summary.state == reading::SegmentState::kRefused) return "refused: " + summary.refusal;
  if (!summary.header) return std::string(name_of(summary.state));
  return fmt::format("{}, writer's pid {}", name_of(summary.state), summary.header->writer_pid);
}

}  // namespace

std::string detail_of(const std::string& session, const reading::ObservedSegment* scene,
                      const reading::ObservedSegment* tool) {
  std::string text = fmt::format("session {}\n", reading::printable(session));
  for (const auto& [segment, title] :
       {std::pair{scene, "scene, of sim_server"}, std::pair{tool, "tool, of haptic_server"}}) {
    if (segment == nullptr) {
      text += fmt::format("{}: none\n", title);
      continue;
    }
    text += fmt::format("{}: {}\n", title, writer_text(segment->summary));
    text += header_lines(segment->summary);
    if (segment->scene) text += scene_lines(*segment);
    if (segment->tool) text += tool_lines(*segment);
  }
  return text;
}

}  // namespace stillgrid::segment_inspect
