#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "shared/tools/scene_viewer/mouse_hands.hpp"
#include "shared/tools/scene_viewer/views.hpp"

namespace stillgrid::scene_viewer {

/// What a page asked. Views of the request, which outlives the call.
struct PageQuestion {
  std::string_view method, target, host;
  std::string_view origin = {};  // header of that name, or empty
  std::string_view body = {};    // empty without a POST
};

/// What it is told.
struct PageAnswer {
  unsigned status = 200;
  std::string type = "text/plain";
  Message body;
  bool is_to_stranger = false;  // who does not know the key: the connection ends
};

/// Thread: the connections' one.
using AnswerPage = std::function<PageAnswer(const PageQuestion&)>;

/// What is answered to whom: docs/viewer.md, "What the viewer serves". Thread: one.
class PageAnswers {
 public:
  /// Reads the page's files, those of its folder that a browser asks for. Pre: the views
  /// outlive it.
  PageAnswers(Views& views, std::string key, const std::filesystem::path& page);

  [[nodiscard]] PageAnswer to(const PageQuestion& question);

  /// Frees the hands of pages that are silent. To be called some times a second.
  void drop_silent_hands();

 private:
  [[nodiscard]] PageAnswer of_api(std::string_view name, std::string_view query) const;
  [[nodiscard]] PageAnswer of_mouse(std::string_view query, std::string_view body);

  Views* views_;
  std::string key_;
  MouseHands hands_;
  std::map<std::string, PageAnswer, std::less<>> files_;  // by path; "": index.html
};

/// The value of name in "a=1&b=2", with %XX decoded.
[[nodiscard]] std::optional<std::string> query_value(std::string_view query, std::string_view name);

}  // namespace stillgrid::scene_viewer
