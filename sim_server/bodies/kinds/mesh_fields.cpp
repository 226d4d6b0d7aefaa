#include "sim_server/bodies/kinds/mesh_fields.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <exception>
#include <limits>
#include <new>
#include <stdexcept>
#include <utility>

#include "shared/realtime/stop_signal.hpp"
#include "sim_server/bodies/kinds/body_in_world.hpp"
#include "sim_server/fields/field_cache.hpp"
#include "sim_server/fields/mesh_field.hpp"
#include "sim_server/fields/surface_points.hpp"
#include "sim_server/toml/refusal.hpp"

namespace stillgrid::bodies {
namespace {

constexpr std::size_t kMaxPoints = 500;
constexpr double kBeyondTool = 2.0;  // cells: a proxy is a radius from what it touches

/// The range of a map's stiffness, and of how many places; nothing without a map.
std::string note_of(const fields::MeasuredSurface& measured) {
  if (measured.places.empty()) return "";
  const auto [least, most] =
      std::ranges::minmax(measured.places, {}, &fields::StiffnessPlace::stiffness_N_per_m);
  std::array<char, 120> text{};
  std::snprintf(text.data(), text.size(), ", %.4g to %.4g N/m by %zu places, elsewhere %.4g N/m",
                least.stiffness_N_per_m, most.stiffness_N_per_m, measured.places.size(),
                measured.own_N_per_m);
  return text.data();
}

/// A field holds its stiffness over the body's own.
void check_map(const AskedField& asked, const std::string& file) {
  const double most_N_per_m = 1e3 * asked.measured.own_N_per_m;
  for (const fields::StiffnessPlace& place : asked.measured.places) {
    if (place.stiffness_N_per_m <= most_N_per_m) continue;
    std::array<char, 2 * 40> value{}, expected{};
    std::snprintf(value.data(), value.size(), "%.9g", place.stiffness_N_per_m);
    std::snprintf(expected.data(), expected.size(), "at most 1000 times the body's own %.6g N/m",
                  asked.measured.own_N_per_m);
    throw toml::scene_error(file, {asked.line, 1}, "body.field.stiffness_map", value.data(),
                            expected.data());
  }
}

std::string note_of(const BodyDescription& body, const RigidMeshBody& mesh, double time_s) {
  const proto::FieldShape& shape = mesh.field->shape();
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(), "field of %u bricks, %.3g MiB, cell %.3g m",
                shape.fine_count, static_cast<double>(mesh.field->bytes()) / 1048576.0,
                double{shape.brick_m} / proto::kBrickCells);
  std::string note = "body '" + body.name + "': " + text.data();
  note += note_of(mesh.asked_field->measured);
  if (!mesh.balls.empty()) note += ", " + std::to_string(mesh.balls.size()) + " points";
  if (time_s == 0.0) return note + ", made before";
  std::snprintf(text.data(), text.size(), ", in %.2f s", time_s);
  return note + text.data();
}

const AskedField* asked_of(const BodyDescription& body) {
  const auto* const mesh = std::get_if<RigidMeshBody>(&body.shape);
  return mesh != nullptr && mesh->asked_field ? &*mesh->asked_field : nullptr;
}

double largest_radius_m(const BodyDescription& body) {
  double largest_m = 0.0;
  for (const SphereBinding& sphere : pack_spheres(body))
    largest_m = std::max(largest_m, sphere.radius_m);
  return largest_m;
}

/// What was made before, with no time, or what is made now, which is kept if it took long.
std::shared_ptr<const collision::DistanceField> made_or_kept(
    const RigidMeshBody& mesh, const collision::FieldFineness& fineness,
    std::vector<std::string>& notes, double& time_s) {
  constexpr double kWorthKeeping_s = 1.0;
  const AskedField& asked = *mesh.asked_field;
  const fields::FieldCache cache(asked.folder, mesh.surface, fineness, asked.measured);
  time_s = 0.0;
  if (auto kept = cache.read())
    return std::make_shared<const collision::DistanceField>(*std::move(kept));
  const auto start = std::chrono::steady_clock::now();
  auto made = std::make_shared<const collision::DistanceField>(
      fields::make_mesh_field(mesh.surface, fineness, asked.measured));
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
  time_s = std::max(time.count(), std::numeric_limits<double>::min());
  if (time_s < kWorthKeeping_s) return made;
  try {
    cache.write(*made);
  } catch (const std::runtime_error& error) {
    notes.push_back(std::string("a field is not kept for the next time: ") + error.what());
  }
  return made;
}

/// Makes the fields of one scene.
class FieldsOfScene {
 public:
  FieldsOfScene(const FieldScene& scene, const std::string& file, std::vector<std::string>& notes)
      : scene_(scene), file_(file), notes_(notes), margin_m_(scene.largest_tool_radius_m) {}

  void make(std::span<BodyDescription> bodies) {
    // Points of fields' bodies stick out by no more than they are small.
    for (const BodyDescription& body : bodies)
      if (asked_of(body) == nullptr) margin_m_ = std::max(margin_m_, largest_radius_m(body));
    for (BodyDescription& body : bodies) {
      if (asked_of(body) == nullptr) continue;
      auto& mesh = std::get<RigidMeshBody>(body.shape);
      AskedField& asked = *mesh.asked_field;
      asked.measured.own_N_per_m =
          body.stiffness_scale * scene_.materials_N_per_m[static_cast<std::size_t>(body.material)];
      check_map(asked, file_);
      make_one(body, mesh);
    }
  }

 private:
  /// A brick more than the spheres ask, so that what is near is found before it touches.
  [[nodiscard]] collision::FieldFineness fineness(const RigidMeshBody& mesh) const {
    const AskedField& asked = *mesh.asked_field;
    const double band_m = asked.band_m.value_or(scene_.largest_tool_radius_m);
    const double cell_m =
        asked.cell_m
            ? *asked.cell_m
            : fields::default_cell_m(mesh.surface, scene_.least_tool_radius_m, band_m, margin_m_);
    return {.cell_m = cell_m,
            .band_m = asked.band_m.value_or(band_m + kBeyondTool * cell_m),
            .margin_m = margin_m_ + proto::kBrickCells * cell_m};
  }

  void make_one(BodyDescription& body, RigidMeshBody& mesh) {
    const collision::FieldFineness fineness_m = fineness(mesh);
    try {
      double time_s = 0.0;
      mesh.field = made_or_kept(mesh, fineness_m, notes_, time_s);
      if (body.motion != Motion::kStatic)
        mesh.balls = fields::surface_points(mesh.surface, kMaxPoints);
      notes_.push_back(note_of(body, mesh, time_s));
    } catch (const realtime::StopRequested&) {
      throw;
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      std::array<char, 40> value{};
      std::snprintf(value.data(), value.size(), "%.9g", fineness_m.cell_m);
      throw toml::scene_error(file_, {mesh.asked_field->line, 1}, "body.field.cell_m", value.data(),
                              "cells of a field that can be held; " + std::string(error.what()));
    }
  }

  const FieldScene& scene_;
  const std::string& file_;
  std::vector<std::string>& notes_;
  double margin_m_;
};

}  // namespace

void make_fields(std::span<BodyDescription> bodies, const FieldScene& scene,
                 const std::string& file, std::vector<std::string>& notes) {
  const auto asks = [](const BodyDescription& body) { return asked_of(body) != nullptr; };
  if (std::any_of(bodies.begin(), bodies.end(), asks))
    FieldsOfScene(scene, file, notes).make(bodies);
}

}  // namespace stillgrid::bodies
