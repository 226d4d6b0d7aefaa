#include "shared/tools/laboratory/methods/laboratory_methods.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "sim_server/scene/scene_file.hpp"

namespace stillgrid::laboratory::laboratory_methods_test {
namespace {

scene::Method method_of(const std::string& line, const scene::MethodTable& methods) {
  return scene::read_scene("format = 2\n[simulation]\n" + line + "\n", "scene.toml", methods)
      .method;
}

TEST_CASE("A scene names every method of the laboratory there, and in the product the product's",
          "[laboratory_methods]") {
  for (const scene::IntegratorKind& kind : laboratory_methods().integrators) {
    const std::string line = "integrator = '" + std::string(kind.name) + "'";
    CAPTURE(line);
    CHECK(method_of(line, laboratory_methods()) == scene::Method{.integrator = kind});
    if (std::ranges::count(scene::kIntegrators, kind) == 1)
      CHECK(method_of(line, scene::kMethods) == scene::Method{.integrator = kind});
    else
      CHECK_THROWS_AS(method_of(line, scene::kMethods), toml::SceneError);
  }
  for (const scene::SolverKind& kind : laboratory_methods().solvers) {
    const std::string line = "solver = '" + std::string(kind.name) + "'";
    CAPTURE(line);
    CHECK(method_of(line, laboratory_methods()) == scene::Method{.solver = kind});
    if (std::ranges::count(scene::kSolvers, kind) == 1)
      CHECK(method_of(line, scene::kMethods) == scene::Method{.solver = kind});
    else
      CHECK_THROWS_AS(method_of(line, scene::kMethods), toml::SceneError);
  }
}

TEST_CASE("The laboratory adds six methods, each of a name of its own", "[laboratory_methods]") {
  std::vector<std::string_view> names = scene::names_of(laboratory_methods().integrators);
  const std::vector<std::string_view> solvers = scene::names_of(laboratory_methods().solvers);
  names.insert(names.end(), solvers.begin(), solvers.end());
  CHECK(names.size() == scene::kIntegrators.size() + scene::kSolvers.size() + 6);
  std::ranges::sort(names);
  CHECK(std::ranges::adjacent_find(names) == names.end());
}

}  // namespace
}  // namespace stillgrid::laboratory::laboratory_methods_test
