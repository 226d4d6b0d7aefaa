#include <catch2/catch.hpp>
#include <limits>
#include <random>

#include "shared/tools/scene_relay/sequence.hpp"
#include "shared/tools/scene_relay/snapshot_coding.hpp"
#include "tests/network/relay/generated_snapshots.hpp"
#include "tests/network/relay/message_numbers.hpp"
#include "tests/network/relay/relayed_scene.hpp"
#include "tests/shared/publication/field_scene.hpp"

namespace stillgrid::scene_relay::hostile_messages_test {
namespace {

publication::StaticScene of_two_hands(publication::StaticScene scene) {
  scene.hands = {"left", "right"};
  scene.hand = 1;
  return scene;
}

/// A message of a scene with all that there is, to be spoilt.
struct HostileScene {
  HostileScene()
      : writer(session.name(), of_two_hands(publication::field_scene()), 31, 33'333'333,
               proto::Clock::kMonotonic, 0),
        told(view_of(session.name()), 0xE),
        message(told.message()) {}
  publication::TestSession session;
  publication::SceneWriter writer;
  ToldScene told;
  SceneMessage message;  // whose arrays are those of `told`
};

/// Whether a call throws MessageError with one line.
template <class Call>
bool is_refused(Call&& call) {
  try {
    call();
  } catch (const MessageError& error) {
    const std::string line = error.what();
    return !line.empty() && line.find_first_of("\r\n") == std::string::npos;
  }
  return false;
}

/// Every number, one after the other, set to what none may be; the names of those that were taken.
template <class Message, class Use>
std::string taken(Message& message, const Use& use) {
  std::string names;
  std::size_t tried = 0;
  const auto try_one = [&](const std::string& name, auto& number, auto value) {
    const auto before = number;
    number = value;
    ++tried;
    if (!is_refused(use)) names += name + " = " + std::to_string(value) + ", ";
    number = before;
  };
  const auto try_real = [&](const std::string& name, auto& number) {
    using Real = std::remove_reference_t<decltype(number)>;
    using Limits = std::numeric_limits<Real>;
    for (const Real value :
         {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(), Real(1e30), Real(-1e30)})
      try_one(name, number, value);
  };
  const NumberVisitor visitor{.real32 = try_real,
                              .real64 = try_real,
                              .index = [&](const std::string& name, std::uint32_t& number) {
                                try_one(name, number, 0xfffffff0U);
                              }};
  visit(visitor, message);
  CHECK(tried > 300);
  return names;
}

}  // namespace

TEST_CASE("Of a scene's message no number that cannot be is published", "[hostile_messages]") {
  HostileScene hostile;
  REQUIRE_FALSE(is_refused([&] { static_cast<void>(scene_of(hostile.message)); }));
  CHECK(taken(hostile.message, [&] { static_cast<void>(scene_of(hostile.message)); }) == "");
}

TEST_CASE("What a moving body's rest says does not come into the segment", "[hostile_messages]") {
  HostileScene hostile;
  for (auto& body : mutable_elements(hostile.message.field_bodies))
    if (body.moving != 0) body.rest.position_m[1] = std::numeric_limits<float>::quiet_NaN();
  for (const publication::PublishedField& field : scene_of(hostile.message).fields)
    CHECK(field.body.rest.position_m[1] == Approx(field.body.moving == 0 ? -0.1F : 0.0F));
}

TEST_CASE("Of a scene's message no count that cannot be is published", "[hostile_messages]") {
  const auto is_spoilt_refused = [&](auto&& spoil) {
    HostileScene spoilt;  // its arrays are spoilt too
    spoil(spoilt.message);
    return is_refused([&] { static_cast<void>(scene_of(spoilt.message)); });
  };
  CHECK_FALSE(is_spoilt_refused([](SceneMessage&) {}));
  CHECK(is_spoilt_refused([](auto& m) { m.materials._length = proto::kMaxMaterials + 1; }));
  CHECK(is_spoilt_refused([](auto& m) { m.materials._length = 1; }));  // two are used
  CHECK(is_spoilt_refused([](auto& m) { m.materials._length = 0; }));
  CHECK(is_spoilt_refused([](auto& m) { m.planes._length = proto::kMaxPlanes + 1; }));
  CHECK(is_spoilt_refused([](auto& m) { m.tool._length = proto::kMaxToolSpheres + 1; }));
  CHECK(is_spoilt_refused([](auto& m) { m.tool._length = 0; }));
  CHECK(is_spoilt_refused([](auto& m) { m.spheres._length = kMaxSpheres + 1; }));
  CHECK(is_spoilt_refused([](auto& m) { m.moving_capacity = kMaxSpheres + 1; }));
  CHECK(is_spoilt_refused([](auto& m) { m.fields._length = proto::kMaxFields + 1; }));
  CHECK(is_spoilt_refused([](auto& m) { m.fields._length = 1; }));  // two are used
  CHECK(is_spoilt_refused([](auto& m) { m.field_bodies._length = proto::kMaxFields + 1; }));
  CHECK(is_spoilt_refused([](auto& m) {
    m.fields._buffer[1].numbers._buffer[3] =
        1 + m.fields._buffer[1].fine._length / proto::kBrickCoefficients;
  }));
  CHECK(is_spoilt_refused([](auto& m) { m.hands._length = proto::kMaxHands + 1; }));
  CHECK(is_spoilt_refused([](auto& m) { m.hands._length = 0; }));  // it is hand 1
  CHECK(is_spoilt_refused([](auto& m) { m.hand = m.hands._length; }));
  CHECK(is_spoilt_refused([](auto& m) { m.hands._buffer[0].name[0] = '/'; }));
  std::vector<std::uint8_t> model(71);
  const auto with_model = [&](SceneMessage& m, std::uint32_t bytes, std::uint64_t capacity) {
    point_to(m.model, model);
    m.model._length = bytes;
    m.state_capacity = capacity;
  };
  CHECK_FALSE(is_spoilt_refused([&](auto& m) { with_model(m, 71, 1); }));
  CHECK(is_spoilt_refused([&](auto& m) { with_model(m, 71, 0); }));
  CHECK(is_spoilt_refused([&](auto& m) { with_model(m, 71, kMaxModel_bytes + 1); }));
  CHECK(is_spoilt_refused([&](auto& m) { with_model(m, 71, ~std::uint64_t{0}); }));
  CHECK(is_spoilt_refused([&](auto& m) { with_model(m, kMaxModel_bytes + 1, 1); }));
  CHECK(is_spoilt_refused([](auto& m) { m.state_capacity = 8; }));  // without a model
  CHECK(is_spoilt_refused([](auto& m) { m.period_ns = 0; }));
  CHECK(is_spoilt_refused([](auto& m) { m.period_ns = ~std::uint64_t{0}; }));
  HostileScene hostile;
  std::mt19937 random(GENERATE(1U, 2U, 3U));
  for (auto& field : mutable_elements(hostile.message.fields))
    for (std::uint32_t* length : {&field.coarse._length, &field.numbers._length,
                                  &field.stiffness._length, &field.fine._length}) {
      const std::uint32_t before = *length;
      if (before == 0) continue;
      for (const std::uint32_t now :
           {before - 1, before + 1, static_cast<std::uint32_t>(random() % before)}) {
        *length = now;
        // Without its map a field is another that may be.
        const bool may_be = length == &field.stiffness._length && now == 0;
        CHECK((may_be || is_refused([&] { static_cast<void>(scene_of(hostile.message)); })));
      }
      *length = before;
    }
}

TEST_CASE("Of a snapshot no number that cannot be is decoded", "[hostile_messages]") {
  const auto seed = GENERATE(range(1U, 4U));
  GeneratedSnapshots scene(seed, Going::kRelabelled, 23);
  SnapshotEncoder encoder(0xE);
  const SnapshotMessage* told = nullptr;
  do {
    told = &encoder.encode(scene.next(), 1);
  } while (told->state._length == 0);
  KeptMessage kept(*told);
  ToldSnapshot snapshot;
  const auto decode = [&] {
    static_cast<void>(SnapshotDecoder().decode(kept.message(), scene.limits(), snapshot));
  };
  REQUIRE_FALSE(is_refused(decode));
  CHECK(taken(kept.message(), decode) == "");
}

TEST_CASE("Of a snapshot no count that cannot be is decoded", "[hostile_messages]") {
  const auto seed = GENERATE(range(1U, 4U));
  GeneratedSnapshots scene(seed, Going::kAllMove, 23);
  ToldSnapshot good = scene.next();
  const auto is_spoilt_refused = [&](auto&& spoil) {
    ToldSnapshot snapshot = good;
    spoil(snapshot);
    SnapshotEncoder encoder(0xE);
    ToldSnapshot decoded;
    return is_refused([&] {
      static_cast<void>(
          SnapshotDecoder().decode(encoder.encode(snapshot, 1), scene.limits(), decoded));
    });
  };
  CHECK_FALSE(is_spoilt_refused([](ToldSnapshot&) {}));
  CHECK_FALSE(is_spoilt_refused([](auto& s) { s.state.clear(); }));
  CHECK_FALSE(is_spoilt_refused([&](auto& s) { s.state.resize(scene.limits().state_capacity); }));
  CHECK(is_spoilt_refused([&](auto& s) { s.state.resize(scene.limits().state_capacity + 1); }));
  CHECK(is_spoilt_refused([](auto& s) { s.fields.resize(1); }));
  CHECK(is_spoilt_refused([](auto& s) { s.fields.push_back(s.fields[0]); }));
  CHECK(is_spoilt_refused([](auto& s) {
    s.motions.push_back(s.motions[0]);
    s.labels.push_back(s.labels[0]);
  }));
  CHECK(is_spoilt_refused([](auto& s) { s.labels.pop_back(); }));
}

}  // namespace stillgrid::scene_relay::hostile_messages_test
