// Reads whole snapshots of a running session, 2000 times a second, as a viewer would: each must be
// of one snapshot, and must continue the one before it sphere by sphere.
#include <CLI/CLI.hpp>
#include <cstring>
#include <iostream>
#include <nlohmann/json.hpp>
#include <vector>

#include "shared/collision/grid_query.hpp"
#include "shared/publication/scene_segment.hpp"
#include "shared/publication/segment_watch.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/realtime/stop_signal.hpp"

namespace stillgrid::soak {
namespace {

struct Snapshot {
  std::uint64_t epoch = 0;
  proto::SnapshotHeader header{};
  std::vector<proto::SphereRecord> spheres;
};

struct Counts {
  std::uint64_t reads = 0, accepted = 0, contended = 0, snapshots = 0, continued = 0, torn = 0;
};

bool is_same(const proto::SphereState& a, const proto::SphereState& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

/// Whether `after` shows in its past what `before` showed as its present.
bool continues(const Snapshot& before, const Snapshot& after) {
  if (before.spheres.size() != after.spheres.size()) return false;
  for (std::size_t i = 0; i < after.spheres.size(); ++i)
    if (!is_same(after.spheres[i].before, before.spheres[i].newest)) return false;
  return after.header.state_time_ns[1] == before.header.state_time_ns[0];
}

double_buffer::ReadResult read_snapshot(const publication::SceneView& view, Snapshot& snapshot) {
  snapshot.epoch = view.header().epoch;
  return double_buffer::read_latest(view.buffer(), [&](const std::uint64_t* payload) {
    snapshot.header = double_buffer::load_struct<proto::SnapshotHeader>(payload);
    const collision::GridView grid = view.moving_grid(payload, snapshot.header);
    snapshot.spheres.resize(grid.shape.sphere_count);
    for (std::size_t i = 0; i < snapshot.spheres.size(); ++i)
      snapshot.spheres[i] = collision::load_record(grid, static_cast<std::uint32_t>(i));
  });
}

/// Counts one read; keeps the snapshot if it is new.
void check(const publication::SceneView& view, Snapshot& fresh, Snapshot& last, Counts& counts) {
  ++counts.reads;
  const double_buffer::ReadResult read = read_snapshot(view, fresh);
  if (read.status == double_buffer::ReadStatus::kContended) ++counts.contended;
  if (read.status != double_buffer::ReadStatus::kAccepted) return;
  ++counts.accepted;
  const bool is_new =
      fresh.epoch != last.epoch || fresh.header.snapshot_id != last.header.snapshot_id;
  const bool is_next =
      fresh.epoch == last.epoch && fresh.header.snapshot_id == last.header.snapshot_id + 1;
  if (fresh.header.snapshot_id != read.snapshot_id || (is_next && !continues(last, fresh)))
    ++counts.torn;
  counts.continued += is_next ? 1 : 0;
  counts.snapshots += is_new ? 1 : 0;
  if (is_new) std::swap(fresh, last);
}

Counts watch_session(const std::string& session, double duration_s) {
  publication::SegmentWatch<publication::SceneView> watch(
      session, proto::SegmentKind::kScene, proto::kSceneLayoutHash, proto::Clock::kMonotonic,
      [](const std::string& line) { std::cerr << line << '\n'; });
  watch.start();
  realtime::PeriodicTimer timer(500'000);
  Counts counts;
  Snapshot fresh, last;
  const std::uint64_t end_ns = realtime::monotonic_ns() + realtime::to_ns(duration_s);
  while (realtime::monotonic_ns() < end_ns && !realtime::stop_requested()) {
    timer.wait();
    if (const publication::SceneView* view = watch.acquire()) check(*view, fresh, last, counts);
  }
  return counts;
}

int program_main(int argc, char** argv) {
  CLI::App app(
      "Checks that the snapshots of a running session are whole and continue each other.\n"
      "Prints counts as JSON; exit status 1 if one was torn or mixed.");
  std::string session;
  double duration_s = 1e8;
  app.add_option("--session", session, "Of the sim_server to watch")->required();
  app.add_option("--duration", duration_s, "s; default: until Ctrl-C");
  CLI11_PARSE(app, argc, argv);
  realtime::install_stop_signal();
  const Counts counts = watch_session(session, duration_s);
  const nlohmann::json json = {{"reads", counts.reads},         {"accepted", counts.accepted},
                               {"contended", counts.contended}, {"snapshots", counts.snapshots},
                               {"continued", counts.continued}, {"torn", counts.torn}};
  std::cout << json.dump() << '\n';
  return counts.torn == 0 && counts.snapshots > 0 ? 0 : 1;
}

}  // namespace
}  // namespace stillgrid::soak

int main(int argc, char** argv) {
  return stillgrid::soak::program_main(argc, argv);
}
