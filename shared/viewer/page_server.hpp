#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "shared/viewer/view_source.hpp"

namespace stillgrid {

/// Serves a page and what it shows over HTTP on 127.0.0.1, to this machine's own programs only: a
/// request that names another host is refused, so that no page from elsewhere reads it through a
/// name that it lets point here. Nothing but GET and HEAD of the page's files and of the API.
class PageServer {
 public:
  /// Binds; port 0: any that is free. Throws std::runtime_error in one line where it cannot.
  explicit PageServer(int port);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;
  PageServer(PageServer&&) = delete;
  PageServer& operator=(PageServer&&) = delete;

  [[nodiscard]] int port() const noexcept;

  /// Serves the page's folder and the view in threads of its own until destruction. Pre: the view
  /// outlives it.
  void start(const ViewSource& view, const std::filesystem::path& page);

 private:
  struct Server;
  std::unique_ptr<Server> server_;
};

}  // namespace stillgrid
