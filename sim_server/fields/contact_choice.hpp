#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/collision/distance_field.hpp"
#include "sim_server/mesh/triangle_mesh.hpp"
#include "sim_server/spheres/ball.hpp"

namespace stillgrid::fields {

/// What a rigid mesh may be met through.
enum class ContactModel { kField, kSpheres, kEvenSpheres, kGivenSpheres };

/// What became of one way to meet a mesh.
struct ContactTrial {
  ContactModel model = ContactModel::kField;
  double size_m = 0.0;       // cell, tolerance or spacing; 0 of given spheres
  std::size_t parts = 0;     // bricks or spheres
  double bytes = 0.0;        // that are published of it
  double error_share = 0.0;  // of the exact force, rms
  double tick_ns = 0.0;      // predicted, of a tick in contact that finds the caches cold
  double step_ns = 0.0;      // predicted, of a step of the simulation
  double cost_ns = 0.0;      // of both in a simulated millisecond
  std::string refusal = {};  // why it was not chosen; empty: chosen
};

/// The model chosen for a mesh, and what was seen on the way.
struct ContactChoice {
  std::vector<ContactTrial> trials;
  bool keeps_error = false;  // else none does, and the most accurate is taken
  std::shared_ptr<const collision::DistanceField> field;  // null: it is met through balls
  std::vector<spheres::Ball> balls;
  double stiffness_scale = 1.0;  // of their contacts, with which their force errs least
};

/// What is asked of a choice, and what it may use. Lengths in the mesh's frame.
struct ContactNeed {
  double tool_radius_m = 0.0;
  double press_depth_m = 0.0;                   // pressed half, once and twice as deep
  double max_error_share = 0.0;                 // of the exact force, rms
  std::size_t points = 0;                       // beside a field, of a body that moves
  double steps_per_ms = 0.0;                    // of the simulation; 0: the body never moves
  std::optional<double> cell_m = {};            // of the only field that is tried
  std::vector<spheres::Ball> given_balls = {};  // the only ones that are tried, if there are any
  /// Throws std::invalid_argument where a field would take too much.
  std::function<std::shared_ptr<const collision::DistanceField>(double cell_m)> make_field;
};

/// Of a tick in contact whose caches are cold, and of a step: counted, so that the same scene is
/// answered alike on every machine. A tick's constants are fitted to the times with flushed caches
/// of contact_model_figures on one machine, which they meet to 35 %
/// (docs/algorithms/distance_fields.md); elsewhere they only say which is cheaper. A step's is an
/// estimate.
[[nodiscard]] double predicted_tick_ns_of_field() noexcept;
/// spheres: of the body, 1 at least; touched: those that the tool overlaps, on average.
[[nodiscard]] double predicted_tick_ns_of_spheres(double spheres, double touched) noexcept;
/// spheres: of the body, or points.
[[nodiscard]] double predicted_step_ns(double spheres) noexcept;

/// Chooses the cheapest model whose force on a tool sphere, over the mesh's whole surface and at
/// three depths, errs by no more than need.max_error_share from the exact mesh's.
///
/// Fields are tried from coarse to fine up to the first that keeps the error, spheres up to the
/// first that would cost more than it: decompositions, then even ones, each with the one stiffness
/// that suits it best. The same mesh and need give the same choice. Throws std::invalid_argument
/// where nothing can be made or no place can be pressed; StopRequested. Pre: closed.
[[nodiscard]] ContactChoice choose_contact(const mesh::TriangleMesh& closed,
                                           const ContactNeed& need);

/// Its name in words, with its size: "field, cells of 2 mm".
[[nodiscard]] std::string describe(const ContactTrial& trial);

}  // namespace stillgrid::fields
