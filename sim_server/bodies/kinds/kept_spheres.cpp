#include "sim_server/bodies/kinds/kept_spheres.hpp"

#include <array>
#include <chrono>
#include <cstdio>
#include <optional>
#include <stdexcept>

namespace stillgrid::bodies {
namespace {

std::string note_of(const BodyDescription& body, const spheres::Decomposition& result, bool is_kept,
                    double time_s) {
  const std::string name = "body '" + body.name + "': ";
  std::array<char, 200> text{};
  if (result.hausdorff_m == 0.0)
    std::snprintf(text.data(), text.size(), "%zu even spheres", result.balls.size());
  else
    std::snprintf(text.data(), text.size(), "%zu spheres within %.3g m of the mesh%s",
                  result.balls.size(), result.hausdorff_m,
                  result.is_reached() ? "" : ": the tolerance was not reached");
  std::string note = name + text.data();
  if (is_kept) return note + ", made before";
  std::snprintf(text.data(), text.size(), ", in %.2f s", time_s);
  return note + text.data();
}

}  // namespace

std::vector<spheres::Ball> made_or_kept(const spheres::SphereCache& cache,
                                        const BodyDescription& body,
                                        std::vector<std::string>& notes,
                                        const std::function<spheres::Decomposition()>& make) {
  constexpr double kWorthKeeping_s = 1.0;
  if (const auto kept = cache.read()) {
    notes.push_back(note_of(body, *kept, true, 0.0));
    return kept->balls;
  }
  const auto start = std::chrono::steady_clock::now();
  const spheres::Decomposition made = make();
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
  notes.push_back(note_of(body, made, false, time.count()));
  if (time.count() < kWorthKeeping_s) return made.balls;
  try {
    cache.write(made);
  } catch (const std::runtime_error& error) {
    notes.push_back(std::string("spheres are not kept for the next time: ") + error.what());
  }
  return made.balls;
}

}  // namespace stillgrid::bodies
