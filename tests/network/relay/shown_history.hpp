#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "shared/tools/scene_relay/told_snapshot.hpp"
#include "tests/network/relay/relayed_scene.hpp"

namespace stillgrid::scene_relay {

/// What a reader shall find after these snapshots came, said once more in plain words: a sphere's
/// history is that of the snapshots that came since it came.
class ShownHistory {
 public:
  void take(const ToldSnapshot& snapshot) {
    const std::size_t before = places_.size();
    places_.resize(snapshot.motions.size());
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const Motion& motion = snapshot.motions[i];
      proto::SphereState state{std::to_array(motion.position_m),
                               std::to_array(motion.velocity_m_s)};
      const Label& label = snapshot.labels[i];
      std::vector<proto::SphereState>& places = places_[i];
      if (i >= before || !is_alike(label, labels_[i])) places.assign(came_ == 0 ? 2 : 0, state);
      if (came_ > 0) places.insert(places.begin(), state);
      places.resize(std::min<std::size_t>(places.size(), 2));
    }
    labels_ = snapshot.labels;
    fields_.resize(snapshot.fields.size());
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      auto state = snapshot.fields[i];
      if (came_ == 0) fields_[i].assign(1, state);
      // Of a turn's two quaternions the one that is nearer to that which was shown.
      auto& turn = state.orientation_xyzw;
      if (std::inner_product(std::begin(turn), std::end(turn),
                             std::begin(fields_[i][0].orientation_xyzw), 0.0F) < 0.0F)
        for (float& x : turn) x = -x;
      fields_[i].insert(fields_[i].begin(), state);
      fields_[i].resize(2);
    }
    last_ = snapshot;
    ++came_;
  }

  /// What is seen and should not be; empty if nothing.
  [[nodiscard]] std::string wrong_in(const SeenSnapshot& seen) const {
    if (seen.header.snapshot_id != came_) return "its number";
    if (seen.records.size() != last_.motions.size()) return "the spheres' count";
    for (std::size_t i = 0; i < seen.records.size(); ++i) {
      if (!is_record_right(seen.records[i], i)) return "sphere " + std::to_string(i);
      if (!is_bound_right(seen.records[i], seen.bounds[i]))
        return "the swept bound of sphere " + std::to_string(i);
    }
    return wrong_of_rest(seen);
  }

 private:
  static bool is_alike(const Label& a, const Label& b) {
    return a.radius_m == b.radius_m && a.material == b.material && a.body == b.body;
  }

  [[nodiscard]] bool is_record_right(const proto::SphereRecord& record, std::size_t i) const {
    const std::vector<proto::SphereState>& places = places_[i];
    const Label& label = last_.labels[i];
    const bool was_there = places.size() > 1;
    return are_same_bytes(record.newest, places[0]) &&
           (was_there ? are_same_bytes(record.before, places[1])
                      : std::isnan(record.before.position_m[0])) &&
           record.radius_m == label.radius_m && record.material == label.material &&
           record.body == label.body;
  }

  /// Wherever it may be displayed.
  static bool is_bound_right(const proto::SphereRecord& record, const proto::SweptBound& bound) {
    const auto is_held = [&](const std::array<float, 3>& place_m) {
      double away2_m2 = 0.0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        away2_m2 += std::pow(double{place_m[axis]} - double{bound.centre_m[axis]}, 2);
      const double farthest_m = std::sqrt(away2_m2) + double{record.radius_m};
      return std::isnan(farthest_m) || farthest_m <= double{bound.bounding_radius_m} * (1.0 + 1e-6);
    };
    return is_held(record.newest.position_m) && is_held(record.before.position_m);
  }

  [[nodiscard]] std::string wrong_of_rest(const SeenSnapshot& seen) const {
    if (seen.fields.size() != last_.fields.size()) return "the fields' count";
    for (std::size_t i = 0; i < seen.fields.size(); ++i)
      for (std::size_t age = 0; age < 2; ++age)
        if (std::memcmp(&seen.fields[i].history[age], &fields_[i][age], sizeof fields_[i][age]) !=
            0)
          return "field " + std::to_string(i) + ", age " + std::to_string(age);
    const auto told = std::as_bytes(std::span(last_.state));
    if (!std::ranges::equal(seen.state, told)) return "the state";
    if (seen.header.state_tick != last_.state_tick || seen.header.state_hash != last_.state_hash)
      return "the state's tick or hash";
    return {};
  }

  std::uint64_t came_ = 0;
  std::vector<std::vector<proto::SphereState>> places_;  // newest first
  std::vector<Label> labels_;
  std::vector<std::vector<stillgrid_relay3_FieldState>> fields_;
  ToldSnapshot last_;
};

}  // namespace stillgrid::scene_relay
