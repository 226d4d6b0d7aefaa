#include "sim_server/bodies/kinds/mesh_fields.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <exception>
#include <limits>
#include <map>
#include <new>
#include <stdexcept>
#include <utility>

#include "shared/realtime/stop_signal.hpp"
#include "shared/rendering/force_error.hpp"
#include "sim_server/bodies/kinds/body_in_world.hpp"
#include "sim_server/fields/contact_choice.hpp"
#include "sim_server/fields/field_cache.hpp"
#include "sim_server/fields/mesh_field.hpp"
#include "sim_server/fields/surface_points.hpp"
#include "sim_server/toml/refusal.hpp"

namespace stillgrid::bodies {
namespace {

constexpr std::size_t kMaxPoints = 500;

constexpr double kPress = 0.25;  // of the radius of the tool's sphere

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
      if (asked_of(body) == nullptr) reach_out(body);
    for (BodyDescription& body : bodies) {
      if (asked_of(body) == nullptr || !asked_of(body)->is_choice) continue;
      attempt(body, [&](RigidMeshBody& mesh) { choose(body, mesh); });
      if (!field_of(body)) reach_out(body);
    }
    for (BodyDescription& body : bodies) {
      if (asked_of(body) == nullptr || (asked_of(body)->is_choice && !field_of(body))) continue;
      AskedField& asked = *std::get<RigidMeshBody>(body.shape).asked_field;
      asked.measured.own_N_per_m =
          body.stiffness_scale * scene_.materials_N_per_m[static_cast<std::size_t>(body.material)];
      check_map(asked, file_);
      attempt(body, [&](RigidMeshBody& mesh) { make_one(body, mesh); });
    }
  }

 private:
  void reach_out(const BodyDescription& body) {
    margin_m_ = std::max(margin_m_, largest_radius_m(body));
  }

  template <class Try>
  void attempt(BodyDescription& body, Try&& attempted) {
    auto& mesh = std::get<RigidMeshBody>(body.shape);
    const AskedField& asked = *mesh.asked_field;
    try {
      attempted(mesh);
    } catch (const realtime::StopRequested&) {
      throw;
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      if (!asked.cell_m)
        throw toml::scene_error(file_, {asked.line, 1}, "body.contact", "'auto'",
                                "a mesh that can be met by a choice; " + std::string(error.what()));
      std::array<char, 40> value{};
      std::snprintf(value.data(), value.size(), "%.9g", *asked.cell_m);
      throw toml::scene_error(file_, {asked.line, 1}, "body.field.cell_m", value.data(),
                              "cells of a field that can be held; " + std::string(error.what()));
    }
  }

  /// A brick more than the spheres ask, so that what is near is found before it touches.
  [[nodiscard]] collision::FieldFineness fineness(const AskedField& asked, double cell_m) const {
    return {.cell_m = cell_m,
            .band_m = asked.band_m.value_or(std::max(scene_.largest_tool_radius_m, cell_m)),
            .margin_m = margin_m_ + proto::kBrickCells * cell_m};
  }

  void make_one(BodyDescription& body, RigidMeshBody& mesh) {
    const AskedField& asked = *mesh.asked_field;
    double time_s = 0.0;
    // What was chosen was made then, unless something larger may meet it now.
    if (!mesh.field || chosen_at_m_[&mesh] != margin_m_)
      mesh.field = made_or_kept(mesh, fineness(asked, *asked.cell_m), notes_, time_s);
    if (body.motion != Motion::kStatic)
      mesh.balls = fields::surface_points(mesh.surface, kMaxPoints);
    notes_.push_back(note_of(body, mesh, time_s));
  }

  void choose(BodyDescription& body, RigidMeshBody& mesh) {
    AskedField& asked = *mesh.asked_field;
    const bool moves = body.motion != Motion::kStatic;
    fields::ContactNeed need{.tool_radius_m = scene_.least_tool_radius_m,
                             .press_depth_m = kPress * scene_.least_tool_radius_m,
                             .max_error_share = asked.max_error_share,
                             .points = moves ? kMaxPoints : 0,
                             .steps_per_ms = moves ? 1e-3 / scene_.period_s : 0.0,
                             .cell_m = asked.cell_m,
                             .given_balls = mesh.balls,
                             .make_field = [&](double cell_m) {
                               double time_s = 0.0;
                               return made_or_kept(mesh, fineness(asked, cell_m), notes_, time_s);
                             }};
    fields::ContactChoice choice = fields::choose_contact(mesh.surface, need);
    mesh.field = choice.field;
    mesh.balls = std::move(choice.balls);
    mesh.contacts = std::move(choice.records);
    body.stiffness_scale *= choice.stiffness_scale;
    if (mesh.field) asked.cell_m = choice.cell_m;
    chosen_at_m_[&mesh] = margin_m_;
    std::array<char, 100> error{};
    std::snprintf(error.data(), error.size(), ": the force errs by %.2f JND; --explain tells why",
                  *choice.chosen.error_share / rendering::kJustNoticeable);
    notes_.push_back("body '" + body.name + "': contact chosen: " + choice.chosen.name +
                     error.data());
    if (choice.keeps_error) return;
    std::snprintf(error.data(), error.size(), "%.2f",
                  asked.max_error_share / rendering::kJustNoticeable);
    notes_.push_back("body '" + body.name + "': no model errs by at most " + error.data() +
                     " JND: this is the most accurate");
  }

  const FieldScene& scene_;
  const std::string& file_;
  std::vector<std::string>& notes_;
  double margin_m_;
  std::map<const RigidMeshBody*, double> chosen_at_m_;  // margins
};

}  // namespace

void make_fields(std::span<BodyDescription> bodies, const FieldScene& scene,
                 const std::string& file, std::vector<std::string>& notes) {
  const auto asks = [](const BodyDescription& body) { return asked_of(body) != nullptr; };
  if (std::any_of(bodies.begin(), bodies.end(), asks))
    FieldsOfScene(scene, file, notes).make(bodies);
}

}  // namespace stillgrid::bodies
