#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <string>
#include <string_view>

namespace stillgrid::recording {

/// A file that grows by blocks, a line or a chunk each, whatever becomes of the disk under it.
///
/// What the disk does not take stays in memory and is tried again, from the very byte where it
/// stopped: the file is at every moment a beginning of the whole, so that half a block can only be
/// its last. Thread: one at a time.
class BlockFile {
 public:
  /// Opens the file. What an earlier recording left in it stays until begin(). Throws
  /// std::runtime_error, one line, if it cannot.
  explicit BlockFile(const std::filesystem::path& file);

  /// Ends as end() does.
  ~BlockFile();
  BlockFile(const BlockFile&) = delete;
  BlockFile& operator=(const BlockFile&) = delete;
  BlockFile(BlockFile&&) = delete;
  BlockFile& operator=(BlockFile&&) = delete;

  /// Adds a block, which holds so many rows, to what waits.
  void add(std::string_view block, std::uint64_t rows);

  /// The file is this recording's from here on: the next flush() empties it of an earlier one.
  void begin() noexcept { has_begun_ = true; }

  /// Writes what waits, unless an earlier recording is to stay. Returns 0, or the error number that
  /// it met. Beyond a limit of size or into a pipe that nobody reads that takes make_writes_fail(),
  /// or the process ends.
  int flush() noexcept;

  /// Bytes that wait.
  [[nodiscard]] std::size_t waiting_bytes() const noexcept { return waiting_.size(); }

  /// Closes the file after its last whole block; before begin() as it was found, or there is none.
  /// Returns the rows of those that were not written.
  std::uint64_t end() noexcept;

 private:
  struct Block {
    std::size_t bytes;
    std::uint64_t rows;
  };

  std::filesystem::path path_;
  bool is_new_, holds_earlier_, has_begun_ = false;
  int descriptor_ = -1;
  std::string waiting_;
  std::deque<Block> blocks_;          // that are not all written
  std::size_t half_block_bytes_ = 0;  // of the first of them, at the file's end
};

}  // namespace stillgrid::recording
