#include "shared/tools/scene_viewer/page_answers.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/scene_viewer/scene_message.hpp"

namespace stillgrid::scene_viewer {
namespace {

constexpr std::size_t kMaxTicks = 65'536;  // of one answer
constexpr std::string_view kApi = "api/";
constexpr std::string_view kMouse = "api/mouse";
constexpr const char* kJson = "application/json";
constexpr const char* kBinary = "application/octet-stream";

Message message_of(std::string text) {
  return std::make_shared<const std::string>(std::move(text));
}

PageAnswer refuse(unsigned status, const std::string& line) {
  return {.status = status, .body = message_of(line + "\n")};
}

PageAnswer turn_away(unsigned status, const std::string& line) {
  PageAnswer answer = refuse(status, line);
  answer.is_to_stranger = true;
  return answer;
}

PageAnswer found_or(Message message, const char* type, const char* absence) {
  if (!message) return refuse(404, absence);
  return {.type = type, .body = std::move(message)};
}

/// Whether a request is to us, whatever port a tunnel gives us elsewhere.
bool names_this_machine(std::string_view host) {
  const std::string_view name = host.substr(0, host.find(':'));
  return name == "127.0.0.1" || name == "localhost";
}

/// Whether the page that asks is one of ours, or does not tell.
bool is_own_origin(std::string_view origin) {
  constexpr std::string_view kHttp = "http://";
  return origin.empty() ||
         (origin.starts_with(kHttp) && names_this_machine(origin.substr(kHttp.size())));
}

/// In a time that does not tell how much of it is right.
bool is_key(std::string_view text, std::string_view key) {
  if (text.size() != key.size()) return false;
  unsigned char apart = 0;
  for (std::size_t i = 0; i < key.size(); ++i)
    apart = static_cast<unsigned char>(apart | (text[i] ^ key[i]));
  return apart == 0;
}

template <class Number = std::uint64_t>
std::optional<Number> whole_number(std::string_view text, int base = 10) {
  Number number = 0;
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number, base);
  if (error != std::errc() || at != end) return std::nullopt;
  return number;
}

PageAnswer frame_answer(const ViewSource& view, std::string_view query) {
  const std::string text = query_value(query, "number").value_or("");
  const auto number = whole_number(text);
  if (!number && text != "latest")
    return refuse(400, "number: expected a frame's number, or latest");
  try {
    return found_or(view.frame(number), kBinary, "no such frame");
  } catch (const std::runtime_error& error) {
    return refuse(404, error.what());
  }
}

PageAnswer ticks_answer(const ViewSource& view, std::string_view query) {
  const auto from = whole_number(query_value(query, "from").value_or(""));
  const auto most = whole_number(query_value(query, "most").value_or(""));
  if (!from || !most) return refuse(400, "from, most: expected whole numbers");
  const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(*most, kMaxTicks));
  return {.type = kBinary, .body = message_of(view.ticks(*from, count))};
}

PageAnswer scene_answer(const ViewSource& view, std::string_view query) {
  return found_or(view.scene(query_value(query, "key")), kJson, "no such scene");
}

/// Of those that a browser asks for; null: not served.
const char* type_of(const std::filesystem::path& file) {
  static const std::map<std::string, const char*> types = {{".html", "text/html"},
                                                           {".css", "text/css"},
                                                           {".js", "text/javascript"},
                                                           {".svg", "image/svg+xml"}};
  const auto found = types.find(file.extension());
  return found == types.end() ? nullptr : found->second;
}

}  // namespace

std::optional<std::string> query_value(std::string_view query, std::string_view name) {
  while (!query.empty()) {
    const std::string_view part = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), part.size() + 1));
    if (part.substr(0, part.find('=')) != name) continue;
    std::string value(part.substr(std::min(part.size(), name.size() + 1)));
    for (std::size_t at = value.find('%'); at != std::string::npos; at = value.find('%', at + 1)) {
      const auto byte = whole_number<unsigned char>(std::string_view(value).substr(at + 1, 2), 16);
      if (byte && at + 2 < value.size()) value.replace(at, 3, 1, static_cast<char>(*byte));
    }
    return value;
  }
  return std::nullopt;
}

PageAnswers::PageAnswers(Views& views, std::string key, const std::filesystem::path& page)
    : views_(&views), key_(std::move(key)) {
  std::error_code none;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(page, none)) {
    const char* const type = type_of(entry.path());
    if (type == nullptr || !entry.is_regular_file()) continue;
    std::ifstream in(entry.path());
    const std::string path = entry.path().lexically_relative(page).generic_string();
    files_[path == "index.html" ? "" : path] = {
        .type = type, .body = message_of({std::istreambuf_iterator<char>(in), {}})};
  }
}

PageAnswer PageAnswers::of_api(std::string_view name, std::string_view query) const {
  if (name == "sessions")
    return {.type = kJson,
            .body = message_of(sessions_message(views_->named(), views_->running()))};
  if (name != "status" && name != "frame" && name != "ticks" && name != "scene")
    return refuse(404, "no such file");
  const std::string session = query_value(query, "session").value_or("");
  const auto view = views_->find(session);
  if (!view)
    return refuse(404, session.empty() ? "expected session=NAME, one of /api/sessions"
                                       : "no session of that name runs");
  if (name == "status") return {.type = kJson, .body = message_of(status_message(view->status()))};
  if (name == "frame") return frame_answer(*view, query);
  if (name == "ticks") return ticks_answer(*view, query);
  return scene_answer(*view, query);
}

PageAnswer PageAnswers::of_mouse(std::string_view query, std::string_view body) {
  const auto message = mouse_message(body);
  if (!message)
    return refuse(
        400, "expected JSON: holder, and release: true, or position_m, orientation_xyzw, buttons");
  const std::string asked = query_value(query, "session").value_or("");
  const auto view = views_->find(asked);
  if (!view || !view->status().live) return refuse(404, "no session of that name runs");
  const std::string& session = asked.empty() ? views_->named() : asked;
  if (session.find('/') != std::string::npos)
    return refuse(409, "the session is another user's, whose hand is not to be held from here");
  try {
    const std::string refusal = hands_.move(session, *message, realtime::monotonic_ns());
    return refusal.empty() ? PageAnswer{.body = message_of("")} : refuse(409, refusal);
  } catch (const publication::SegmentError& error) {
    return refuse(503, error.what());
  }
}

void PageAnswers::drop_silent_hands() {
  hands_.drop_silent(realtime::monotonic_ns());
}

PageAnswer PageAnswers::to(const PageQuestion& question) {
  if (!names_this_machine(question.host))
    return turn_away(403, "this page is for this machine only: ask for 127.0.0.1 or localhost");
  std::string_view path = question.target.substr(0, question.target.find('?'));
  const std::size_t key_end = path.find('/', 1);
  if (!path.starts_with('/') || key_end == std::string_view::npos ||
      !is_key(path.substr(1, key_end - 1), key_))
    return turn_away(403,
                     "this page is for those who know its key: open the address that "
                     "scene_viewer printed when it was started");
  const std::string_view query =
      question.target.substr(std::min(question.target.size(), path.size() + 1));
  path.remove_prefix(key_end + 1);
  if (path == kMouse) {
    if (question.method != "POST") return refuse(405, "expected POST");
    if (!is_own_origin(question.origin))
      return refuse(403, "the mouse is for the viewer's own page");
    return of_mouse(query, question.body);
  }
  if (question.method != "GET" && question.method != "HEAD")
    return refuse(405, "expected GET or HEAD");
  if (path.starts_with(kApi)) return of_api(path.substr(kApi.size()), query);
  const auto file = files_.find(path);
  return file == files_.end() ? refuse(404, "no such file") : file->second;
}

}  // namespace stillgrid::scene_viewer
