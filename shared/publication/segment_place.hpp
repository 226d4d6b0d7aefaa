#pragma once

#include <sys/types.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "proto/segment_header.hpp"

namespace stillgrid::publication {

/// A segment cannot be made or must be refused; what() is one line for the user.
class SegmentError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Where every user's segments stand, in a folder of that user's own: no other user can put
/// anything there, so that whoever takes a name first takes it from nobody.
inline constexpr std::string_view kSharedMemory = "/dev/shm/";

/// A session's segment by its session and kind, for people. Throws SegmentError unless the session
/// is NAME, 1 to 64 letters, digits, '_', '-' or '.', with no '.' first; or NAME+HAND, of one of
/// its hands (hands.hpp); or either after UID/, which is what the user of that number publishes.
/// UID/NAME is read only: whoever writes, writes NAME of its own.
[[nodiscard]] std::string segment_name(std::string_view session, proto::SegmentKind kind);

/// Where a reader finds it: in the folder of the session's owner, or nowhere (empty) while that
/// user has none. Throws as segment_name().
[[nodiscard]] std::string segment_path(std::string_view session, proto::SegmentKind kind);

/// Where a writer of this process makes it; makes the user's folder if there is none. Throws
/// SegmentError.
[[nodiscard]] std::string own_segment_path(std::string_view session, proto::SegmentKind kind);

/// Who must own what stands under the session's name. Throws as segment_name().
[[nodiscard]] uid_t session_owner(std::string_view session);

/// What the system says of an error's number.
[[nodiscard]] std::string error_text(int code);

/// Brings NAME or USER/NAME, USER a name or a number, to the form that segment_name() takes,
/// without a hand. What is wrong with it, or nothing: a transformation for command lines.
[[nodiscard]] std::string settle_session(std::string& session);
/// The same, NAME+HAND too.
[[nodiscard]] std::string settle_hand_session(std::string& session);

/// The folder in which that user's segments stand, '/' behind it; empty where there is none.
[[nodiscard]] std::string folder_of(uid_t owner);

/// A user's number of decimal digits, or nothing.
[[nodiscard]] std::optional<uid_t> number_of_user(std::string_view text);

/// What all folders' names begin with, and what ends a segment's name.
inline constexpr std::string_view kFolderPrefix = "stillgrid-";
[[nodiscard]] std::string_view ending_of(proto::SegmentKind kind) noexcept;

}  // namespace stillgrid::publication
