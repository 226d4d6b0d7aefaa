#pragma once

#include <unistd.h>

#include <Eigen/Core>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "proto/stillgrid.h"
#include "shared/publication/scene_segment.hpp"
#include "shared/publication/tool_segment.hpp"
#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::library {

/// A session's name that no other test has.
inline std::string own_session(const std::string& name) {
  return "library-" + name + "-" + std::to_string(::getpid());
}

/// A publisher of one material, a tool of one ball, and who holds the tool.
class Published {
 public:
  struct Options {
    double stiffness_N_per_m = 500.0, damping_N_s_per_m = 0.0, friction = 0.0;
    double period_s = 0.01, tool_radius_m = 0.005;
    std::uint32_t capacity = 8, predicts = 1;
  };

  Published(const std::string& name, const Options& options)
      : session_(own_session(name)), tool_(session_, 1'000'000, proto::Clock::kMonotonic, 0) {
    const stillgrid_material material{options.stiffness_N_per_m, options.damping_N_s_per_m,
                                      options.friction, 1e-3};
    const std::array<double, 4> ball{0.0, 0.0, 0.0, options.tool_radius_m};
    stillgrid_hand hand{};
    hand.struct_size = sizeof hand;
    hand.tool_count = 1;
    hand.tool_m = ball.data();
    stillgrid_scene scene{};
    scene.struct_size = sizeof scene;
    scene.session = session_.c_str();
    scene.period_s = options.period_s;
    scene.sphere_capacity = options.capacity;
    scene.predicts = options.predicts;
    scene.material_count = 1;
    scene.materials = &material;
    scene.hand_count = 1;
    scene.hands = &hand;
    REQUIRE(stillgrid_publisher_open(&scene, &publisher_) == STILLGRID_OK);
  }
  ~Published() { stillgrid_publisher_close(publisher_); }
  Published(const Published&) = delete;
  Published& operator=(const Published&) = delete;
  Published(Published&&) = delete;
  Published& operator=(Published&&) = delete;

  operator stillgrid_publisher*() const { return publisher_; }  // NOLINT: as a caller has it

  void declare(const std::vector<double>& radii_m, const std::vector<std::uint32_t>& bodies) {
    stillgrid_shapes shapes{};
    shapes.struct_size = sizeof shapes;
    shapes.count = static_cast<std::uint32_t>(radii_m.size());
    shapes.radii_m = radii_m.data();
    shapes.bodies = bodies.data();
    REQUIRE(stillgrid_publisher_set_shapes(publisher_, &shapes) == STILLGRID_OK);
    count_ = shapes.count;
  }

  void place(const std::vector<Eigen::Vector3d>& positions_m,
             const std::vector<Eigen::Vector3d>& velocities_m_s) {
    REQUIRE(stillgrid_publisher_set_spheres(publisher_, count_, positions_m.front().data(),
                                            velocities_m_s.front().data()) == STILLGRID_OK);
  }

  /// Puts the tool there, at rest, and waits until the publisher sees it.
  void hold(const Eigen::Vector3d& position_m) {
    proto::ToolState state{};
    state.time_ns = realtime::monotonic_ns();
    state.tick = ++tick_;
    state.position_m = {position_m.x(), position_m.y(), position_m.z()};
    state.orientation_xyzw = {0.0, 0.0, 0.0, 1.0};
    tool_.publish(state);
    stillgrid_tool seen{};
    seen.struct_size = sizeof seen;
    for (int tries = 0; tries < 10'000; ++tries) {
      if (stillgrid_publisher_tool(publisher_, 0, &seen) == STILLGRID_OK && seen.tick == tick_)
        return;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    FAIL("the tool was not seen");
  }

  [[nodiscard]] std::vector<stillgrid_push> pushes(double step_s) {
    std::vector<stillgrid_push> pushes(16);
    auto count = static_cast<std::uint32_t>(pushes.size());
    REQUIRE(stillgrid_publisher_pushes(publisher_, step_s, pushes.data(), &count) == STILLGRID_OK);
    pushes.resize(count);
    return pushes;
  }

  /// What stands in the segment.
  struct Snapshot {
    proto::SnapshotHeader header;
    std::vector<proto::SphereRecord> spheres;
  };
  [[nodiscard]] Snapshot snapshot() const {
    auto reader = publication::SegmentReader::open(session_, proto::SegmentKind::kScene,
                                                   proto::kSceneLayoutHash);
    const publication::SceneView view(std::move(reader.value()));
    Snapshot snapshot;
    const auto read = double_buffer::read_latest(view.buffer(), [&](const std::uint64_t* payload) {
      snapshot.header = publication::load_snapshot(payload);
      const collision::GridView grid = view.moving_grid(payload, snapshot.header);
      snapshot.spheres.resize(grid.shape.sphere_count);
      for (std::size_t i = 0; i < snapshot.spheres.size(); ++i)
        snapshot.spheres[i] = double_buffer::load_struct<proto::SphereRecord>(
            grid.words + grid.layout.records + i * (sizeof(proto::SphereRecord) / 8));
    });
    REQUIRE(read.status == double_buffer::ReadStatus::kAccepted);
    return snapshot;
  }

 private:
  std::string session_;
  publication::ToolWriter tool_;
  stillgrid_publisher* publisher_ = nullptr;
  std::uint32_t count_ = 0;
  std::uint64_t tick_ = 0;
};

/// Of a free ball.
inline stillgrid_response ball_response(std::uint32_t body, const Eigen::Vector3d& centre_m,
                                        double mass_kg, double radius_m) {
  stillgrid_response response{};
  response.body = body;
  Eigen::Map<Eigen::Vector3d>(response.centre_m) = centre_m;
  for (std::size_t i = 0; i < 3; ++i) response.inverse_inertia[7 * i] = 1.0 / mass_kg;
  for (std::size_t i = 3; i < 6; ++i)
    response.inverse_inertia[7 * i] = 2.5 / (mass_kg * radius_m * radius_m);
  return response;
}

}  // namespace stillgrid::library
