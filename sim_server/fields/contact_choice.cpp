#include "sim_server/fields/contact_choice.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "shared/collision/voxel_grid.hpp"
#include "sim_server/fields/field_force.hpp"
#include "sim_server/spheres/decomposition.hpp"
#include "sim_server/spheres/felt_error.hpp"
#include "sim_server/spheres/sampling.hpp"

namespace stillgrid::fields {
namespace {

constexpr std::size_t kSamples = 2000;
constexpr std::array kDepths = {0.5, 1.0, 2.0};  // of the press

// Parts of the mesh's longest side, each about 0.7 of the one before.
constexpr std::array kCells = {12.0, 17.0, 24.0, 34.0, 48.0, 68.0, 96.0, 136.0, 192.0};
constexpr std::array kTolerances = {20.0, 40.0, 80.0, 160.0};
constexpr std::array kSpacings = {20.0, 28.0, 40.0, 57.0, 80.0, 113.0};

constexpr double kFieldTick_ns = 3400.0;
constexpr double kLeastTick_ns = 1500.0, kDoubledTick_ns = 620.0, kTouchedTick_ns = 600.0;
constexpr double kSphereStep_ns = 160.0;

/// One of the trials, with what it would be met through.
struct Made {
  ContactTrial trial;
  std::shared_ptr<const collision::DistanceField> field = nullptr;
  std::vector<spheres::Ball> balls = {};
  double stiffness_scale = 1.0;
};

class Choosing {
 public:
  Choosing(const mesh::TriangleMesh& closed, const ContactNeed& need) : mesh_(closed), need_(need) {
    std::array<double, kDepths.size()> depths_m{};
    for (std::size_t i = 0; i < depths_m.size(); ++i) depths_m[i] = kDepths[i] * need.press_depth_m;
    const mesh::MeshDistance distance(closed);
    places_ = spheres::press_everywhere(closed, distance, kSamples, need.tool_radius_m, depths_m);
    if (places_.tool_m.empty())
      throw std::invalid_argument("no place that the tool's sphere can reach");
    for (const Eigen::Vector3d& vertex_m : closed.vertices_m) box_m_.extend(vertex_m);
  }

  ContactChoice choose() {
    try_fields();
    if (!need_.given_balls.empty())
      (void)try_balls({.model = ContactModel::kGivenSpheres}, need_.given_balls);
    else
      try_spheres();
    if (made_.empty()) throw std::invalid_argument("neither a field nor spheres can be made of it");
    return taken();
  }

 private:
  void price(ContactTrial& trial, double step_spheres) const {
    if (need_.steps_per_ms > 0.0) trial.step_ns = predicted_step_ns(step_spheres);
    trial.cost_ns = trial.tick_ns + need_.steps_per_ms * trial.step_ns;
  }
  [[nodiscard]] bool keeps(const ContactTrial& trial) const {
    return trial.error_share <= need_.max_error_share;
  }

  void try_fields() {
    const double side_m = box_m_.sizes().maxCoeff();
    std::vector<double> cells_m;
    for (const double part : kCells) cells_m.push_back(side_m / part);
    if (need_.cell_m) cells_m = {*need_.cell_m};
    for (const double cell_m : cells_m) {
      Made made{.trial = {.model = ContactModel::kField, .size_m = cell_m}};
      try {
        made.field = need_.make_field(cell_m);
      } catch (const std::invalid_argument&) {
        if (need_.cell_m) throw;
        return;  // finer ones take more
      }
      const collision::FieldView view = made.field->view();
      made.trial.parts = made.field->shape().fine_count;
      made.trial.bytes = static_cast<double>(made.field->bytes());
      made.trial.error_share = spheres::unscaled_error(places_, [&](const Eigen::Vector3d& tool_m) {
                                 return unit_force_m(view, tool_m, need_.tool_radius_m);
                               }).share;
      made.trial.tick_ns = predicted_tick_ns_of_field();
      price(made.trial, static_cast<double>(need_.points));
      made_.push_back(std::move(made));
      if (keeps(made_.back().trial)) return;
    }
  }

  /// Of the cheapest model so far that keeps the error; infinite: none does.
  [[nodiscard]] double least_cost_ns() const {
    double least_ns = std::numeric_limits<double>::infinity();
    for (const Made& made : made_)
      if (keeps(made.trial)) least_ns = std::min(least_ns, made.trial.cost_ns);
    return least_ns;
  }

  void try_spheres() {
    const double diagonal_m = box_m_.diagonal().norm();
    for (const double part : kTolerances)
      if (!try_balls({.model = ContactModel::kSpheres, .size_m = diagonal_m / part},
                     spheres::decompose(mesh_, diagonal_m / part).balls))
        break;
    for (const double part : kSpacings) {
      const double spacing_m = diagonal_m / part;
      std::vector<spheres::Ball> even = spheres::firm_surface_balls_if_any(mesh_, spacing_m);
      if (even.empty()) continue;
      if (!try_balls({.model = ContactModel::kEvenSpheres, .size_m = spacing_m}, std::move(even)))
        break;
    }
  }

  /// Whether finer ones of the kind may still be the cheapest.
  bool try_balls(ContactTrial trial, std::vector<spheres::Ball> balls) {
    const spheres::BallBody body = spheres::make_ball_body(balls, need_.tool_radius_m);
    double touched = 0.0;
    for (const Eigen::Vector3d& tool_m : places_.tool_m)
      for (const std::uint32_t ball : spheres::balls_near(body.grid, tool_m))
        touched +=
            (balls[ball].centre_m - tool_m).norm() < balls[ball].radius_m + need_.tool_radius_m
                ? 1.0
                : 0.0;
    trial.parts = balls.size();
    trial.bytes = 8.0 * static_cast<double>(collision::grid_layout(0, balls.size()).total_words);
    trial.tick_ns = predicted_tick_ns_of_spheres(
        static_cast<double>(balls.size()), touched / static_cast<double>(places_.tool_m.size()));
    price(trial, static_cast<double>(balls.size()));
    const spheres::FeltError error = spheres::felt_error(
        places_,
        [&](const Eigen::Vector3d& tool_m) { return spheres::unit_force_m(body, tool_m); });
    trial.error_share = error.share;
    const bool goes_on = trial.cost_ns < least_cost_ns();
    // What does not push at all is no model, however much may err.
    if (error.stiffness_scale > 0.0)
      made_.push_back(
          {.trial = trial, .balls = std::move(balls), .stiffness_scale = error.stiffness_scale});
    return goes_on;
  }

  ContactChoice taken() {
    ContactChoice choice;
    choice.keeps_error = std::isfinite(least_cost_ns());
    const auto is_better = [&](const Made& a, const Made& b) {
      if (!choice.keeps_error) return a.trial.error_share < b.trial.error_share;
      if (keeps(a.trial) != keeps(b.trial)) return keeps(a.trial);
      if (a.trial.cost_ns != b.trial.cost_ns) return a.trial.cost_ns < b.trial.cost_ns;
      return a.trial.bytes < b.trial.bytes;
    };
    const auto best = std::min_element(made_.begin(), made_.end(), is_better);
    for (Made& made : made_) {
      if (&made != &*best)
        made.trial.refusal = !choice.keeps_error ? "errs more"
                             : keeps(made.trial) ? "costs more"
                                                 : "misses the error";
      choice.trials.push_back(made.trial);
    }
    choice.field = best->field;
    choice.balls = std::move(best->balls);
    choice.stiffness_scale = best->stiffness_scale;
    return choice;
  }

  const mesh::TriangleMesh& mesh_;
  const ContactNeed& need_;
  spheres::ExactForces places_;
  Eigen::AlignedBox3d box_m_;
  std::vector<Made> made_;
};

}  // namespace

double predicted_tick_ns_of_field() noexcept {
  return kFieldTick_ns;
}

double predicted_tick_ns_of_spheres(double spheres, double touched) noexcept {
  return std::max(kLeastTick_ns,
                  kDoubledTick_ns * (std::log2(spheres) - 1.5) + kTouchedTick_ns * touched);
}

double predicted_step_ns(double spheres) noexcept {
  return kSphereStep_ns * spheres;
}

ContactChoice choose_contact(const mesh::TriangleMesh& closed, const ContactNeed& need) {
  return Choosing(closed, need).choose();
}

std::string describe(const ContactTrial& trial) {
  constexpr std::array kNames = {"field, cells of", "spheres within", "even spheres every"};
  if (trial.model == ContactModel::kGivenSpheres) return "spheres as given";
  std::array<char, 60> text{};
  std::snprintf(text.data(), text.size(), "%s %.3g mm",
                kNames[static_cast<std::size_t>(trial.model)], 1e3 * trial.size_m);
  return text.data();
}

}  // namespace stillgrid::fields
