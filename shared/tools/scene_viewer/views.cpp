#include "shared/tools/scene_viewer/views.hpp"

#include <algorithm>
#include <utility>

#include "shared/publication/hands.hpp"
#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::scene_viewer {
namespace {

constexpr std::size_t kMaxOthers = 3;  // each holds a minute of frames
constexpr std::uint64_t kKept_ns = 60'000'000'000;

}  // namespace

Views::Views(std::unique_ptr<ViewSource> only) : first_(std::move(only)) {}

Views::Views(LiveOptions options) : named_(options.session) {
  if (!named_.empty()) first_ = std::make_shared<LiveView>(options);
  options.save.clear();
  others_options_ = std::move(options);
}

std::vector<std::string> Views::running() const {
  return others_options_ ? publication::running_sessions() : std::vector<std::string>();
}

/// A page that was closed, or shows another session now, does not say so.
void Views::drop_unasked() {
  const std::uint64_t now_ns = realtime::monotonic_ns();
  std::erase_if(others_, [&](const Other& other) { return now_ns - other.asked_ns > kKept_ns; });
  if (others_.size() > kMaxOthers) others_.resize(kMaxOthers);
}

std::shared_ptr<const ViewSource> Views::find(std::string_view session) {
  drop_unasked();
  if (session.empty() || session == named_) return first_;
  const auto held = std::find_if(others_.begin(), others_.end(),
                                 [&](const Other& other) { return other.session == session; });
  if (held != others_.end()) {
    others_.splice(others_.begin(), others_, held);
  } else {
    const std::vector<std::string> names = running();
    if (std::find(names.begin(), names.end(), session) == names.end()) return nullptr;
    LiveOptions options = *others_options_;
    options.session = session;
    others_.push_front({options.session, std::make_shared<LiveView>(options), 0});
  }
  others_.front().asked_ns = realtime::monotonic_ns();
  drop_unasked();
  return others_.front().view;
}

}  // namespace stillgrid::scene_viewer
