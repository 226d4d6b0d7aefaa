// Laws of cost: deadlines, memory and loading. By processor time: a stall of the machine is no
// cost.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "shared/realtime/processor_time.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/laws/law.hpp"
#include "tests/laws/moved_scene.hpp"

namespace stillgrid::laws {
namespace {

/// What a process of its own came to that loaded a scene and took a step.
struct Usage {
  bool ended = false;
  double processor_s = 0.0, most_bytes = 0.0;
};

Usage usage_of(const std::string& text) {
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("fork: no process for a measurement");
  if (child == 0) {
    try {
      dynamics::Simulation simulation(scene::read_scene(text, scene_folder() / "case.toml"));
      (void)simulation.step(1e-3, [] { return std::nullopt; });
    } catch (const std::exception&) {
      ::_exit(1);
    }
    ::_exit(0);
  }
  int status = 0;
  rusage usage{};
  if (::wait4(child, &status, 0, &usage) != child) throw std::runtime_error("wait4: no child");
  return {.ended = WIFEXITED(status) && WEXITSTATUS(status) == 0,
          .processor_s = static_cast<double>(usage.ru_utime.tv_sec) +
                         1e-6 * static_cast<double>(usage.ru_utime.tv_usec),
          .most_bytes = 1024.0 * static_cast<double>(usage.ru_maxrss)};
}

/// The scene with its last body so many times over, in rows of 100, a diameter of 20 mm apart.
std::string repeated(const LawCase& law_case, int count) {
  SceneText scene = law_case.scene;
  const SceneSection last = scene.sections.back();
  scene.sections.pop_back();
  for (int i = 0; i < count; ++i) {
    SceneSection body = last;
    std::erase_if(body.lines, [](const std::string& line) {
      return line.starts_with("name") || line.starts_with("position_m");
    });
    body.text("name", "n" + std::to_string(i));
    body.vector("position_m",
                {0.05 * (i % 100), 0.05 * (i / 100 % 100), 0.02 + 0.05 * (i / 10000)});
    scene.sections.push_back(std::move(body));
  }
  return scene.print();
}

/// A box of so many spheres in all, which moves.
std::string filled(const LawCase& law_case, int count) {
  SceneText scene = law_case.scene;
  SceneSection& box = scene.sections.back();
  std::erase_if(box.lines, [](const std::string& line) { return line.starts_with("spheres"); });
  constexpr double kSide_m = 0.1;  // of the box that special_draws draws
  const double spacing_m = kSide_m / std::cbrt(count);
  box.set("spheres", "{ spacing_m = " + short_number(spacing_m) +
                         ", radius_m = " + short_number(0.5 * spacing_m) + " }");
  return scene.print();
}

std::string of_size(const LawCase& law_case, int count) {
  return law_case.variant == "spheres" ? filled(law_case, count) : repeated(law_case, count);
}

}  // namespace

Finding keeps_its_deadline(const LawCase& law_case) {
  const scene::SceneDescription scene =
      scene::read_scene(repeated(law_case, law_case.repeat), scene_folder() / "case.toml");
  dynamics::Simulation simulation(scene);
  const double step_s = scene.period_s;
  double least = std::numeric_limits<double>::infinity();
  constexpr int kTries = 6;  // the first has what is built once
  for (int i = 0; i < kTries; ++i) {
    const double began_s = realtime::thread_processor_s();
    dynamics::Budget budget;
    budget.end_within(realtime::to_ns(step_s));
    (void)simulation.step(
        step_s, [] { return std::nullopt; }, budget);
    if (i > 0) least = std::min(least, (realtime::thread_processor_s() - began_s) / step_s);
  }
  return {.measured = least,
          .allowed = 1.1,
          .what = "periods of processor time that a step of " +
                  std::to_string(simulation.world().spheres.size()) +
                  " spheres takes, the least of " + std::to_string(kTries - 1)};
}

Finding costs_are_linear(const LawCase& law_case) {
  const int count = law_case.repeat;
  const Usage none = usage_of(of_size(law_case, 1));
  const Usage one = usage_of(of_size(law_case, count));
  const Usage four = usage_of(of_size(law_case, 4 * count));
  if (!one.ended || !four.ended)
    return {.measured = std::numeric_limits<double>::infinity(), .what = "the scene was refused"};
  constexpr double kMegabyte = 1e6;
  const double bytes = (four.most_bytes - none.most_bytes + kMegabyte) /
                       (one.most_bytes - none.most_bytes + kMegabyte);
  const double load =
      (four.processor_s - none.processor_s + 5e-3) / (one.processor_s - none.processor_s + 5e-3);
  // Four times as many; logarithms and caches have their share.
  const bool is_load = load > bytes;
  return {.measured = is_load ? load : bytes,
          .allowed = 7.0,
          .what = std::string("times as much ") + (is_load ? "processor time" : "memory") +
                  " for four times " + std::to_string(count) + " " + law_case.variant};
}

}  // namespace stillgrid::laws
