#pragma once

#include <atomic>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "shared/double_buffer/double_buffer.hpp"
#include "tests/model/relaxed_memory.hpp"

namespace stillgrid::model {

/// The steps of docs/protocol.md, "Publication".
enum class Step : std::uint8_t { kW1, kW2, kW3, kW4, kW5, kR1, kR2, kR3, kR4, kR5 };

/// A protocol that is not quite ours; as it is, it is ours.
struct Mutant {
  std::bitset<10> relaxed{};             // by Step: loads and stores made relaxed, fences left out
  bool has_odd_mark = true;              // false: W1 left out
  bool has_two_slots = true;             // false: every snapshot goes to the same slot
  bool checks_sequence = true;           // false: R2 and R5 ask whether `latest` is still n
  bool successor_counts_afresh = false;  // it publishes snapshot 1, whatever `latest` says
};

/// One publication of one writer; every word that it writes to its payload holds this number.
[[nodiscard]] constexpr std::uint64_t publication_of(std::uint64_t snapshot_id,
                                                     std::uint8_t writer) noexcept {
  return 16 * snapshot_id + writer;
}

/// What one attempt of a read has seen.
struct Attempt {
  std::uint64_t snapshot_id;  // that R1 read
  std::uint64_t publication;  // that stored what R1 read
  std::uint64_t sequence;     // that R2 or R5 read last
};

struct ReaderStep {
  Step step;
  std::memory_order order;
  std::size_t location;
  std::size_t message;
};

/// One read and how it came about.
struct ReadRecord {
  double_buffer::ReadResult result;
  std::vector<std::uint64_t> words;  // gathered by the last attempt that came so far
  std::vector<Attempt> attempts;
  std::vector<ReaderStep> steps;
};

/// Two slots in relaxed memory, written by publish() and read by read_latest(): the very functions
/// of the servers, over ModelAtomics.
class PublicationModel {
 public:
  PublicationModel(const Mutant& mutant, std::size_t payload_words);

  /// A new writer publishes all snapshots after `latest` up to last_snapshot_id, unless it is
  /// killed before that step of its own; stores and fences are steps. Returns the steps it made.
  std::size_t write(std::uint64_t last_snapshot_id, std::size_t killed_before);

  /// One read; which message each load gets is chosen by `choices`, 0 being the newest. The record
  /// is valid until the next read.
  const ReadRecord& read(Reader& reader, Choices& choices);

  /// Snapshot id last published; nobody can miss it who has seen the last writer dead.
  [[nodiscard]] std::uint64_t latest() const;

  /// What the writers did up to the last message that one of these steps has read, a line each;
  /// then these steps.
  [[nodiscard]] std::string trace(const std::vector<ReaderStep>& reader_steps) const;

 private:
  friend struct ModelAtomics;
  struct WriterStep {
    Step step;
    std::memory_order order;
    std::size_t location;  // a store's
    std::size_t message;
    std::uint8_t writer;
  };
  [[nodiscard]] std::memory_order order_of(Step step, std::memory_order order) const;
  [[nodiscard]] std::size_t location_of(const std::uint64_t& word) const;
  [[nodiscard]] std::string word_at(std::size_t location) const;
  [[nodiscard]] std::uint64_t load(Step step, std::size_t location, std::memory_order order);
  bool lives();  // counts a step of the writer

  Mutant mutant_;
  std::size_t payload_words_;
  std::vector<std::uint64_t> words_;  // only their addresses are used, as locations
  double_buffer::DoubleBuffer buffer_;
  RelaxedMemory memory_;
  std::vector<WriterStep> log_;
  std::size_t writer_steps_ = 0;
  std::size_t killed_before_ = 0;
  Reader* reader_ = nullptr;
  Choices* choices_ = nullptr;
  ReadRecord record_;
};

/// The atomics policy that a PublicationModel runs its writer and its reader over.
struct ModelAtomics {
  static inline thread_local PublicationModel* model = nullptr;  // the one that runs

  static std::uint64_t load(const std::uint64_t& word, std::memory_order order) noexcept;
  static void store(std::uint64_t& word, std::uint64_t value, std::memory_order order) noexcept;
  static void fence(std::memory_order order) noexcept;
};

}  // namespace stillgrid::model
