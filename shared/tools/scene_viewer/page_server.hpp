#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "shared/tools/scene_viewer/views.hpp"

namespace stillgrid::scene_viewer {

/// Serves a page and what it shows over HTTP on 127.0.0.1, to those who know its address: the first
/// part of every path is a key, drawn at random for each server, so that other users of the machine
/// get nothing. A request that names another host is refused too, so that no page from elsewhere
/// reads it through a name that it lets point here. It answers GET and HEAD of the page's files
/// and of the API, and POST of the mouse; bounds: PageConnection.
class PageServer {
 public:
  /// Binds. Port 0: any that is free; none: 8642, or any that is free where that is taken. Throws
  /// std::runtime_error in one line where it cannot.
  explicit PageServer(std::optional<int> port);
  /// Ends all connections, answered or not.
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;
  PageServer(PageServer&&) = delete;
  PageServer& operator=(PageServer&&) = delete;

  /// http://127.0.0.1:PORT/KEY/
  [[nodiscard]] std::string address() const;

  /// Serves the files that the page's folder holds now, and the views, in a thread of its own until
  /// destruction. Pre: the views outlive it, and nobody else asks them.
  void start(Views& views, const std::filesystem::path& page);

 private:
  struct Server;
  std::unique_ptr<Server> server_;
};

}  // namespace stillgrid::scene_viewer
