#include "shared/publication/segment_place.hpp"

#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <map>
#include <mutex>
#include <system_error>

#include "shared/publication/hands.hpp"

namespace stillgrid::publication {
namespace {

constexpr mode_t kFolderMode = 0755;  // what is in it is for its owner, or for a group

/// Whose it is, and its name in that user's folder.
struct SessionParts {
  uid_t owner;
  std::string_view name;
};

SessionParts parts_of(std::string_view session) {
  const auto is_allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  };
  const std::size_t slash = session.find('/');
  const bool is_own = slash == std::string_view::npos;
  const auto owner = is_own ? ::geteuid() : number_of_user(session.substr(0, slash));
  const std::string_view name = is_own ? session : session.substr(slash + 1);
  const std::string_view whole = session_of(name);
  const bool has_good_hand =
      whole.size() == name.size() || hand_complaint(std::string(hand_of(name))).empty();
  if (!owner || whole.empty() || whole.size() > 64 || whole.front() == '.' ||
      !std::all_of(whole.begin(), whole.end(), is_allowed) || !has_good_hand)
    throw SegmentError("value '" + std::string(session) +
                       "': expected 1 to 64 letters, digits, '_', '-' or '.', after USER/ if it is "
                       "another user's");
  return {*owner, name};
}

std::string file_name(std::string_view name, proto::SegmentKind kind) {
  return std::string(name) += ending_of(kind);
}

/// What the user's folder is called, or what its names begin with where strangers took the first.
std::string first_folder(uid_t owner) {
  return std::string(kSharedMemory) += std::string(kFolderPrefix) += std::to_string(owner);
}

bool is_folder_of(const std::string& path, uid_t owner) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == owner;
}

/// Of several the first by name; empty where there is none.
std::string search_folder(const std::string& first, uid_t owner) {
  std::string found;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(kSharedMemory, error)) {
    const std::string path = entry.path();
    if (path.starts_with(first + ".") && is_folder_of(path, owner) &&
        (found.empty() || path < found))
      found = path;
  }
  return found;
}

std::string own_folder() {
  const uid_t user = ::geteuid();
  std::string folder = folder_of(user);
  if (!folder.empty()) {
    ::chmod(folder.c_str(), kFolderMode);  // whoever made it, with whatever mode
    return folder;
  }
  const std::string first = first_folder(user);
  std::string path = first;
  for (std::size_t number = 1; ::mkdir(path.c_str(), kFolderMode) != 0; ++number) {
    if (errno != EEXIST) throw SegmentError("cannot make " + path + ": " + error_text(errno));
    if (is_folder_of(path, user)) break;  // just made by another program of ours
    path = first + "." + std::to_string(number);
  }
  ::chmod(path.c_str(), kFolderMode);  // whatever the umask
  return folder_of(user);              // of two made at once, the one that all take
}

}  // namespace

std::string_view ending_of(proto::SegmentKind kind) noexcept {
  switch (kind) {
    case proto::SegmentKind::kScene:
      return "-scene";
    case proto::SegmentKind::kTool:
      return "-tool";
    default:
      return "-mouse";
  }
}

std::optional<uid_t> number_of_user(std::string_view text) {
  uid_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::string folder_of(uid_t owner) {
  const std::string first = first_folder(owner);
  if (is_folder_of(first, owner)) return first + "/";
  // Strangers may have taken any number of names: what was found is looked for once. Shared memory
  // is sticky, so that no other user can put another in its place.
  static std::mutex mutex;
  static std::map<uid_t, std::string> found_before;
  const std::lock_guard lock(mutex);
  std::string& found = found_before[owner];
  if (!is_folder_of(found, owner)) found = search_folder(first, owner);
  return found.empty() ? "" : found + "/";
}

std::string segment_name(std::string_view session, proto::SegmentKind kind) {
  (void)parts_of(session);
  return file_name(session, kind);
}

std::string segment_path(std::string_view session, proto::SegmentKind kind) {
  const auto [owner, name] = parts_of(session);
  const std::string folder = folder_of(owner);
  return folder.empty() ? "" : folder + file_name(name, kind);
}

std::string own_segment_path(std::string_view session, proto::SegmentKind kind) {
  return own_folder() + file_name(parts_of(session).name, kind);
}

uid_t session_owner(std::string_view session) {
  return parts_of(session).owner;
}

std::string error_text(int code) {
  return std::generic_category().message(code);
}

std::string settle_hand_session(std::string& session) {
  const std::size_t slash = session.find('/');
  if (slash != std::string::npos) {
    const std::string user = session.substr(0, slash);
    const struct passwd* const found = ::getpwnam(user.c_str());
    const auto number = found != nullptr ? std::optional(found->pw_uid) : number_of_user(user);
    if (!number) return "value '" + session + "': expected the name or number of a user before '/'";
    // One's own is plain, or the same session would have two names.
    session =
        (*number == ::geteuid() ? "" : std::to_string(*number) + "/") + session.substr(slash + 1);
  }
  try {
    (void)parts_of(session);
    return {};
  } catch (const SegmentError& error) {
    return error.what();
  }
}

std::string settle_session(std::string& session) {
  const std::string complaint = settle_hand_session(session);
  if (!complaint.empty() || hand_of(session).empty()) return complaint;
  return "value '" + session + "': expected a session without a hand";
}

}  // namespace stillgrid::publication
