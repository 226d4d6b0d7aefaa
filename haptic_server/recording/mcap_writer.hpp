#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "haptic_server/recording/block_file.hpp"

namespace stillgrid::recording {

/// Writes an MCAP file: messages on channels, in chunks packed by Zstandard, with their indexes,
/// checksums and statistics [https://mcap.dev/spec].
///
/// A chunk ends by the messages' own times, so that the same messages make the same bytes. What has
/// ended is handed to the file with its index: a file that was cut off holds all whole chunks.
/// Thread: one at a time.
class McapWriter {
 public:
  /// A chunk holds messages of so long, or so many bytes before it is packed, or one longer
  /// message.
  static constexpr std::uint64_t kChunk_ns = 250'000'000;
  static constexpr std::size_t kChunkBytes = 1U << 20U;

  /// Writes the file's head. library: who writes.
  McapWriter(BlockFile& file, std::string_view library);

  /// A channel of messages in JSON. Returns its number. Channels of one schema name share it.
  std::uint16_t add_channel(const std::string& topic, const std::string& schema_name,
                            const std::string& json_schema);

  void add_metadata(const std::string& name,
                    const std::vector<std::pair<std::string, std::string>>& entries);

  /// rows: how many rows of the recording are whole with this message.
  void add_message(std::uint16_t channel, std::uint64_t time_ns, std::string_view json,
                   std::uint64_t rows = 0);

  /// Ends the last chunk and writes what stands at the file's end.
  void finish();

 private:
  struct Span {  // of the times of messages
    std::uint64_t first_ns = 0, last_ns = 0;
    bool is_empty = true;
    void take(std::uint64_t time_ns);
    void append_to(std::string& bytes) const;
  };
  using Index = std::vector<std::pair<std::uint64_t, std::uint64_t>>;  // time, place in the chunk

  void write(std::string_view block, std::uint64_t rows = 0);
  void end_chunk();
  [[nodiscard]] std::string statistics() const;
  void write_summary();

  BlockFile& file_;
  std::uint64_t offset_ = 0;  // bytes of the file so far
  std::uint32_t crc_ = 0;     // of them
  std::string schemas_, channels_, chunk_indexes_,
      metadata_indexes_;  // as the summary repeats them
  std::map<std::string, std::uint16_t> schema_ids_;
  std::vector<std::uint64_t> message_counts_;  // by channel
  std::uint32_t chunk_count_ = 0, metadata_count_ = 0;
  Span all_;

  std::string chunk_;  // messages, not yet packed
  Span chunk_span_;
  std::vector<Index> chunk_index_;  // by channel
  std::uint64_t chunk_rows_ = 0;
};

}  // namespace stillgrid::recording
