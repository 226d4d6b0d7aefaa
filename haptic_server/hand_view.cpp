#include "haptic_server/hand_view.hpp"

#include <spdlog/spdlog.h>

#include <exception>
#include <memory>
#include <string>
#include <utility>

#include "shared/publication/hands.hpp"

namespace stillgrid::haptic_server {

HandView::HandView(publication::SegmentReader&& of_scene) : SceneView(std::move(of_scene)) {
  if (model().empty()) return;
  try {
    local_ = std::make_unique<rendering::LocalCopy>(*this);
  } catch (const std::exception& error) {
    spdlog::warn("{}: its model is refused: {}; its snapshots are shown", scene().name.data(),
                 error.what());
    return;
  }
  const std::string session(publication::session_of(reader().session()));
  watches_.resize(scene().hand_count);
  tools_.resize(watches_.size());
  for (std::size_t hand = 0; hand < watches_.size(); ++hand) {
    if (hand == scene().hand) continue;
    watches_[hand] = std::make_unique<ToolWatch>(
        publication::hand_session(session, scene().hands[hand].data()), proto::SegmentKind::kTool,
        proto::kToolLayoutHash, header().clock,
        [](const std::string& refusal) { spdlog::warn("{}", refusal); });
    if (header().clock == proto::Clock::kMonotonic) watches_[hand]->start();
  }
}

std::span<const publication::ToolView* const> HandView::look_at_tools() const noexcept {
  const bool is_real = header().clock == proto::Clock::kMonotonic;
  for (std::size_t hand = 0; hand < watches_.size(); ++hand) {
    if (!watches_[hand]) continue;
    tools_[hand] = watches_[hand]->acquire();
    if (is_real && !watches_[hand]->writer_alive()) tools_[hand] = nullptr;
  }
  return tools_;
}

}  // namespace stillgrid::haptic_server
