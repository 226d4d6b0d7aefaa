#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/tools/scene_viewer/live_view.hpp"
#include "shared/tools/scene_viewer/view_source.hpp"

namespace stillgrid::scene_viewer {

/// What a page may choose from: one thing that was kept, or the sessions that run. Thread: one.
class Views {
 public:
  /// A saved view, a recording: nothing else is to be had.
  explicit Views(std::unique_ptr<ViewSource> only);

  /// The session that is named there, from now on, and any other that runs, once it is asked for.
  /// An empty name: none before the others. Others are not saved. Throws as LiveView.
  explicit Views(LiveOptions options);

  /// Of a session, SESSION or SESSION+HAND; empty: the one that was named. Null where there is
  /// none.
  [[nodiscard]] std::shared_ptr<const ViewSource> find(std::string_view session);

  /// That was named; empty: none.
  [[nodiscard]] const std::string& named() const noexcept { return named_; }

  /// Those that run and may be read, by name; of what was kept none.
  [[nodiscard]] std::vector<std::string> running() const;

 private:
  struct Other {
    std::string session;
    std::shared_ptr<const ViewSource> view;
    std::uint64_t asked_ns;
  };
  void drop_unasked();

  std::shared_ptr<const ViewSource> first_;
  std::string named_;
  std::optional<LiveOptions> others_options_;
  std::list<Other> others_;  // asked for last in front
};

}  // namespace stillgrid::scene_viewer
