#include "haptic_server/recording/mcap_writer.hpp"

#include <zstd.h>

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <stdexcept>

#include "haptic_server/recording/crc32.hpp"

namespace stillgrid::recording {
namespace {

constexpr std::string_view kMagic = "\x89MCAP0\r\n";
constexpr std::string_view kCompression = "zstd";
constexpr int kLevel = 1;
constexpr std::size_t kRecordHead = 9;  // opcode, length

enum Opcode : std::uint8_t {
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kStatistics = 11,
  kMetadata,
  kMetadataIndex,
  kSummaryOffset,
  kDataEnd
};

/// Little-endian.
template <class Unsigned>
void append(std::string& bytes, Unsigned value) {
  for (std::size_t i = 0; i < sizeof value; ++i)
    bytes += static_cast<char>(static_cast<unsigned char>(value >> (8 * i)));
}

void append_text(std::string& bytes, std::string_view text) {
  append(bytes, static_cast<std::uint32_t>(text.size()));
  bytes += text;
}

void append_record(std::string& bytes, Opcode opcode, std::string_view content) {
  append(bytes, static_cast<std::uint8_t>(opcode));
  append(bytes, std::uint64_t{content.size()});
  bytes += content;
}

std::string record(Opcode opcode, std::string_view content) {
  std::string bytes;
  append_record(bytes, opcode, content);
  return bytes;
}

std::string packed(std::string_view bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size =
      ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), kLevel);
  if (ZSTD_isError(size) != 0)
    throw std::runtime_error(std::string("--record: zstd: ") + ZSTD_getErrorName(size));
  packed.resize(size);
  return packed;
}

}  // namespace

void McapWriter::Span::take(std::uint64_t time_ns) {
  first_ns = is_empty ? time_ns : std::min(first_ns, time_ns);
  last_ns = is_empty ? time_ns : std::max(last_ns, time_ns);
  is_empty = false;
}

void McapWriter::Span::append_to(std::string& bytes) const {
  append(bytes, first_ns);
  append(bytes, last_ns);
}

McapWriter::McapWriter(BlockFile& file, std::string_view library) : file_(file) {
  std::string content;
  append_text(content, "");  // of no profile
  append_text(content, library);
  write(std::string(kMagic) + record(kHeader, content));
}

void McapWriter::write(std::string_view block, std::uint64_t rows) {
  crc_ = crc32(block, crc_);
  offset_ += block.size();
  file_.add(block, rows);
}

std::uint16_t McapWriter::add_channel(const std::string& topic, const std::string& schema_name,
                                      const std::string& json_schema) {
  const auto [schema, is_new] =
      schema_ids_.emplace(schema_name, static_cast<std::uint16_t>(schema_ids_.size() + 1));
  if (is_new) {
    std::string content;
    append(content, schema->second);
    append_text(content, schema_name);
    append_text(content, "jsonschema");
    append_text(content, json_schema);
    append_record(schemas_, kSchema, content);
    write(record(kSchema, content));
  }
  const auto channel = static_cast<std::uint16_t>(message_counts_.size());
  message_counts_.push_back(0);
  chunk_index_.emplace_back();
  std::string content;
  append(content, channel);
  append(content, schema->second);
  append_text(content, topic);
  append_text(content, "json");
  append(content, std::uint32_t{0});  // no metadata
  append_record(channels_, kChannel, content);
  write(record(kChannel, content));
  return channel;
}

void McapWriter::add_metadata(const std::string& name,
                              const std::vector<std::pair<std::string, std::string>>& entries) {
  std::string map, content, index;
  for (const auto& [key, value] : entries) {
    append_text(map, key);
    append_text(map, value);
  }
  append_text(content, name);
  append_text(content, map);
  append(index, offset_);
  append(index, std::uint64_t{kRecordHead + content.size()});
  append_text(index, name);
  append_record(metadata_indexes_, kMetadataIndex, index);
  ++metadata_count_;
  write(record(kMetadata, content));
}

void McapWriter::add_message(std::uint16_t channel, std::uint64_t time_ns, std::string_view json,
                             std::uint64_t rows) {
  if (!chunk_span_.is_empty && time_ns >= chunk_span_.first_ns + kChunk_ns) end_chunk();
  chunk_index_[channel].emplace_back(time_ns, chunk_.size());
  std::string head;
  append(head, channel);
  append(head, static_cast<std::uint32_t>(message_counts_[channel]++));
  append(head, time_ns);  // logged
  append(head, time_ns);  // published
  append(chunk_, static_cast<std::uint8_t>(kMessage));
  append(chunk_, std::uint64_t{head.size() + json.size()});
  chunk_ += head;
  chunk_ += json;
  chunk_span_.take(time_ns);
  all_.take(time_ns);
  chunk_rows_ += rows;
  if (chunk_.size() >= kChunkBytes) end_chunk();
}

void McapWriter::end_chunk() {
  if (chunk_span_.is_empty) return;
  const std::string messages = packed(chunk_);
  std::string content, index;
  chunk_span_.append_to(content);
  append(content, std::uint64_t{chunk_.size()});
  append(content, crc32(chunk_));
  append_text(content, kCompression);
  append(content, std::uint64_t{messages.size()});
  content += messages;
  std::string block = record(kChunk, content);

  chunk_span_.append_to(index);
  append(index, offset_);
  append(index, std::uint64_t{block.size()});
  const std::size_t chunk_bytes = block.size();
  std::string places;  // of the indexes by channel
  for (std::size_t channel = 0; channel < chunk_index_.size(); ++channel) {
    if (chunk_index_[channel].empty()) continue;
    append(places, static_cast<std::uint16_t>(channel));
    append(places, offset_ + block.size());
    std::stable_sort(chunk_index_[channel].begin(), chunk_index_[channel].end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::string entries, message_index;
    for (const auto& [time_ns, place] : chunk_index_[channel]) {
      append(entries, time_ns);
      append(entries, place);
    }
    append(message_index, static_cast<std::uint16_t>(channel));
    append_text(message_index, entries);
    append_record(block, kMessageIndex, message_index);
    chunk_index_[channel].clear();
  }
  append_text(index, places);
  append(index, std::uint64_t{block.size() - chunk_bytes});
  append_text(index, kCompression);
  append(index, std::uint64_t{messages.size()});
  append(index, std::uint64_t{chunk_.size()});
  append_record(chunk_indexes_, kChunkIndex, index);
  ++chunk_count_;
  write(block, chunk_rows_);
  chunk_.clear();
  chunk_span_ = {};
  chunk_rows_ = 0;
}

std::string McapWriter::statistics() const {
  std::string content, counts;
  std::uint64_t messages = 0;
  for (std::size_t channel = 0; channel < message_counts_.size(); ++channel) {
    messages += message_counts_[channel];
    append(counts, static_cast<std::uint16_t>(channel));
    append(counts, message_counts_[channel]);
  }
  append(content, messages);
  append(content, static_cast<std::uint16_t>(schema_ids_.size()));
  append(content, static_cast<std::uint32_t>(message_counts_.size()));
  append(content, std::uint32_t{0});  // attachments
  append(content, metadata_count_);
  append(content, chunk_count_);
  all_.append_to(content);
  append_text(content, counts);
  return record(kStatistics, content);
}

/// The summary: what stands in the file, grouped by opcode; where each group begins; the footer.
void McapWriter::write_summary() {
  const std::uint64_t start = offset_;
  std::string summary, groups;
  const std::string counted = statistics();
  for (const std::string_view group : std::initializer_list<std::string_view>{
           schemas_, channels_, counted, chunk_indexes_, metadata_indexes_}) {
    if (group.empty()) continue;
    std::string place;
    append(place, static_cast<std::uint8_t>(group.front()));
    append(place, start + summary.size());
    append(place, std::uint64_t{group.size()});
    append_record(groups, kSummaryOffset, place);
    summary += group;
  }
  const std::uint64_t groups_start = start + summary.size();
  summary += groups;
  std::string footer;
  append(footer, start);
  append(footer, groups_start);
  append(summary, static_cast<std::uint8_t>(kFooter));
  append(summary, std::uint64_t{footer.size() + sizeof(std::uint32_t)});
  summary += footer;
  append(summary, crc32(summary));
  summary += kMagic;
  write(summary);
}

void McapWriter::finish() {
  end_chunk();
  std::string content;
  append(content, crc_);
  write(record(kDataEnd, content));
  write_summary();
}

}  // namespace stillgrid::recording
