#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "shared/dynamics/description.hpp"
#include "shared/dynamics/engine_method.hpp"
#include "shared/dynamics/prescribed_motion.hpp"
#include "shared/dynamics/scene_state.hpp"

namespace stillgrid::dynamics {

/// All that two processes need to step the same scene, beside the state and the tools' paths.
/// Driven bodies are the prescribed ones, then one that carries all that is static if
/// has_static_body, then one for each hand.
struct SceneModel {
  Description description;
  SceneState start;
  std::vector<PrescribedMotion> prescribed;
  bool has_static_body = false;
  std::size_t hands = 0;
  bool is_implicit = false;     // implicit Euler of the whole scene; else small steps
  double tolerance_m_s = 1e-8;  // see implicit_euler()

  [[nodiscard]] EngineMethod method() const;
};

/// Throws std::invalid_argument where an index or a size is out of range, or a number contradicts
/// its meaning.
void validate(const SceneModel& model);

/// The items of a tick of a scene, without contacts.
struct TickCounts {
  double springs = 0.0;  // and joints
  double spheres = 0.0;  // that move
  double all_spheres = 0.0;
  double unknowns = 0.0;  // velocities of nodes and free bodies
};
[[nodiscard]] TickCounts counts_of(const Description& description);

/// Returns about how many ns a tick takes on a processor of 3 GHz, by counts. It lists no contacts.
/// products: by implicit Euler, else 0. rows: of contacts, sixteen each.
[[nodiscard]] double counted_tick_ns(const TickCounts& counts, double substeps, double products,
                                     double rows) noexcept;
/// Returns how much longer a tick takes that lists contacts anew. pairs: of near spheres.
/// comparisons: of spheres, to find them.
[[nodiscard]] double counted_listing_ns(const TickCounts& counts, double pairs,
                                        double comparisons) noexcept;
/// Returns counted_tick_ns() of a model's ticks without contacts: as many substeps as it needs at
/// the start, or 30 products.
[[nodiscard]] double counted_tick_ns(const SceneModel& model);
/// The longest ticks that fit into a tick of the hand: without contacts, and with contacts and
/// their listing.
inline constexpr double kLongestTick_ns = 250'000.0;
inline constexpr double kLongestTickWithContacts_ns = 2.0 * kLongestTick_ns;

/// Returns the model as bytes. They hold all of its fields but their distances.
[[nodiscard]] std::vector<std::byte> encode(const SceneModel& model);
/// Returns the validated model of encode()'s bytes, equal to the bit. The bytes may be hostile: it
/// throws std::invalid_argument where they hold no such model or a number beyond 1e12. It allocates
/// about as much as they are long. distances: one for each of Description::fields, in this order.
/// It throws where they are more or fewer, or one is null.
[[nodiscard]] SceneModel decode(
    std::span<const std::byte> bytes,
    std::span<const std::shared_ptr<const collision::DistanceField>> distances = {});

}  // namespace stillgrid::dynamics
