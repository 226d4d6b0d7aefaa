#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "shared/tools/scene_viewer/view_source.hpp"

namespace stillgrid::scene_viewer {

/// What a page asked. Views of the request, which outlives the call.
struct PageQuestion {
  std::string_view method, target, host;
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

/// What is answered to whom: docs/viewer.md, "What the viewer serves". Thread: any.
class PageAnswers {
 public:
  /// Reads the page's files, those of its folder that a browser asks for. Pre: the view outlives
  /// it.
  PageAnswers(const ViewSource& view, std::string key, const std::filesystem::path& page);

  [[nodiscard]] PageAnswer to(const PageQuestion& question) const;

 private:
  const ViewSource* view_;
  std::string key_;
  std::map<std::string, PageAnswer, std::less<>> files_;  // by path; "": index.html
};

/// The value of name in "a=1&b=2", with %XX decoded.
[[nodiscard]] std::optional<std::string> query_value(std::string_view query, std::string_view name);

}  // namespace stillgrid::scene_viewer
