#include "shared/tools/scene_viewer/saved_view.hpp"

#include <stdexcept>
#include <utility>

#include "shared/tools/scene_viewer/frame_moment.hpp"
#include "shared/tools/scene_viewer/scene_message.hpp"

namespace stillgrid::scene_viewer {

SavedView::SavedView(const std::filesystem::path& file) : reader_(file) {
  const auto refuse = [&](const std::string& what) {
    throw std::runtime_error("--open: " + file.string() + ": " + what);
  };
  for (std::size_t i = 0; i < reader_.scene_count(); ++i) {
    auto scene = saved_scene(reader_.scene(i).value_or(""));
    if (!scene) refuse("holds a scene that is none");
    scenes_.emplace_back(scene->key,
                         std::make_shared<const std::string>(std::move(scene->message)));
  }
  if (scenes_.empty() || reader_.frame_count() == 0) refuse("holds no frame");
  std::optional<FrameMoment> last;
  for (std::size_t i = reader_.frame_count(); i-- > 0 && !last;)
    last = moment_of(reader_.frame(i).value_or(""));
  if (!last) refuse("holds no frame that is sound");
  status_ = {.live = false,
             .first_frame = 1,
             .last_frame = reader_.frame_count(),
             .sim = reading::Life::kAbsent,
             .hand = reading::Life::kAbsent,
             .now_s = last->time_s,
             .scene_key = last->scene_key,
             .note = "",
             .sim_command = "",
             .hand_command = ""};
}

ViewStatus SavedView::status() const {
  return status_;
}

Message SavedView::scene(std::optional<std::string_view> key) const {
  if (!key) return scenes_.back().second;
  for (const auto& [own, message] : scenes_)
    if (own == *key) return message;
  return nullptr;
}

Message SavedView::frame(std::optional<std::uint64_t> number) const {
  const std::uint64_t wanted = number.value_or(reader_.frame_count());
  if (wanted == 0 || wanted > reader_.frame_count()) return nullptr;
  auto bytes = reader_.frame(wanted - 1);
  if (!bytes) return nullptr;
  if (!moment_of(*bytes))
    throw std::runtime_error("frame " + std::to_string(wanted) + " of this file is damaged");
  return std::make_shared<const std::string>(std::move(*bytes));
}

std::string SavedView::ticks(std::uint64_t from, std::size_t most) const {
  return tick_message(reader_.ticks(from, most));
}

}  // namespace stillgrid::scene_viewer
