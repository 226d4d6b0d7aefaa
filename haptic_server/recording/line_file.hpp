#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace stillgrid::recording {

/// A text file that grows by lines, whatever becomes of the disk under it.
///
/// What the disk does not take stays in memory and is tried again, from the very byte where it
/// stopped: the file is at every moment a beginning of the text, so that half a line can only be
/// its last. Thread: one at a time.
class LineFile {
 public:
  /// Opens the file and empties it. Throws std::runtime_error, one line, if it cannot.
  explicit LineFile(const std::filesystem::path& file);

  /// Ends as end() does.
  ~LineFile();
  LineFile(const LineFile&) = delete;
  LineFile& operator=(const LineFile&) = delete;
  LineFile(LineFile&&) = delete;
  LineFile& operator=(LineFile&&) = delete;

  /// Adds a line, without its newline, to what waits.
  void add(std::string_view line);

  /// Writes what waits. Returns 0, or the error number that it met. Beyond a limit of size or into
  /// a pipe that nobody reads that takes make_writes_fail(), or the process ends.
  int flush() noexcept;

  /// Bytes that wait.
  [[nodiscard]] std::size_t waiting_bytes() const noexcept { return waiting_.size(); }

  /// Closes the file after its last whole line. Returns the lines that were not written.
  std::uint64_t end() noexcept;

 private:
  int descriptor_ = -1;
  std::string waiting_;
  std::size_t half_line_bytes_ = 0;  // at the file's end
};

}  // namespace stillgrid::recording
