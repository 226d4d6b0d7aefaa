#include "sim_server/session.hpp"

#include <spdlog/spdlog.h>

#include <utility>
#include <vector>

#include "shared/publication/hands.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "sim_server/published_scene.hpp"

namespace stillgrid::sim_server {

HandSession::HandSession(std::string session, publication::SessionLock lock,
                         const publication::StaticScene& fixed, std::size_t spheres,
                         std::uint64_t period_ns, proto::Clock clock, std::uint64_t start_ns,
                         std::optional<gid_t> readers)
    : name_(std::move(session)),
      writer_(std::move(lock), fixed, spheres, period_ns, clock, start_ns, readers),
      tool_(name_, proto::SegmentKind::kTool, proto::kToolLayoutHash, clock,
            [clock](const std::string& refusal) {
              // Lockstep cannot go on without its peer; real time can, until a better one comes.
              if (clock == proto::Clock::kVirtual) throw publication::SegmentError(refusal);
              spdlog::warn("{}", refusal);
            }) {}

std::optional<dynamics::ToolSample> HandSession::take_tool() {
  const publication::ToolView* view = tool_.acquire();
  if (view == nullptr || !tool_.writer_alive()) {
    last_tool_.reset();
  } else if (const auto state = view->read()) {
    last_tool_ = sample_of(*state);  // else the last good sample stands
  }
  return last_tool_;
}

Session::Session(const scene::SceneDescription& scene, const std::string& name,
                 publication::SessionLock lock, const dynamics::Simulation& simulation,
                 proto::Clock clock, std::uint64_t start_ns, std::optional<gid_t> readers) {
  std::vector<std::string> names;
  std::vector<publication::SessionLock> locks;
  // All before the first segment: who sees one knows all hands.
  for (const scene::Hand& hand : scene.hands) {
    names.push_back(publication::hand_session(name, hand.name));
    locks.emplace_back(names.back(), proto::SegmentKind::kScene);
  }
  if (scene.hands.empty()) {
    names.push_back(name);
    locks.push_back(std::move(lock));
  } else {
    lock_.emplace(std::move(lock));
  }
  for (std::size_t hand = 0; hand < names.size(); ++hand)
    hands_.emplace_back(std::move(names[hand]), std::move(locks[hand]),
                        static_scene(scene, simulation, hand), simulation.world().spheres.size(),
                        realtime::to_ns(scene.period_s), clock, start_ns, readers);
}

}  // namespace stillgrid::sim_server
