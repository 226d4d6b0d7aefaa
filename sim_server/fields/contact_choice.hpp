#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "shared/collision/distance_field.hpp"
#include "sim_server/choice/record.hpp"
#include "sim_server/mesh/triangle_mesh.hpp"
#include "sim_server/spheres/ball.hpp"

namespace stillgrid::fields {

/// The contact model chosen for a mesh, and the records of all candidates.
struct ContactChoice {
  std::vector<choice::Record> records;
  choice::Record chosen;
  bool keeps_error = false;  // else no candidate does, and the most accurate is chosen
  std::shared_ptr<const collision::DistanceField> field;  // null: spheres are chosen
  double cell_m = 0.0;                                    // of the field
  std::vector<spheres::Ball> balls;
  double stiffness_scale = 1.0;  // of contacts with the spheres
};

/// Limits and material of a choice. Lengths in the mesh's frame.
struct ContactNeed {
  double tool_radius_m = 0.0;
  double press_depth_m = 0.0;                   // pressed half, once and twice as deep
  double max_error_share = 0.0;                 // of the exact force, rms
  std::size_t points = 0;                       // beside a field, of a body that moves
  double steps_per_ms = 0.0;                    // of the simulation; 0: the body never moves
  std::optional<double> cell_m = {};            // the only field that is tried
  std::vector<spheres::Ball> given_balls = {};  // the only spheres that are tried, if there are any
  /// Throws std::invalid_argument if the field takes too much.
  std::function<std::shared_ptr<const collision::DistanceField>(double cell_m)> make_field;
};

/// Chooses the cheapest model by counted work whose force on a tool sphere, over the mesh's surface
/// and at three depths, errs by no more than need.max_error_share from the exact mesh's.
///
/// Fields are tried from coarse to fine up to the first that keeps the error; then the given
/// spheres, or decompositions, each with the stiffness that errs least. The same mesh and need give
/// the same choice. Throws std::invalid_argument where nothing can be made or no place can be
/// pressed; StopRequested. Pre: closed.
[[nodiscard]] ContactChoice choose_contact(const mesh::TriangleMesh& closed,
                                           const ContactNeed& need);

}  // namespace stillgrid::fields
