#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "stillgrid.h"

/// libstillgrid for C++20: the calls of stillgrid.h, their handles owned, their errors thrown. What
/// a call means, its units, its thread and whether it may allocate stand there.
namespace stillgrid {

/// A call that failed: the code, STILLGRID_E_..., and in what() the line.
class Error : public std::runtime_error {
 public:
  Error(int code, const std::string& line) : std::runtime_error(line), code_(code) {}
  [[nodiscard]] int code() const noexcept { return code_; }

 private:
  int code_;
};

namespace detail {

/// A result code that is no error; throws Error of another.
inline int succeeded(int code) {
  if (code < 0) throw Error(code, stillgrid_last_error());
  return code;
}

/// Throws Error unless an array is as long as it must be.
inline void require_size(std::size_t size, std::size_t expected, const char* name) {
  if (size == expected) return;
  throw Error(STILLGRID_E_ARGUMENT, std::string(name) + ": " + std::to_string(size) +
                                        " values: expected " + std::to_string(expected));
}

/// Null of an array that is not given.
template <class T>
[[nodiscard]] const T* or_null(std::span<const T> values) noexcept {
  return values.empty() ? nullptr : values.data();
}

template <auto Close>
struct Closes {
  template <class Handle>
  void operator()(Handle* handle) const noexcept {
    Close(handle);
  }
};
template <class Handle, auto Close>
using Owned = std::unique_ptr<Handle, Closes<Close>>;

}  // namespace detail

/// A struct of stillgrid.h that knows its size; all else is 0.
template <class Struct>
struct Sized : Struct {
  Sized() noexcept : Struct{} { this->struct_size = sizeof(Struct); }
};
using Scene = Sized<stillgrid_scene>;
using Hand = Sized<stillgrid_hand>;
using Tool = Sized<stillgrid_tool>;
using SessionState = Sized<stillgrid_session_state>;

/// Spheres by their arrays, as stillgrid_shapes; the arrays must outlive it. Throws Error where
/// they differ in length.
class Shapes : public Sized<stillgrid_shapes> {
 public:
  explicit Shapes(std::span<const double> radii, std::span<const std::uint32_t> materials_of = {},
                  std::span<const std::uint32_t> bodies_of = {},
                  std::span<const double> static_positions_m = {}) {
    if (!materials_of.empty()) detail::require_size(materials_of.size(), radii.size(), "materials");
    if (!bodies_of.empty()) detail::require_size(bodies_of.size(), radii.size(), "bodies");
    if (!static_positions_m.empty())
      detail::require_size(static_positions_m.size(), 3 * radii.size(), "positions_m");
    count = static_cast<std::uint32_t>(radii.size());
    radii_m = detail::or_null(radii);
    materials = detail::or_null(materials_of);
    bodies = detail::or_null(bodies_of);
    positions_m = detail::or_null(static_positions_m);
  }
};

/// A simulation's side of a session; the session ends with it.
class Publisher {
 public:
  explicit Publisher(const Scene& scene) {
    stillgrid_publisher* handle = nullptr;
    detail::succeeded(stillgrid_publisher_open(&scene, &handle));
    handle_.reset(handle);
  }

  /// The time of the state to publish next, ns; nothing where the session came to its end, or
  /// `stop` was requested.
  std::optional<std::uint64_t> wait(const std::stop_token& stop = {}) {
    std::uint64_t time_ns = 0;
    while (!stop.stop_requested()) {
      const int code = detail::succeeded(stillgrid_publisher_wait(handle_.get(), &time_ns));
      if (code == STILLGRID_OK) return time_ns;
      if (code == STILLGRID_NOTHING) break;
    }
    return std::nullopt;
  }

  void set_shapes(const Shapes& shapes) {
    detail::succeeded(stillgrid_publisher_set_shapes(handle_.get(), &shapes));
  }
  /// 3 values a sphere; velocities_m_s: as many, or none.
  void set_spheres(std::span<const double> positions_m,
                   std::span<const double> velocities_m_s = {}) {
    if (!velocities_m_s.empty())
      detail::require_size(velocities_m_s.size(), positions_m.size(), "velocities_m_s");
    detail::succeeded(stillgrid_publisher_set_spheres(handle_.get(), spheres_in(positions_m),
                                                      detail::or_null(positions_m),
                                                      detail::or_null(velocities_m_s)));
  }
  void set_responses(std::span<const stillgrid_response> responses) {
    detail::succeeded(stillgrid_publisher_set_responses(
        handle_.get(), static_cast<std::uint32_t>(responses.size()), detail::or_null(responses)));
  }
  /// The pushes, in the first of `room`.
  std::span<const stillgrid_push> pushes(double step_s, std::span<stillgrid_push> room) {
    auto count = static_cast<std::uint32_t>(room.size());
    detail::succeeded(stillgrid_publisher_pushes(handle_.get(), step_s, room.data(), &count));
    return room.first(count);
  }
  /// False where, in virtual time, a haptic_server came to its end.
  bool publish(std::uint64_t state_time_ns = 0) {
    return detail::succeeded(stillgrid_publisher_publish(handle_.get(), state_time_ns)) ==
           STILLGRID_OK;
  }
  /// Nothing while no haptic_server is there.
  [[nodiscard]] std::optional<Tool> tool(std::uint32_t hand = 0) {
    Tool tool;
    if (detail::succeeded(stillgrid_publisher_tool(handle_.get(), hand, &tool)) != STILLGRID_OK)
      return std::nullopt;
    return tool;
  }

  [[nodiscard]] stillgrid_publisher* handle() const noexcept { return handle_.get(); }

 private:
  static std::uint32_t spheres_in(std::span<const double> values) {
    detail::require_size(values.size() % 3, 0, "the last sphere");
    return static_cast<std::uint32_t>(values.size() / 3);
  }
  detail::Owned<stillgrid_publisher, stillgrid_publisher_close> handle_;
};

/// What is published once.
struct FixedScene {
  std::vector<stillgrid_material> materials;
  std::vector<stillgrid_plane> planes;
  std::vector<double> tool_m;    // 4 values a sphere
  Sized<stillgrid_fixed> place;  // of the device; the rest are the vectors'
};

/// Room for the spheres of a snapshot, 3 values each but for the last three, and its figures.
class Spheres : public Sized<stillgrid_snapshot> {
 public:
  explicit Spheres(std::uint32_t room)
      : positions(3 * std::size_t{room}),
        velocities(positions.size()),
        radii(room),
        material_numbers(room),
        body_numbers(room) {
    capacity = room;
    positions_m = positions.data();
    velocities_m_s = velocities.data();
    radii_m = radii.data();
    materials = material_numbers.data();
    bodies = body_numbers.data();
  }
  ~Spheres() = default;
  Spheres(Spheres&&) noexcept = default;  // vectors keep their place
  Spheres& operator=(Spheres&&) noexcept = default;
  Spheres(const Spheres&) = delete;
  Spheres& operator=(const Spheres&) = delete;

  std::vector<float> positions, velocities, radii;
  std::vector<std::uint32_t> material_numbers, body_numbers;
};

/// One who looks at a session.
class Reader {
 public:
  explicit Reader(const char* session = nullptr, const char* hand = nullptr) {
    stillgrid_reader* handle = nullptr;
    detail::succeeded(stillgrid_reader_open(session, hand, &handle));
    handle_.reset(handle);
  }

  SessionState poll() {
    SessionState state;
    detail::succeeded(stillgrid_reader_poll(handle_.get(), &state));
    return state;
  }
  /// Nothing while no simulation is there. state: of the last poll.
  [[nodiscard]] std::optional<FixedScene> fixed(const SessionState& state) {
    FixedScene scene;
    scene.materials.resize(state.material_count);
    scene.planes.resize(state.plane_count);
    scene.tool_m.resize(4 * std::size_t{state.tool_count});
    scene.place.material_capacity = state.material_count;
    scene.place.plane_capacity = state.plane_count;
    scene.place.tool_capacity = state.tool_count;
    scene.place.materials = scene.materials.data();
    scene.place.planes = scene.planes.data();
    scene.place.tool_m = scene.tool_m.data();
    if (detail::succeeded(stillgrid_reader_fixed(handle_.get(), &scene.place)) != STILLGRID_OK)
      return std::nullopt;
    scene.place.materials = nullptr;  // the vectors may move
    scene.place.planes = nullptr;
    scene.place.tool_m = nullptr;
    return scene;
  }
  /// Each: whether there was one, which then is in `spheres`.
  bool snapshot(Spheres& spheres) { return told(stillgrid_reader_snapshot, spheres); }
  bool static_spheres(Spheres& spheres) { return told(stillgrid_reader_static, spheres); }
  bool displayed(Spheres& spheres) { return told(stillgrid_reader_displayed, spheres); }
  /// Nothing while no haptic_server is there.
  [[nodiscard]] std::optional<Tool> tool() {
    Tool tool;
    if (!told(stillgrid_reader_tool, tool)) return std::nullopt;
    return tool;
  }

  [[nodiscard]] stillgrid_reader* handle() const noexcept { return handle_.get(); }

 private:
  template <class Struct>
  bool told(int (*call)(stillgrid_reader*, Struct*), std::type_identity_t<Struct>& into) {
    return detail::succeeded(call(handle_.get(), &into)) == STILLGRID_OK;
  }
  detail::Owned<stillgrid_reader, stillgrid_reader_close> handle_;
};

/// The spheres of a mesh.
class Decomposition {
 public:
  /// 3 values a vertex, 3 numbers of vertices a triangle.
  Decomposition(std::span<const double> vertices_m, std::span<const std::uint32_t> triangles,
                const Sized<stillgrid_cover>& cover) {
    detail::require_size(vertices_m.size() % 3, 0, "the last vertex");
    detail::require_size(triangles.size() % 3, 0, "the last triangle");
    Sized<stillgrid_mesh> mesh;
    mesh.vertex_count = static_cast<std::uint32_t>(vertices_m.size() / 3);
    mesh.triangle_count = static_cast<std::uint32_t>(triangles.size() / 3);
    mesh.vertices_m = detail::or_null(vertices_m);
    mesh.triangles = detail::or_null(triangles);
    stillgrid_decomposition* handle = nullptr;
    detail::succeeded(stillgrid_decompose(&mesh, &cover, &handle));
    handle_.reset(handle);
  }

  /// 4 values a sphere, centre and radius; as long as this lives, as the report.
  [[nodiscard]] std::span<const double> spheres() const noexcept {
    return {stillgrid_decomposition_spheres(handle_.get()),
            4 * std::size_t{stillgrid_decomposition_count(handle_.get())}};
  }
  [[nodiscard]] std::string_view report() const noexcept {
    return stillgrid_decomposition_report(handle_.get());
  }

 private:
  detail::Owned<stillgrid_decomposition, stillgrid_decomposition_free> handle_;
};

}  // namespace stillgrid
