#include "shared/tools/scene_relay/snapshot_coding.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <utility>

#include "shared/tools/scene_relay/told_scene.hpp"
#include "tests/network/relay/generated_snapshots.hpp"

namespace stillgrid::scene_relay::snapshot_coding_test {
namespace {

constexpr std::uint64_t kRelay = 0xA5;

struct Channel {
  double loss = 0.0, duplicated = 0.0;
  std::uint32_t most_delay =
      0;  // of snapshots that pass meanwhile; what is on its way is overtaken
};

/// An encoder and a decoder, and what is on its way between them, a step a snapshot.
class Line {
 public:
  Line(std::uint32_t seed, GeneratedSnapshots& scene) : random_(seed), scene_(scene) {}

  void step() {
    ++now_;
    const ToldSnapshot& snapshot = scene_.next();
    told_[{epoch_, snapshot.snapshot_id}] = snapshot;
    const SnapshotMessage& message = encoder_->encode(snapshot, epoch_);
    is_delta = message.against_id != 0;
    bytes = message_bytes(message);
    send(message);
    deliver();
    acknowledge();
  }

  void restart_encoder() { encoder_ = std::make_unique<SnapshotEncoder>(kRelay + now_); }
  void restart_decoder() { decoder_ = {}; }
  void begin_anew() {
    ++epoch_;
    scene_.begin_anew();
  }

  Channel channel;
  bool is_delta = false;  // the last that was sent
  std::size_t bytes = 0;  // likewise
  std::size_t decoded = 0, deltas = 0, wrong = 0, without_keyframe = 0, refused = 0;
  bool came = false;  // the last that was sent was decoded

 private:
  struct Ack {
    std::uint64_t due, epoch, keyframe_id;
  };
  bool is_one_of(double share) { return std::bernoulli_distribution(share)(random_); }
  std::uint64_t due() { return now_ + random_() % (channel.most_delay + 1); }

  void send(const SnapshotMessage& message) {
    if (is_one_of(channel.loss)) return;
    on_way_.emplace_back(due(), std::make_unique<KeptMessage>(message));
    if (is_one_of(channel.duplicated))
      on_way_.emplace_back(due(), std::make_unique<KeptMessage>(message));
  }

  void deliver() {
    came = false;
    std::vector<std::pair<std::uint64_t, std::unique_ptr<KeptMessage>>> later;
    for (auto& [due, kept] : on_way_) {
      if (due > now_)
        later.emplace_back(due, std::move(kept));
      else
        take(kept->message());
    }
    on_way_ = std::move(later);
  }

  void take(const SnapshotMessage& message) {
    if (message.scene_epoch > decoders_epoch_) {
      decoders_epoch_ = message.scene_epoch;
      decoder_.begin();
    }
    if (message.scene_epoch != decoders_epoch_) return;
    ToldSnapshot snapshot;
    try {
      if (decoder_.decode(message, scene_.limits(), snapshot) == Decoded::kWithoutKeyframe) {
        ++without_keyframe;
        return;
      }
    } catch (const MessageError&) {
      ++refused;
      return;
    }
    ++decoded;
    deltas += message.against_id != 0 ? 1U : 0U;
    wrong += are_same(snapshot, told_[{message.scene_epoch, message.snapshot_id}]) ? 0U : 1U;
    came = came || message.snapshot_id == told_.rbegin()->first.second;
  }

  void acknowledge() {
    if (!is_one_of(channel.loss)) acks_.push_back({due(), decoders_epoch_, decoder_.keyframe_id()});
    const auto arrived = std::stable_partition(acks_.begin(), acks_.end(),
                                               [&](const Ack& ack) { return ack.due > now_; });
    for (auto ack = arrived; ack != acks_.end(); ++ack)
      encoder_->acknowledge(ack->epoch, ack->keyframe_id);
    acks_.erase(arrived, acks_.end());
  }

  std::mt19937 random_;
  GeneratedSnapshots& scene_;
  std::unique_ptr<SnapshotEncoder> encoder_ = std::make_unique<SnapshotEncoder>(kRelay);
  SnapshotDecoder decoder_;
  std::uint64_t now_ = 0, epoch_ = 1, decoders_epoch_ = 0;
  std::map<std::pair<std::uint64_t, std::uint64_t>, ToldSnapshot> told_;
  std::vector<std::pair<std::uint64_t, std::unique_ptr<KeptMessage>>> on_way_;
  std::vector<Ack> acks_;
};

std::size_t whole_bytes(const ToldSnapshot& of) {
  return 128 + of.motions.size() * sizeof(Motion) + of.labels.size() * sizeof(Label) +
         of.fields.size() * sizeof of.fields[0] + of.state.size();
}

}  // namespace

TEST_CASE("What is decoded is what was told, bit for bit, whatever the channel does",
          "[snapshot_coding]") {
  const auto seed = GENERATE(range(1U, 6U));
  const Going going = GENERATE(from_range(std::begin(kGoings), std::end(kGoings)));
  std::mt19937 random(101 * seed);
  for (const Channel& channel :
       {Channel{}, Channel{0.07, 0.11, 3}, Channel{0.29, 0.3, 41}, Channel{0.3, 0.0, 0}}) {
    GeneratedSnapshots scene(seed, going, static_cast<std::uint32_t>(20 + random() % 211));
    Line line(seed, scene);
    line.channel = channel;
    for (int i = 0; i < 457; ++i) {
      if (random() % 59 == 0) line.restart_encoder();
      if (random() % 61 == 0) line.restart_decoder();
      if (random() % 83 == 0) line.begin_anew();
      line.step();
    }
    CHECK(line.wrong == 0);
    CHECK(line.refused == 0);
    CHECK(line.decoded > 120);
  }
}

TEST_CASE("Once the channel is clean each snapshot comes, and those that barely change as deltas",
          "[snapshot_coding]") {
  const auto seed = GENERATE(range(1U, 9U));
  const Going going =
      GENERATE(Going::kAtRest, Going::kSomeMove, Going::kRelabelled, Going::kAllMove);
  std::mt19937 random(7 * seed);
  GeneratedSnapshots scene(seed, going, 157);
  Line line(seed, scene);
  for (int round = 0; round < 4; ++round) {
    line.channel = {0.3, 0.2, 37};
    for (int i = 0; i < 171; ++i) line.step();
    if (round % 2 == 0) line.restart_encoder();
    if (round > 1) line.restart_decoder();
    line.channel = {};
    for (int i = 0; i < 59; ++i) line.step();  // what was on its way, and a keyframe's patience
    std::size_t lost = 0, deltas = 0, bytes = 0;
    for (int i = 0; i < 61; ++i) {
      line.step();
      bytes += line.bytes;
      lost += line.came ? 0U : 1U;
      deltas += line.is_delta ? 1U : 0U;
    }
    INFO("seed " << seed << ", round " << round);
    CHECK(lost == 0);
    if (going == Going::kAtRest) CHECK(deltas == 61);
    if (going == Going::kSomeMove)
      CHECK(bytes < 61 * 157 * (sizeof(Motion) + sizeof(Label)) * 4 / 5);
    if (going == Going::kSomeMove || going == Going::kRelabelled) CHECK(deltas > 40);
  }
  CHECK(line.wrong == 0);
}

TEST_CASE("Deltas begin however often is published and however long the way is",
          "[snapshot_coding]") {
  const std::uint64_t period_ns = GENERATE(1'000'000U, 4'100'000U, 33'333'333U, 310'000'000U);
  const auto seed = GENERATE(range(1U, 4U));
  const auto trip_snapshots = static_cast<std::uint32_t>(480'000'000 / period_ns);
  GeneratedSnapshots scene(seed, Going::kSomeMove, 157, period_ns);
  SnapshotEncoder encoder(kRelay);
  SnapshotDecoder decoder;
  std::vector<std::uint64_t> keyframes;  // that were there when a snapshot came
  std::size_t deltas = 0, without_keyframe = 0;
  for (std::uint32_t i = 0; i < 6 * trip_snapshots + 200; ++i) {
    const SnapshotMessage& message = encoder.encode(scene.next(), 1);
    ToldSnapshot snapshot;
    deltas += message.against_id != 0 ? 1U : 0U;
    without_keyframe +=
        decoder.decode(message, scene.limits(), snapshot) == Decoded::kWithoutKeyframe ? 1U : 0U;
    keyframes.push_back(decoder.keyframe_id());
    if (i >= trip_snapshots) encoder.acknowledge(1, keyframes[i - trip_snapshots]);
  }
  CHECK(deltas > 4 * trip_snapshots);
  CHECK(without_keyframe == 0);
}

TEST_CASE("While no acknowledgement comes through the deltas that are sent can be read",
          "[snapshot_coding]") {
  const auto seed = GENERATE(range(1U, 5U));
  GeneratedSnapshots scene(seed, Going::kSomeMove, 157);
  SnapshotEncoder encoder(kRelay);
  SnapshotDecoder decoder;
  std::size_t unread = 0, deltas = 0;
  for (int i = 0; i < 413; ++i) {
    const SnapshotMessage& message = encoder.encode(scene.next(), 1);
    ToldSnapshot snapshot;
    deltas += i > 5 && message.against_id != 0 ? 1U : 0U;
    unread += decoder.decode(message, scene.limits(), snapshot) == Decoded::kSnapshot ? 0U : 1U;
    if (i < 5) encoder.acknowledge(1, decoder.keyframe_id());
  }
  CHECK(deltas > 300);
  CHECK(unread == 0);
}

TEST_CASE("No delta costs more than the whole, and at rest next to nothing", "[snapshot_coding]") {
  const auto seed = GENERATE(range(1U, 6U));
  const Going going = GENERATE(from_range(std::begin(kGoings), std::end(kGoings)));
  GeneratedSnapshots scene(seed, going, 40 + 311 * (seed - 1));
  SnapshotEncoder encoder(kRelay);
  SnapshotDecoder decoder;
  std::size_t dearer = 0, needless = 0, deltas = 0, most_bytes = 0;
  for (int i = 0; i < 211; ++i) {
    const ToldSnapshot& told = scene.next();
    const SnapshotMessage& message = encoder.encode(told, 1);
    dearer += message_bytes(message) > whole_bytes(told) ? 1U : 0U;
    if (message.against_id != 0) {
      needless +=
          whole_bytes(told) - told.state.size() < SnapshotEncoder::kDeltaFrom_bytes ? 1U : 0U;
      ++deltas;
      most_bytes = std::max(most_bytes, message_bytes(message) - told.state.size());
    }
    ToldSnapshot snapshot;
    static_cast<void>(decoder.decode(message, scene.limits(), snapshot));
    encoder.acknowledge(1, decoder.keyframe_id());
  }
  CHECK(dearer == 0);
  CHECK(needless == 0);
  if (seed > 1 && going == Going::kAtRest) {
    CHECK(deltas == 210);
    CHECK(most_bytes == 128 + 2 * sizeof(FieldMotion));
  }
}

TEST_CASE("A keyframe that is unsound is refused, and none that deltas are told to",
          "[snapshot_coding]") {
  const auto seed = GENERATE(range(1U, 4U));
  GeneratedSnapshots scene(seed, Going::kAtRest, 157);
  SnapshotEncoder encoder(kRelay);
  SnapshotDecoder decoder;
  ToldSnapshot bad = scene.next(), snapshot;
  bad.motions[31].position_m[1] = std::numeric_limits<float>::quiet_NaN();
  const SnapshotMessage& first = encoder.encode(bad, 1);
  REQUIRE(first.is_keyframe);
  CHECK_THROWS_AS(decoder.decode(first, scene.limits(), snapshot), MessageError);
  CHECK(decoder.keyframe_id() == 0);
  bool came = false;
  for (int i = 0; i < 40 && !came; ++i) {
    encoder.acknowledge(1, decoder.keyframe_id());
    const SnapshotMessage& message = encoder.encode(scene.next(), 1);
    REQUIRE(decoder.decode(message, scene.limits(), snapshot) == Decoded::kSnapshot);
    came = message.against_id != 0;
  }
  CHECK(came);
}

TEST_CASE("An acknowledgement of what was not sent, or of another scene, is none",
          "[snapshot_coding]") {
  const auto seed = GENERATE(range(1U, 4U));
  GeneratedSnapshots scene(seed, Going::kAtRest, 157);
  SnapshotEncoder encoder(kRelay);
  const std::uint64_t keyframe = scene.next().snapshot_id;
  REQUIRE(encoder.encode(scene.next(), 7).is_keyframe);
  const std::uint64_t id = keyframe + 1;
  for (const std::uint64_t foreign : {std::uint64_t{0}, id - 1, id + 1, ~std::uint64_t{0}})
    encoder.acknowledge(7, foreign);
  encoder.acknowledge(6, id);
  encoder.acknowledge(0, id);
  CHECK(encoder.encode(scene.next(), 7).against_id == 0);
  encoder.acknowledge(7, id);
  CHECK(encoder.encode(scene.next(), 7).against_id == id);
  encoder.acknowledge(7, id - 1);  // stale
  encoder.acknowledge(6, 0);       // of the scene before
  CHECK(encoder.encode(scene.next(), 7).against_id == id);
  CHECK(encoder.encode(scene.next(), 8).against_id == 0);  // another scene
  encoder.acknowledge(8, id);                              // whose keyframe it is not
  CHECK(encoder.encode(scene.next(), 8).against_id == 0);
  encoder.acknowledge(8, id + 4);
  CHECK(encoder.encode(scene.next(), 8).against_id == id + 4);
  encoder.acknowledge(8, 0);  // the other side began anew
  CHECK(encoder.encode(scene.next(), 8).against_id == 0);
  encoder.acknowledge(8, id + 4);  // and this came late
  CHECK(encoder.encode(scene.next(), 8).against_id == 0);
}

TEST_CASE("A message whose counts or indices cannot be is refused, and nothing of it is kept",
          "[snapshot_coding]") {
  const auto seed = GENERATE(range(1U, 4U));
  GeneratedSnapshots scene(seed, Going::kRelabelled, 157);
  SnapshotEncoder encoder(kRelay);
  SnapshotDecoder decoder;
  ToldSnapshot snapshot;
  std::unique_ptr<KeptMessage> delta;
  while (!delta || delta->message().moved._length < 3 || delta->message().relabelled._length < 2) {
    encoder.acknowledge(1, decoder.keyframe_id());
    const SnapshotMessage& message = encoder.encode(scene.next(), 1);
    if (message.against_id == 0)
      static_cast<void>(decoder.decode(message, scene.limits(), snapshot));
    else
      delta = std::make_unique<KeptMessage>(message);
  }
  const std::uint64_t kept = decoder.keyframe_id();
  const auto is_refused = [&](auto&& spoil) {
    KeptMessage message(*delta);
    spoil(message.message());
    message.message().is_keyframe = message.message().against_id == 0;
    try {
      static_cast<void>(decoder.decode(message.message(), scene.limits(), snapshot));
    } catch (const MessageError& error) {
      CHECK(std::string(error.what()).find('\n') == std::string::npos);
      return decoder.keyframe_id() == kept;
    }
    return false;
  };
  REQUIRE_FALSE(is_refused([](SnapshotMessage&) {}));
  CHECK(is_refused([](auto& m) { m.moved._buffer[1] = m.moved._buffer[0]; }));
  CHECK(is_refused([](auto& m) { std::swap(m.moved._buffer[0], m.moved._buffer[2]); }));
  CHECK(is_refused([](auto& m) { m.moved._buffer[m.moved._length - 1] = m.sphere_count; }));
  CHECK(is_refused([](auto& m) { m.relabelled._buffer[1] = 0xffffffff; }));
  CHECK(is_refused([](auto& m) { --m.moved._length; }));
  CHECK(is_refused([](auto& m) { --m.labels._length; }));
  CHECK(is_refused([](auto& m) { ++m.sphere_count; }));
  CHECK(is_refused([](auto& m) { --m.sphere_count; }));
  CHECK(is_refused([](auto& m) { m.sphere_count = 0xffffffff; }));
  CHECK(is_refused([](auto& m) { m.against_id = 0; }));
  KeptMessage both(*delta);
  both.message().is_keyframe = true;
  CHECK_THROWS_AS(decoder.decode(both.message(), scene.limits(), snapshot), MessageError);
}

}  // namespace stillgrid::scene_relay::snapshot_coding_test
