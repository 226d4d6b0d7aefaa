#include "shared/viewer/page_server.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <limits>
#include <stdexcept>
#include <thread>

#include "shared/viewer/prompt_server.hpp"
#include "shared/viewer/scene_message.hpp"

namespace stillgrid {
namespace {

constexpr const char* kHost = "127.0.0.1";
constexpr std::size_t kThreads = 16;        // a connection that is kept open holds one
constexpr std::size_t kMostTicks = 65'536;  // of one answer

/// Whether a request is to us, whatever port a tunnel gives us elsewhere.
bool names_this_machine(const std::string& host) {
  const std::string name = host.substr(0, host.find(':'));
  return name == kHost || name == "localhost";
}

std::optional<std::uint64_t> whole_number(const std::string& text) {
  std::uint64_t number = 0;
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || at != end) return std::nullopt;
  return number;
}

void refuse(httplib::Response& response, int status, const std::string& line) {
  response.status = status;
  response.set_content(line + "\n", "text/plain");
}

void send(httplib::Response& response, const Message& message, const char* type,
          const char* absence) {
  if (!message) return refuse(response, 404, absence);
  response.set_content_provider(
      message->size(), type,
      [message](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        return sink.write(message->data() + offset, length);
      });
}

void send_frame(const ViewSource& view, const httplib::Request& request,
                httplib::Response& response) {
  const std::string text = request.get_param_value("number");
  const auto number = whole_number(text);
  if (!number && text != "latest")
    return refuse(response, 400, "number: expected a frame's number, or latest");
  try {
    send(response, view.frame(number), "application/octet-stream", "no such frame");
  } catch (const std::runtime_error& error) {
    refuse(response, 404, error.what());
  }
}

void send_ticks(const ViewSource& view, const httplib::Request& request,
                httplib::Response& response) {
  const auto from = whole_number(request.get_param_value("from"));
  const auto most = whole_number(request.get_param_value("most"));
  if (!from || !most) return refuse(response, 400, "from, most: expected whole numbers");
  response.set_content(view.ticks(*from, std::min<std::size_t>(*most, kMostTicks)),
                       "application/octet-stream");
}

void send_scene(const ViewSource& view, const httplib::Request& request,
                httplib::Response& response) {
  std::optional<std::string> key;
  if (request.has_param("key")) key = request.get_param_value("key");
  send(response, view.scene(key), "application/json", "no such scene");
}

/// The page may load and ask nothing but what is served here. The hash is of the import map in
/// index.html: where that has changed the browser's console tells the new one.
const httplib::Headers& fixed_headers() {
  static const httplib::Headers headers = {
      {"Cache-Control", "no-store"},
      {"X-Content-Type-Options", "nosniff"},
      {"X-Frame-Options", "DENY"},
      {"Cross-Origin-Resource-Policy", "same-origin"},
      {"Content-Security-Policy",
       "default-src 'self'; img-src 'self' data: blob:; "
       "script-src 'self' 'sha256-OuR7MxkUgGHhn7iWQtKCPA7WcP0m/Xm3MoeLpkpsgDg='"}};
  return headers;
}

}  // namespace

struct PageServer::Server {
  PromptServer http;
  int port = 0;
  std::jthread thread;

  void route(const ViewSource& view, const std::filesystem::path& page);
  void bind(int wanted);
};

void PageServer::Server::route(const ViewSource& view, const std::filesystem::path& page) {
  http.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  http.set_keep_alive_max_count(std::numeric_limits<std::size_t>::max());
  http.set_payload_max_length(0);
  http.set_default_headers(fixed_headers());
  http.set_pre_routing_handler([](const httplib::Request& request, httplib::Response& response) {
    using Response = httplib::Server::HandlerResponse;
    if (names_this_machine(request.get_header_value("Host"))) return Response::Unhandled;
    refuse(response, 403, "this page is for this machine only: ask for 127.0.0.1 or localhost");
    return Response::Handled;
  });
  http.Get("/api/scene",
           [&view](const auto& request, auto& response) { send_scene(view, request, response); });
  http.Get("/api/status", [&view](const auto&, auto& response) {
    response.set_content(status_message(view.status()), "application/json");
  });
  http.Get("/api/frame",
           [&view](const auto& request, auto& response) { send_frame(view, request, response); });
  http.Get("/api/ticks",
           [&view](const auto& request, auto& response) { send_ticks(view, request, response); });
  http.set_file_extension_and_mimetype_mapping("js", "text/javascript");
  http.set_mount_point("/", page.string());
}

void PageServer::Server::bind(int wanted) {
  // Without it a connection that is kept answers 25 times a second: each half waits for the other.
  http.set_tcp_nodelay(true);
  // Its own options would let a second server share the port.
  http.set_socket_options([](int socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  if (wanted == 0)
    port = http.bind_to_any_port(kHost);
  else
    port = http.bind_to_port(kHost, wanted) ? wanted : -1;
  if (port <= 0)
    throw std::runtime_error("--port: value " + std::to_string(wanted) +
                             ": expected a free port of this machine, or 0 for any");
}

PageServer::PageServer(int port) : server_(std::make_unique<Server>()) {
  server_->bind(port);
}

PageServer::~PageServer() {
  server_->http.end();
}

int PageServer::port() const noexcept {
  return server_->port;
}

void PageServer::start(const ViewSource& view, const std::filesystem::path& page) {
  server_->route(view, page);
  server_->thread = std::jthread([http = &server_->http] { http->listen_after_bind(); });
  // What does not listen yet cannot be stopped.
  while (!server_->http.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace stillgrid
