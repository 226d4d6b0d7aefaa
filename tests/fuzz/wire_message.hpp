#pragma once

#include <dds/ddsi/ddsi_cdrstream.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "shared/tools/scene_relay/messages.hpp"

namespace stillgrid::fuzz {

/// A type of messages as Cyclone DDS lays it out on the wire (XCDR, version 1), by its own writer
/// and reader.
class WireType {
 public:
  explicit WireType(const dds_topic_descriptor_t& descriptor) {
    type_.write_encoding_version = kVersion;
    type_.type.size = descriptor.m_size;
    type_.type.align = descriptor.m_align;
    type_.type.flagset = descriptor.m_flagset;
    type_.type.ops = {descriptor.m_nops, const_cast<std::uint32_t*>(descriptor.m_ops)};
  }

  [[nodiscard]] std::vector<std::byte> bytes_of(const void* message) const {
    dds_ostream_t stream;
    dds_ostream_init(&stream, 0, kVersion);
    dds_stream_write_sample(&stream, message, &type_);
    std::vector<std::byte> bytes(stream.m_index);
    std::memcpy(bytes.data(), stream.m_buffer, bytes.size());
    dds_ostream_fini(&stream);
    return bytes;
  }

  /// use(message) of those bytes, as a reader gets it; nothing where they are refused as none.
  template <class Message, class Use>
  void read(const std::vector<std::byte>& bytes, const Use& use) const {
    std::vector<std::uint64_t> words((bytes.size() + 7) / 8);  // aligned as a received packet
    if (words.empty()) return;
    std::memcpy(words.data(), bytes.data(), bytes.size());
    std::uint32_t size = 0;
    if (!dds_stream_normalize(words.data(), static_cast<std::uint32_t>(bytes.size()), false,
                              kVersion, &type_, false, &size))
      return;
    const Sample<Message> sample(*this);
    dds_istream_t stream;
    dds_istream_init(&stream, size, words.data(), kVersion);
    dds_stream_read_sample(&stream, sample.message, &type_);
    dds_istream_fini(&stream);
    use(*sample.message);
  }

 private:
  static constexpr std::uint32_t kVersion = 1;

  template <class Message>
  struct Sample {
    explicit Sample(const WireType& of) : type(of), message(new Message{}) {}
    ~Sample() {
      dds_stream_free_sample(message, type.type_.type.ops.ops);
      delete message;
    }
    Sample(const Sample&) = delete;
    Sample& operator=(const Sample&) = delete;
    const WireType& type;
    Message* message;
  };

  ddsi_sertype_default type_{};
};

}  // namespace stillgrid::fuzz
