#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
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
      if (i >= before || !is_alike(label, labels_[i])) places.assign(came_ == 0 ? 4 : 0, state);
      if (came_ > 0) places.insert(places.begin(), state);
      places.resize(std::min<std::size_t>(places.size(), 4));
    }
    labels_ = snapshot.labels;
    fields_.resize(snapshot.fields.size());
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      auto state = snapshot.fields[i].state;
      if (came_ == 0) fields_[i].assign(3, state);
      // Of a turn's two quaternions the one that is nearer to that which was shown.
      auto& turn = state.orientation_xyzw;
      if (std::inner_product(std::begin(turn), std::end(turn),
                             std::begin(fields_[i][0].orientation_xyzw), 0.0F) < 0.0F)
        for (float& x : turn) x = -x;
      fields_[i].insert(fields_[i].begin(), state);
      fields_[i].resize(4);
    }
    last_ = snapshot;
    ++came_;
  }

  /// What is seen and should not be; empty if nothing.
  [[nodiscard]] std::string wrong_in(const SeenSnapshot& seen, double period_s) const {
    if (seen.header.snapshot_id != came_) return "its number";
    if (seen.records.size() != last_.motions.size()) return "the spheres' count";
    for (std::size_t i = 0; i < seen.records.size(); ++i) {
      if (!is_record_right(seen.records[i], i)) return "sphere " + std::to_string(i);
      if (!is_bound_right(seen.records[i], seen.bounds[i], period_s))
        return "the swept bound of sphere " + std::to_string(i);
    }
    return wrong_of_response(seen);
  }

 private:
  static bool is_alike(const Label& a, const Label& b) {
    return a.radius_m == b.radius_m && a.material == b.material && a.body == b.body;
  }

  [[nodiscard]] bool is_record_right(const proto::SphereRecord& record, std::size_t i) const {
    const std::vector<proto::SphereState>& places = places_[i];
    const Label& label = last_.labels[i];
    const auto is_at = [&](const std::array<float, 3>& place_m, std::size_t age) {
      return age < places.size() ? place_m == places[age].position_m : std::isnan(place_m[0]);
    };
    return are_same_bytes(record.newest, places[0]) && is_at(record.older[0].position_m, 1) &&
           is_at(record.older[1].position_m, 2) && is_at(record.oldest_position_m, 3) &&
           (places.size() < 2 || record.older[0].velocity_m_s == places[1].velocity_m_s) &&
           std::equal(record.predicted_velocity_m_s.begin(), record.predicted_velocity_m_s.end(),
                      last_.motions[i].predicted_velocity_m_s) &&
           record.radius_m == label.radius_m && record.material == label.material &&
           record.body == label.body && record.response == label.response;
  }

  /// Wherever it may be displayed.
  static bool is_bound_right(const proto::SphereRecord& record, const proto::SweptBound& bound,
                             double period_s) {
    const auto is_held = [&](const std::array<float, 3>& place_m, double later_s) {
      double away2_m2 = 0.0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double x =
            double{place_m[axis]} + later_s * double{record.predicted_velocity_m_s[axis]};
        away2_m2 += std::pow(x - double{bound.centre_m[axis]}, 2);
      }
      const double farthest_m = std::sqrt(away2_m2) + double{record.radius_m};
      return std::isnan(farthest_m) || farthest_m <= double{bound.bounding_radius_m} * (1.0 + 1e-6);
    };
    return is_held(record.newest.position_m, 0.0) && is_held(record.older[0].position_m, 0.0) &&
           is_held(record.older[1].position_m, 0.0) && is_held(record.oldest_position_m, 0.0) &&
           is_held(record.newest.position_m, proto::kPredictionPeriods * period_s) &&
           is_held(record.newest.position_m, -proto::kLongestPredictionLag_s);
  }

  template <class Seen, class Told>
  static bool are_same_arrays(const Seen* seen, std::size_t count, const std::vector<Told>& told) {
    return count == told.size() &&
           (count == 0 || std::memcmp(seen, told.data(), count * sizeof(Told)) == 0);
  }

  [[nodiscard]] std::string wrong_of_response(const SeenSnapshot& seen) const {
    const proto::SnapshotHeader& header = seen.header;
    if (header.prediction_ns != last_.prediction_ns) return "the prediction's period";
    if (!are_same_arrays(header.modes.data(), header.mode_count, last_.modes)) return "a mode";
    if (!are_same_arrays(seen.responses.data(), seen.responses.size(), last_.responses))
      return "a response";
    if (header.turning_count != last_.turning.size()) return "how many bodies turn";
    for (std::size_t i = 0; i < last_.turning.size(); ++i)
      if (std::memcmp(&header.turning[i], &last_.turning[i], sizeof last_.turning[i]) != 0)
        return "how a body turns";
    if (seen.fields.size() != last_.fields.size()) return "the fields' count";
    for (std::size_t i = 0; i < seen.fields.size(); ++i) {
      const proto::FieldRecord& record = seen.fields[i];
      for (std::size_t age = 0; age < 4; ++age)
        if (std::memcmp(&record.history[age], &fields_[i][age], sizeof fields_[i][age]) != 0)
          return "field " + std::to_string(i) + ", age " + std::to_string(age);
      const FieldMotion& told = last_.fields[i];
      if (!std::equal(told.predicted_velocity_m_s, told.predicted_velocity_m_s + 3,
                      record.predicted_velocity_m_s.begin()) ||
          !std::equal(told.predicted_angular_velocity_rad_s,
                      told.predicted_angular_velocity_rad_s + 3,
                      record.predicted_angular_velocity_rad_s.begin()) ||
          record.response != told.response)
        return "the prediction of field " + std::to_string(i);
    }
    return {};
  }

  std::uint64_t came_ = 0;
  std::vector<std::vector<proto::SphereState>> places_;  // newest first
  std::vector<Label> labels_;
  std::vector<std::vector<stillgrid_relay2_FieldState>> fields_;
  ToldSnapshot last_;
};

}  // namespace stillgrid::scene_relay
