#include "tests/model/publication_model.hpp"

#include <algorithm>
#include <limits>
#include <sstream>

namespace stillgrid::model {
namespace {

constexpr std::size_t kLatest = 0;
constexpr std::size_t kSequence = 1;  // of slot 0; that of slot 1 follows
constexpr std::size_t kPayload = 3;   // of slot 0; that of slot 1 follows

bool is_sequence(std::size_t location) {
  return location >= kSequence && location < kPayload;
}

const char* name_of(Step step) {
  constexpr const char* kNames[] = {"W1", "W2", "W3", "W4", "W5", "R1", "R2", "R3", "R4", "R5"};
  return kNames[static_cast<std::size_t>(step)];
}

const char* name_of(std::memory_order order) {
  if (order == std::memory_order_relaxed) return "relaxed";
  if (order == std::memory_order_acquire) return "acquire";
  return order == std::memory_order_release ? "release" : "other order";
}

double_buffer::DoubleBuffer buffer_in(std::vector<std::uint64_t>& words, std::size_t payload_words,
                                      bool has_two_slots) {
  const std::size_t second = has_two_slots ? 1 : 0;
  return {&words[kLatest],
          {&words[kSequence], &words[kSequence + second]},
          {&words[kPayload], &words[kPayload + second * payload_words]}};
}

}  // namespace

PublicationModel::PublicationModel(const Mutant& mutant, std::size_t payload_words)
    : mutant_(mutant),
      payload_words_(payload_words),
      words_(kPayload + 2 * payload_words),
      buffer_(buffer_in(words_, payload_words, mutant_.has_two_slots)),
      memory_(words_.size()) {
  record_.words.resize(payload_words);
}

std::size_t PublicationModel::write(std::uint64_t last_snapshot_id, std::size_t killed_before) {
  memory_.start_writer();
  writer_steps_ = 0;
  killed_before_ = killed_before;
  ModelAtomics::model = this;
  const bool counts_afresh = mutant_.successor_counts_afresh && memory_.writer() > 1;
  for (std::uint64_t n = counts_afresh ? 1 : latest() + 1; n <= last_snapshot_id; ++n) {
    const std::vector<std::uint64_t> payload(payload_words_, publication_of(n, memory_.writer()));
    double_buffer::publish<ModelAtomics>(buffer_, n, {{0, payload}});
  }
  return writer_steps_;
}

const ReadRecord& PublicationModel::read(Reader& reader, Choices& choices) {
  ModelAtomics::model = this;
  reader_ = &reader;
  choices_ = &choices;
  record_.attempts.clear();
  record_.steps.clear();
  record_.result =
      double_buffer::read_latest<ModelAtomics>(buffer_, [&](const std::uint64_t* payload) {
        for (std::size_t i = 0; i < payload_words_; ++i)
          record_.words[i] = double_buffer::load_word<ModelAtomics>(payload, i);
      });
  return record_;
}

std::uint64_t PublicationModel::latest() const {
  return memory_.message(kLatest, memory_.newest(kLatest)).value;
}

std::string PublicationModel::trace(const std::vector<ReaderStep>& reader_steps) const {
  const auto was_read = [&](const WriterStep& written) {
    return std::any_of(reader_steps.begin(), reader_steps.end(), [&](const ReaderStep& read) {
      return read.location == written.location && read.message == written.message;
    });
  };
  std::ostringstream text;
  const auto end = std::find_if(log_.rbegin(), log_.rend(), was_read).base();
  for (auto step = log_.begin(); step != end; ++step) {
    text << "  writer " << int{step->writer} << "  " << name_of(step->step) << ' ';
    if (step->step == Step::kW2) {
      text << "fence\n";
      continue;
    }
    text << word_at(step->location) << " = " << memory_.message(step->location, step->message).value
         << ", " << name_of(step->order) << '\n';
  }
  for (const ReaderStep& step : reader_steps) {
    text << "  reader    " << name_of(step.step) << ' ';
    if (step.step == Step::kR4) {
      text << "fence\n";
      continue;
    }
    text << word_at(step.location) << " is " << memory_.message(step.location, step.message).value
         << ", " << name_of(step.order) << '\n';
  }
  return text.str();
}

std::memory_order PublicationModel::order_of(Step step, std::memory_order order) const {
  return mutant_.relaxed[static_cast<std::size_t>(step)] ? std::memory_order_relaxed : order;
}

std::size_t PublicationModel::location_of(const std::uint64_t& word) const {
  return static_cast<std::size_t>(&word - words_.data());
}

std::string PublicationModel::word_at(std::size_t location) const {
  if (location == kLatest) return "latest";
  if (is_sequence(location)) return "slot " + std::to_string(location - kSequence) + " sequence";
  const std::size_t word = location - kPayload;
  return "slot " + std::to_string(word / payload_words_) + " word " +
         std::to_string(word % payload_words_);
}

std::uint64_t PublicationModel::load(Step step, std::size_t location, std::memory_order order) {
  const std::size_t newest = memory_.newest(location);
  const std::size_t message = newest - choices_->choose(newest - reader_->current[location] + 1);
  record_.steps.push_back({step, order, location, message});
  return reader_->load(memory_, location, message, order);
}

bool PublicationModel::lives() {
  if (writer_steps_ == killed_before_) return false;
  ++writer_steps_;
  return true;
}

std::uint64_t ModelAtomics::load(const std::uint64_t& word, std::memory_order order) noexcept {
  std::vector<Attempt>& attempts = model->record_.attempts;
  const std::size_t location = model->location_of(word);
  if (location == kLatest) {
    const std::uint64_t n = model->load(Step::kR1, kLatest, model->order_of(Step::kR1, order));
    const Message& message = model->memory_.message(kLatest, model->reader_->current[kLatest]);
    if (n > 0) attempts.push_back({n, publication_of(n, message.writer), 0});
    return n;
  }
  if (!is_sequence(location))
    return model->load(Step::kR3, location, model->order_of(Step::kR3, order));
  Attempt& attempt = attempts.back();
  // The last step of an attempt is R1 when its sequence has not yet been read.
  const Step step = model->record_.steps.back().step == Step::kR1 ? Step::kR2 : Step::kR5;
  order = model->order_of(step, order);
  attempt.sequence = model->mutant_.checks_sequence ? model->load(step, location, order)
                                                    : 2 * model->load(step, kLatest, order);
  return attempt.sequence;
}

void ModelAtomics::store(std::uint64_t& word, std::uint64_t value,
                         std::memory_order order) noexcept {
  const std::size_t location = model->location_of(word);
  Step step = Step::kW3;
  if (location == kLatest) step = Step::kW5;
  if (is_sequence(location)) step = value % 2 == 1 ? Step::kW1 : Step::kW4;
  if (step == Step::kW1 && !model->mutant_.has_odd_mark) return;
  if (!model->lives()) return;
  order = model->order_of(step, order);
  model->memory_.store(location, value, order);
  model->log_.push_back(
      {step, order, location, model->memory_.newest(location), model->memory_.writer()});
}

void ModelAtomics::fence(std::memory_order order) noexcept {
  const bool is_writer = order == std::memory_order_release;
  const Step step = is_writer ? Step::kW2 : Step::kR4;
  if (model->order_of(step, order) == std::memory_order_relaxed) return;
  constexpr std::size_t kNoLocation = std::numeric_limits<std::size_t>::max();
  if (!is_writer) {
    model->record_.steps.push_back({step, order, kNoLocation, 0});
    model->reader_->acquire_fence();
  } else if (model->lives()) {
    model->log_.push_back({step, order, kNoLocation, 1, model->memory_.writer()});
    model->memory_.release_fence();
  }
}

}  // namespace stillgrid::model
