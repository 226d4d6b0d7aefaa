#pragma once

#include <unistd.h>

#include <Eigen/Core>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "proto/stillgrid.h"
#include "shared/publication/scene_segment.hpp"
#include "shared/publication/tool_segment.hpp"

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
    std::uint32_t capacity = 8, gives_inertia = 1;
    std::uint32_t clock = STILLGRID_REAL_TIME;
    std::uint32_t hands = 1;
  };

  Published(const std::string& name, const Options& options)
      : session_(own_session(name)),
        period_ns_(static_cast<std::uint64_t>(std::llround(options.period_s * 1e9))),
        poses_(options.hands) {
    open_tools(options);
    const stillgrid_material material{options.stiffness_N_per_m, options.damping_N_s_per_m,
                                      options.friction};
    const std::array<double, 4> ball{0.0, 0.0, 0.0, options.tool_radius_m};
    std::vector<stillgrid_hand> hands(options.hands);
    for (std::size_t i = 0; i < hands.size(); ++i) {
      hands[i].struct_size = sizeof(stillgrid_hand);
      hands[i].tool_count = 1;
      hands[i].tool_m = ball.data();
      if (hands.size() > 1) hands[i].name = i == 0 ? "left" : "right";
    }
    stillgrid_scene scene{};
    scene.struct_size = sizeof scene;
    scene.session = session_.c_str();
    scene.period_s = options.period_s;
    scene.sphere_capacity = options.capacity;
    scene.clock = options.clock;
    scene.gives_inertia = options.gives_inertia;
    scene.material_count = 1;
    scene.materials = &material;
    scene.hand_count = options.hands;
    scene.hands = hands.data();
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

  /// A tool's place and velocity in each tick of virtual time from now on.
  using Path = std::function<std::pair<Eigen::Vector3d, Eigen::Vector3d>(double time_s)>;
  void move(const Path& path, std::size_t hand = 0) { poses_[hand] = path; }
  void hold(const Eigen::Vector3d& position_m, std::size_t hand = 0) {
    move([=](double) { return std::pair(position_m, Eigen::Vector3d(Eigen::Vector3d::Zero())); },
         hand);
  }
  /// The next moment of virtual time: the tools have gone on to it. Returns it in s.
  double wait() {
    const std::uint64_t next_ns = is_begun_ ? time_ns_ + period_ns_ : 0;
    is_begun_ = true;
    for (; tick_ * proto::kPathTick_ns <= next_ns; ++tick_)
      for (std::size_t hand = 0; hand < tools_.size(); ++hand)
        if (poses_[hand]) show_tool(hand, tick_);
    int code = STILLGRID_AGAIN;
    for (int tries = 0; tries < 100 && code == STILLGRID_AGAIN; ++tries)
      code = stillgrid_publisher_wait(publisher_, &time_ns_);
    REQUIRE(code == STILLGRID_OK);
    REQUIRE(time_ns_ == next_ns);
    return 1e-9 * static_cast<double>(time_ns_);
  }
  void publish() { REQUIRE(stillgrid_publisher_publish(publisher_, 0) == STILLGRID_OK); }
  void respond(const stillgrid_response& response) {
    REQUIRE(stillgrid_publisher_set_responses(publisher_, 1, &response) == STILLGRID_OK);
  }

  [[nodiscard]] std::vector<stillgrid_push> pushes(double step_s) {
    std::vector<stillgrid_push> pushes(16);
    auto count = static_cast<std::uint32_t>(pushes.size());
    REQUIRE(stillgrid_publisher_pushes(publisher_, step_s, pushes.data(), &count) == STILLGRID_OK);
    pushes.resize(count);
    return pushes;
  }

  /// The newest snapshot of the segment.
  struct Snapshot {
    proto::SnapshotHeader header;
    std::vector<proto::SphereRecord> spheres;
    std::vector<std::byte> model, state;
    std::uint32_t hands = 0;
  };
  [[nodiscard]] Snapshot snapshot() const {
    auto reader = publication::SegmentReader::open(hand_session(0), proto::SegmentKind::kScene,
                                                   proto::kSceneLayoutHash);
    const publication::SceneView view(std::move(reader.value()));
    Snapshot snapshot;
    snapshot.model.assign(view.model().begin(), view.model().end());
    snapshot.hands = view.scene().hand_count;
    const auto read = double_buffer::read_latest(view.buffer(), [&](const std::uint64_t* payload) {
      snapshot.header = publication::load_snapshot(payload);
      const collision::GridView grid = view.moving_grid(payload, snapshot.header);
      view.copy_state(payload, snapshot.header, snapshot.state);
      snapshot.spheres.resize(grid.shape.sphere_count);
      for (std::size_t i = 0; i < snapshot.spheres.size(); ++i)
        snapshot.spheres[i] = double_buffer::load_struct<proto::SphereRecord>(
            grid.words + grid.layout.records + i * (sizeof(proto::SphereRecord) / 8));
    });
    REQUIRE(read.status == double_buffer::ReadStatus::kAccepted);
    return snapshot;
  }

 private:
  [[nodiscard]] std::string hand_session(std::size_t hand) const {
    return poses_.size() == 1 ? session_ : session_ + (hand == 0 ? "+left" : "+right");
  }
  void open_tools(const Options& options) {
    if (options.clock != STILLGRID_VIRTUAL_TIME) return;
    for (std::size_t hand = 0; hand < options.hands; ++hand) {
      auto& header = tools_
                         .emplace_back(std::make_unique<publication::ToolWriter>(
                             hand_session(hand), 1'000'000, proto::Clock::kVirtual, 0))
                         ->header();
      // The publisher never waits for them, and they are not at their end.
      for (std::uint64_t* promise : {&header.lockstep_sample_ns, &header.lockstep_event_ns})
        double_buffer::HardwareAtomics::store(*promise, proto::kNever - 1,
                                              std::memory_order_release);
    }
  }
  void show_tool(std::size_t hand, std::uint64_t tick) {
    const auto [position_m, velocity_m_s] = poses_[hand](1e-3 * static_cast<double>(tick));
    proto::ToolState state{};
    state.time_ns = tick * proto::kPathTick_ns;
    state.tick = state.path_number = tick;
    Eigen::Map<Eigen::Vector3d>(state.position_m.data()) = position_m;
    Eigen::Map<Eigen::Vector3d>(state.velocity_m_s.data()) = velocity_m_s;
    state.orientation_xyzw = {0.0, 0.0, 0.0, 1.0};
    tools_[hand]->publish(state);
  }

  std::string session_;
  std::uint64_t period_ns_, time_ns_ = 0, tick_ = 0;
  bool is_begun_ = false;
  std::vector<Path> poses_;  // one a hand
  std::vector<std::unique_ptr<publication::ToolWriter>> tools_;
  stillgrid_publisher* publisher_ = nullptr;
  std::uint32_t count_ = 0;
};

/// Returns the response of a free ball.
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
