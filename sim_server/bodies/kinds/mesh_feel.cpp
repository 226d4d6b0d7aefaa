#include "sim_server/bodies/kinds/mesh_feel.hpp"

#include <array>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>

#include "shared/realtime/stop_signal.hpp"
#include "sim_server/bodies/kinds/kept_spheres.hpp"
#include "sim_server/spheres/decomposition_error.hpp"
#include "sim_server/spheres/feel.hpp"
#include "sim_server/spheres/feel_search.hpp"

namespace stillgrid::bodies {
namespace {

constexpr const char* kFeel = "feel";

/// The spheres' search by feel as the scene asks for it.
struct AskedFeel {
  std::string text;
  double share = 0.0, tool_radius_m = 0.0, press_depth_m = 0.0;  // 0: by the mesh's size
};

AskedFeel read_feel(toml::TableReader& spheres, bool is_soft) {
  AskedFeel asked{.text = spheres.name(kFeel)};
  asked.tool_radius_m = spheres.number_or("tool_radius_m", toml::Bound::kPositive, 0.0);
  asked.press_depth_m = spheres.number_or("press_depth_m", toml::Bound::kPositive, 0.0);
  spheres.finish();
  const auto share = spheres::read_force_share(asked.text);
  if (!share) spheres.refuse(kFeel, spheres::kForceShareWords);
  if (is_soft) spheres.refuse(kFeel, "a body without springs: one that deforms has no such force");
  asked.share = *share;
  return asked;
}

}  // namespace

ScaledBalls read_felt_balls(toml::TableReader& spheres, bool is_soft,
                            const mesh::TriangleMesh& mesh, const BodyDescription& body,
                            std::vector<std::string>& notes) {
  constexpr double kPrecision = 0.05;  // of the error in metres, in the fineness
  const AskedFeel asked = read_feel(spheres, is_soft);
  try {
    const spheres::Press press =
        spheres::make_press(mesh, asked.tool_radius_m, asked.press_depth_m, 0.0);
    const spheres::SphereCache cache(
        spheres.folder(), mesh,
        "feel of " + std::to_string(press.tool_radius_m) + ' ' + std::to_string(press.depth_m),
        asked.share);
    ScaledBalls made{made_or_kept(cache, body, notes, [&] {
      const auto levels = spheres::search_by_feel(mesh, press, asked.share);
      const spheres::FeltLevel& best = spheres::best_of(levels, asked.share);
      spheres::Decomposition result =
          spheres::with_error(spheres::MeshSolid(mesh), best.balls, kPrecision * best.fineness_m);
      result.tolerance_m = result.hausdorff_m;  // none was asked for
      return result;
    })};
    const spheres::FeltError error =
        spheres::feel_of(made.balls, mesh::MeshDistance(mesh), press).error;
    made.stiffness_scale = error.stiffness_scale;
    std::array<char, 160> text{};
    std::snprintf(text.data(), text.size(),
                  "force on a tool of %.3g m within %.3g %% (%.3g JND) of the mesh's",
                  press.tool_radius_m, 100.0 * error.share, error.jnd());
    notes.push_back("body '" + body.name + "': " + text.data() +
                    (error.share <= asked.share ? "" : ": " + asked.text + " was not reached"));
    return made;
  } catch (const realtime::StopRequested&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    spheres.refuse(kFeel, std::string("one that spheres can have; ") + error.what());
  }
}

void note_feel(const std::vector<spheres::Ball>& balls, const mesh::TriangleMesh& mesh,
               double tolerance_m, const BodyDescription& body, std::vector<std::string>& notes) {
  try {
    const spheres::Press press = spheres::make_press(mesh, body.tool_radius_m, 0.0, tolerance_m);
    const spheres::Feel feel = spheres::feel_of(balls, mesh::MeshDistance(mesh), press);
    if (!spheres::is_worse_than_nearest_face(feel)) return;
    std::array<char, 60> tool{};
    std::snprintf(tool.data(), tool.size(), "a tool of %.3g m feels the spheres ",
                  press.tool_radius_m);
    notes.push_back("body '" + body.name + "': " + tool.data() + spheres::fault_of(feel) +
                    ", worse than the nearest face; feel = \"0.7jnd\" or surface_spacing_m comes "
                    "nearer");
  } catch (const std::runtime_error&) {
    // Such a tool fits nowhere on the mesh.
  }
}

}  // namespace stillgrid::bodies
