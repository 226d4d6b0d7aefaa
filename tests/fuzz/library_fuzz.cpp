#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "proto/stillgrid.hpp"
#include "shared/publication/tool_segment.hpp"
#include "tests/fuzz/fuzz_input.hpp"
#include "tests/fuzz/library_arguments.hpp"

/// A clumsy program on libstillgrid: calls in any order, on handles that may be null, with numbers
/// that are none, sizes and counts that are wrong. Each call ends with a known code; one that fails
/// says so in a line, and has changed nothing that a reader or the caller sees.
///
/// Input: calls, each a u8 and its arguments as the functions below take them.
namespace stillgrid::fuzz {
namespace {

constexpr int kMaxCalls = 48;

std::array<Hand, 5> some_hands(FuzzInput& input, const double* tool_m) {
  std::array<Hand, 5> hands;
  constexpr std::array<const char*, 5> kNames{"a", "b", "a b", "c", "a"};
  for (std::size_t i = 0; i < hands.size(); ++i) {
    hands[i].tool_count = input.take<std::uint8_t>() % 8U;
    hands[i].tool_m = perhaps(input, tool_m);
    hands[i].name = input.take<std::uint8_t>() < 128 ? kNames[i] : nullptr;
    hands[i].device_scale = number(input);
  }
  // Another size would be right: it tells where the next one stands.
  if (size_of(input, 0) != 0) hands[0].struct_size = 7;
  return hands;
}

class Program {
 public:
  Program() : session_("fuzz-" + std::to_string(::getpid())) {}
  ~Program() {
    stillgrid_publisher_close(publisher_);
    stillgrid_reader_close(reader_);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void call(FuzzInput& input);

 private:
  void open_publisher(FuzzInput& input);
  void open_reader(FuzzInput& input);
  void publish_something(FuzzInput& input, unsigned which);
  void push(FuzzInput& input);
  void read(FuzzInput& input, unsigned which);
  void write_tool(FuzzInput& input);
  void decompose(FuzzInput& input);

  /// The newest snapshot, as an onlooker sees it.
  std::vector<float> seen() {
    SessionState state;
    Spheres spheres(kRoom);
    // Of a session with named hands it sees nothing.
    if (stillgrid_reader_poll(witness_.handle(), &state) != STILLGRID_OK ||
        stillgrid_reader_snapshot(witness_.handle(), &spheres) != STILLGRID_OK)
      return {};
    return spheres.positions;
  }

  std::string session_;
  Reader witness_{session_.c_str()};
  stillgrid_publisher* publisher_ = nullptr;
  stillgrid_reader* reader_ = nullptr;
  std::optional<publication::ToolWriter> tool_;
  bool is_virtual_ = false;
  int waits_ = 0, rests_ = 0;
};

void Program::open_publisher(FuzzInput& input) {
  Numbers some = numbers(input);
  stillgrid_material materials[2]{{500.0, 1.0, 0.2}, {number(input), number(input), 0.0}};
  stillgrid_plane plane{{0.0, 0.0, 1.0}, number(input), input.take<std::uint8_t>() % 3U, 0};
  if (input.take<std::uint8_t>() > 200) fill(input, plane.normal);
  Shapes fixed(std::span(some.doubles).first(2), {}, {}, std::span(some.doubles).subspan(8, 6));
  fixed.struct_size = size_of(input, sizeof(stillgrid_shapes));
  std::array<Hand, 5> hands = some_hands(input, some.doubles.data());
  Scene scene;
  const std::string name = input.take<std::uint8_t>() > 250 ? "a/b" : session_;
  scene.session = name.c_str();
  scene.name = "fuzz";
  scene.clock = input.take<std::uint8_t>() % 3U;
  constexpr std::array<double, 4> kPeriods_s{1e-4, 1e-3, 0.03, 1e-3};
  const auto period = input.take<std::uint8_t>();
  scene.period_s = period < 200 ? kPeriods_s[period % 4U] : number(input);
  scene.sphere_capacity = period == 255 ? 0xFFFFFFFF : input.take<std::uint8_t>() % (kRoom - 4);
  scene.material_count = input.take<std::uint8_t>() % 3U;
  scene.plane_count = input.take<std::uint8_t>() % 2U;
  scene.hand_count = input.take<std::uint8_t>() % 7U;
  if (scene.hand_count > 2) scene.hand_count = scene.hand_count == 6 ? 1000 : 0;
  scene.gives_inertia = input.take<std::uint8_t>() % 3U;
  scene.materials = perhaps(input, static_cast<const stillgrid_material*>(materials));
  scene.planes = perhaps(input, static_cast<const stillgrid_plane*>(&plane));
  scene.hands = hands.data();
  scene.static_shapes = input.take<std::uint8_t>() < 128 ? &fixed : nullptr;
  scene.struct_size = size_of(input, sizeof(stillgrid_scene));
  stillgrid_publisher* made = nullptr;
  const stillgrid_scene* given = perhaps(input, static_cast<const stillgrid_scene*>(&scene));
  const int code = stillgrid_publisher_open(given, perhaps(input, &made));
  check(code);
  require((code == STILLGRID_OK) == (made != nullptr), "what opened has a handle, else none");
  if (made == nullptr) return;
  require(publisher_ == nullptr, "a session has one publisher");
  publisher_ = made;
  is_virtual_ = scene.clock == STILLGRID_VIRTUAL_TIME;
}

void Program::open_reader(FuzzInput& input) {
  stillgrid_reader* made = nullptr;
  constexpr std::array<const char*, 4> kHands{nullptr, "a", "a b", "none"};
  const char* session = input.take<std::uint8_t>() > 250 ? "" : session_.c_str();
  const char* hand = kHands[input.take<std::uint8_t>() % 4U];
  const int code = stillgrid_reader_open(session, hand, perhaps(input, &made));
  check(code);
  require((code == STILLGRID_OK) == (made != nullptr), "what opened has a handle, else none");
  if (made == nullptr) return;
  stillgrid_reader_close(reader_);
  reader_ = made;
}

void Program::publish_something(FuzzInput& input, unsigned which) {
  const Numbers some = numbers(input);
  const double* values = perhaps(input, some.doubles.data());
  const std::uint32_t count = input.take<std::uint8_t>() % kRoom;
  stillgrid_publisher* publisher = perhaps(input, publisher_);
  const std::vector<float> before = seen();
  int code = STILLGRID_OK;
  std::uint64_t time_ns = 77;
  if (which == 0) {
    Sized<stillgrid_shapes> shapes;
    shapes.struct_size = size_of(input, sizeof(stillgrid_shapes));
    shapes.count = count;
    shapes.radii_m = values;
    shapes.materials = input.take<std::uint8_t>() < 128 ? some.integers.data() : nullptr;
    shapes.bodies = input.take<std::uint8_t>() < 128 ? some.integers.data() : nullptr;
    const stillgrid_shapes* given = &shapes;
    code = stillgrid_publisher_set_shapes(publisher, perhaps(input, given));
  } else if (which == 1) {
    code = stillgrid_publisher_set_spheres(publisher, count, values,
                                           input.take<std::uint8_t>() < 128 ? values : nullptr);
  } else if (which == 2) {
    std::array<stillgrid_push, 4> pushes{};
    std::uint32_t room = 4;
    code = stillgrid_publisher_pushes(publisher, number(input), pushes.data(), &room);
  } else if (which == 3) {
    // In virtual time nobody answers after the first: a call that waits says so after 100 ms.
    if (is_virtual_ && ++waits_ > 2) return;
    code = stillgrid_publisher_wait(publisher, perhaps(input, &time_ns));
    require(code == STILLGRID_OK || time_ns == 77, "a call that failed writes nothing");
  } else {
    code = stillgrid_publisher_publish(publisher, which == 4 ? 0 : input.take<std::uint64_t>());
  }
  check(code);
  require(code >= 0 || seen() == before, "a call that failed publishes nothing");
}

void Program::push(FuzzInput& input) {
  std::array<stillgrid_response, kRoom> responses{};
  const auto sound = input.take<std::uint8_t>();
  for (std::uint32_t i = 0; i < kRoom; ++i) {
    responses[i].body = sound < 128 ? i : i % 3;
    for (std::size_t diagonal = 0; diagonal < 36; diagonal += 7)
      responses[i].inverse_inertia[diagonal] = i < 2 ? number(input) : 1.0;
  }
  if (sound > 200) fill(input, responses[1].inverse_inertia);
  if (sound % 2 == 1) fill(input, responses[0].velocity);
  stillgrid_publisher* publisher = perhaps(input, publisher_);
  const std::uint32_t known = input.take<std::uint8_t>() % kRoom;
  const stillgrid_response* given = responses.data();
  check(stillgrid_publisher_set_responses(publisher, known, perhaps(input, given)));
  std::array<stillgrid_push, 4> pushes{};
  std::uint32_t count = input.take<std::uint8_t>() % 5;
  const double step_s = number(input);
  stillgrid_push* room = perhaps(input, pushes.data());
  check(stillgrid_publisher_pushes(publisher, step_s, room, perhaps(input, &count)));
  for (const stillgrid_push& one : pushes)
    for (const double force_N : one.force_N) require(std::isfinite(force_N), "a push is a force");
}

void Program::read(FuzzInput& input, unsigned which) {
  stillgrid_reader* reader = perhaps(input, reader_);
  if (which == 0) {
    check_filled(input, SessionState(),
                 [&](stillgrid_session_state* at) { return stillgrid_reader_poll(reader, at); });
  } else if (which == 1) {
    std::array<stillgrid_material, 2> materials{};
    std::array<stillgrid_plane, 2> planes{};
    std::array<double, 64> tool_m{};
    Sized<stillgrid_fixed> fixed;
    fixed.material_capacity = input.take<std::uint8_t>() % 3U;
    fixed.plane_capacity = input.take<std::uint8_t>() % 3U;
    fixed.tool_capacity = input.take<std::uint8_t>() % 17U;
    fixed.materials = perhaps(input, materials.data());
    fixed.planes = perhaps(input, planes.data());
    fixed.tool_m = perhaps(input, tool_m.data());
    check_filled(input, fixed,
                 [&](stillgrid_fixed* at) { return stillgrid_reader_fixed(reader, at); });
  } else if (which < 5) {
    constexpr std::array kCalls{stillgrid_reader_snapshot, stillgrid_reader_static,
                                stillgrid_reader_displayed};
    Spheres spheres(kRoom);
    spheres.capacity = input.take<std::uint8_t>() % (kRoom + 1);
    spheres.radii_m = perhaps(input, spheres.radii_m);
    spheres.positions_m = perhaps(input, spheres.positions_m);
    const stillgrid_snapshot given = spheres;
    check_filled(input, given,
                 [&](stillgrid_snapshot* at) { return kCalls[which - 2](reader, at); });
  } else {
    check_filled(input, Tool(),
                 [&](stillgrid_tool* at) { return stillgrid_reader_tool(reader, at); });
    const std::uint32_t hand = input.take<std::uint8_t>() % 4;
    check_filled(input, Tool(), [&](stillgrid_tool* at) {
      return stillgrid_publisher_tool(publisher_, hand, at);
    });
  }
}

/// A haptic_server's tick, sound or not.
void Program::write_tool(FuzzInput& input) {
  if (!tool_) tool_.emplace(session_, 1'000'000, proto::Clock::kMonotonic, 0);
  proto::ToolState state{};
  state.time_ns = 5;
  state.tick = 1;
  state.orientation_xyzw[3] = 1.0;
  for (double& x_m : state.position_m) x_m = number(input);
  for (double& v_m_s : state.velocity_m_s) v_m_s = number(input);
  proto::DisplayedSnapshot& shown = state.before.displayed;
  SessionState session;
  stillgrid_reader_poll(witness_.handle(), &session);
  shown.scene_epoch = session.scene_epoch;
  shown.snapshot_id = input.take<std::uint8_t>() % 4;
  shown.alpha = number(input);
  shown.is_local = input.take<std::uint8_t>() % 3;
  tool_->publish(state);
  // Longer than a publisher takes to see who comes.
  if (++rests_ == 1) std::this_thread::sleep_for(std::chrono::milliseconds(25));
}

void Program::decompose(FuzzInput& input) {
  constexpr std::array<std::uint32_t, 12> kTetrahedron{0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
  std::array<double, 12> vertices_m{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::array<std::uint32_t, 12> triangles = kTetrahedron;
  const auto spoiled = input.take<std::uint8_t>();
  if (spoiled < 100) vertices_m[spoiled % 12U] = number(input);
  if (spoiled % 3 == 0) triangles[spoiled % 12U] = input.take<std::uint32_t>();
  Sized<stillgrid_mesh> mesh;
  mesh.vertex_count = input.take<std::uint8_t>() > 250 ? 3 : 4;
  mesh.triangle_count = spoiled % 5U == 0 ? spoiled % 4U : 4;
  mesh.vertices_m = perhaps(input, static_cast<const double*>(vertices_m.data()));
  mesh.triangles = perhaps(input, static_cast<const std::uint32_t*>(triangles.data()));
  mesh.struct_size = size_of(input, sizeof(stillgrid_mesh));
  Sized<stillgrid_cover> cover;
  // No finer than what takes a blink.
  const double wanted_m = number(input);
  (spoiled < 128 ? cover.surface_spacing_m : cover.volume_spacing_m) =
      wanted_m > 0.0 && wanted_m < 0.3 ? 0.3 : wanted_m;
  cover.struct_size = size_of(input, sizeof(stillgrid_cover));
  stillgrid_decomposition* made = nullptr;
  const stillgrid_mesh* given_mesh = perhaps(input, static_cast<const stillgrid_mesh*>(&mesh));
  const stillgrid_cover* given_cover = perhaps(input, static_cast<const stillgrid_cover*>(&cover));
  const int code = stillgrid_decompose(given_mesh, given_cover, perhaps(input, &made));
  check(code);
  require((code == STILLGRID_OK) == (made != nullptr), "what was made has a handle, else none");
  const double* spheres = stillgrid_decomposition_spheres(made);
  for (std::size_t i = 0; i < 4 * std::size_t{stillgrid_decomposition_count(made)}; ++i)
    require(std::isfinite(spheres[i]), "a sphere is made of numbers");
  stillgrid_decomposition_free(made);
}

void Program::call(FuzzInput& input) {
  const unsigned which = input.take<std::uint8_t>() % 20U;
  switch (which) {
    case 0:
    case 1:
      return open_publisher(input);
    case 2:
      return open_reader(input);
    case 3:
      return write_tool(input);
    case 4:
      return push(input);
    case 5:
      return decompose(input);
    case 6:
      stillgrid_publisher_close(publisher_);
      publisher_ = nullptr;
      return;
    case 7:
      tool_.reset();
      return;
    default:
      return which < 14 ? publish_something(input, which - 8) : read(input, which - 14);
  }
}

}  // namespace
}  // namespace stillgrid::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  stillgrid::fuzz::FuzzInput input({data, size});
  stillgrid::fuzz::Program program;
  for (int i = 0; i < stillgrid::fuzz::kMaxCalls && !input.is_empty(); ++i) program.call(input);
  return 0;
}
