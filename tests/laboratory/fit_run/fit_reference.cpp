#include "tests/laboratory/fit_run/fit_reference.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <ostream>
#include <stdexcept>
#include <utility>

#include "shared/files/whole_file.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/published_scene.hpp"
#include "sim_server/scene/build_world.hpp"
#include "tests/laboratory/csv_file.hpp"

namespace stillgrid::fit_run {
namespace {

constexpr double kTick_s = 1e-3;
constexpr double kLongestRun_s = 600.0;
constexpr double kStateInterval_s = 0.25;
constexpr double kBeforePress_s = 1.0;
constexpr std::size_t kMaxPresses = 3, kPressesApart = 500, kPeakWindow = 100;  // ticks
constexpr double kLeastPress = 0.1;                                             // of the strongest
constexpr const char* kColumns =
    "time_s,x_m,y_m,z_m,rendered_fx_N,rendered_fy_N,rendered_fz_N,contacts";
constexpr const char* kStart = "start";
constexpr std::size_t kContacts = 7;
constexpr double kMax = 1e6;  // m, N or contacts: what no tool meets is somebody's slip

std::string press_name(std::size_t number) {
  return "press_" + std::to_string(number + 1);
}

laboratory::WorldState settled(const scene::SceneDescription& scene, double settle_s) {
  const scene::SceneDescription fine = reference_scene(scene, 1);
  dynamics::Simulation simulation(fine);
  const auto no_tool = []() -> std::optional<dynamics::ToolSample> { return std::nullopt; };
  const auto steps = std::lround(settle_s / fine.period_s);
  for (long i = 0; i < steps; ++i)
    (void)simulation.step(fine.period_s, no_tool, {.iterations = sim_server::kMaxIterations});
  return laboratory::state_of(simulation.world());
}

std::vector<recording::TickRow> read_rows(const laboratory::CsvFile& csv) {
  std::vector<recording::TickRow> rows;
  for (std::size_t i = 0; i < csv.rows(); ++i) {
    const auto vector = [&](std::size_t column) {
      const auto number = [&](std::size_t at) { return csv.number(i, at, {-kMax, kMax}); };
      return Eigen::Vector3d(number(column), number(column + 1), number(column + 2));
    };
    recording::TickRow row;
    row.time_s = csv.number(i, 0, {0.0, kLongestRun_s});
    if (!rows.empty() && !(row.time_s > rows.back().time_s))
      csv.refuse(i, csv.text(i, 0), "a time after that of the row before");
    row.position_m = vector(1);
    row.rendered_N = vector(4);
    const double contacts = csv.number(i, kContacts, {0.0, kMax});
    if (contacts != std::floor(contacts))
      csv.refuse(i, csv.text(i, kContacts), "a number of contacts");
    row.contacts = static_cast<int>(contacts);
    rows.push_back(row);
  }
  return rows;
}

bool is_peak(const std::vector<recording::TickRow>& rows, std::size_t tick) {
  const double force_N = rows[tick].rendered_N.norm();
  const std::size_t first = tick > kPeakWindow ? tick - kPeakWindow : 0;
  const std::size_t last = std::min(tick + kPeakWindow, rows.size() - 1);
  for (std::size_t i = first; i <= last; ++i)
    if (rows[i].rendered_N.norm() > force_N) return false;
  return true;
}

}  // namespace

laboratory::LabOptions path_options(const FitPath& path) {
  const std::string file = path.trajectory.string();
  if (file.find(',') != std::string::npos)
    throw std::runtime_error("--trajectory: value '" + file +
                             "': expected a name without a comma: it separates options");
  laboratory::LabOptions options;
  options.device = "replay:file=" + file + (path.replay.empty() ? "" : "," + path.replay);
  options.tick_rate_hz = 1.0 / kTick_s;
  options.duration_s = path.duration_s.value_or(kLongestRun_s);
  return options;
}

scene::SceneDescription reference_scene(const scene::SceneDescription& scene, int steps_per_tick) {
  scene::SceneDescription fine = scene;
  fine.method = {};
  fine.choose_method = false;
  fine.period_s = kTick_s / steps_per_tick;
  return fine;
}

FitReference make_reference(const scene::SceneDescription& scene, const FitPath& path,
                            int steps_per_tick, double settle_s, laboratory::LabRun& run) {
  FitReference reference;
  reference.settle_s = settle_s;
  reference.start = settled(scene, settle_s);
  laboratory::LabOptions options = path_options(path);
  options.transition = display::Transition::kHold;
  options.start = &reference.start;
  options.state_interval_s = kStateInterval_s;
  options.measures_ticks = true;
  run = laboratory::run_lab(reference_scene(scene, steps_per_tick), options);
  reference.rows = run.rows;
  for (const std::size_t tick : strongest_presses(run.rows)) {
    const double press_s = run.rows[tick].time_s;
    const double wanted_s = std::max(0.0, press_s - kBeforePress_s);
    const auto index =
        std::min(static_cast<std::size_t>(wanted_s / kStateInterval_s), run.states.size() - 1);
    const laboratory::WorldState& world = run.states[index];
    reference.presses.push_back({world.time_s - reference.start.time_s, press_s, world});
  }
  return reference;
}

std::vector<std::size_t> strongest_presses(const std::vector<recording::TickRow>& rows) {
  std::vector<std::size_t> order(rows.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return rows[a].rendered_N.squaredNorm() > rows[b].rendered_N.squaredNorm();
  });
  std::vector<std::size_t> presses;
  for (const std::size_t tick : order) {
    const double force_N = rows[tick].rendered_N.norm();
    if (presses.size() == kMaxPresses || !(force_N > 0.0)) break;
    if (!presses.empty() && force_N < kLeastPress * rows[presses.front()].rendered_N.norm()) break;
    const bool is_apart = std::all_of(presses.begin(), presses.end(), [&](std::size_t other) {
      return std::max(tick, other) - std::min(tick, other) >= kPressesApart;
    });
    if (is_apart && is_peak(rows, tick)) presses.push_back(tick);
  }
  return presses;
}

std::filesystem::path state_file_of(const std::filesystem::path& file) {
  return std::filesystem::path(file).replace_extension(".state.csv");
}

void write_reference(const std::filesystem::path& file, const scene::SceneDescription& scene,
                     const FitReference& reference) {
  std::vector<laboratory::NamedState> states = {{kStart, reference.start}};
  for (std::size_t i = 0; i < reference.presses.size(); ++i)
    states.push_back({press_name(i), reference.presses[i].world});
  laboratory::write_states(state_file_of(file), scene::build_world(scene), states);
  files::write_whole(file, [&](std::ostream& out) {
    out.precision(std::numeric_limits<double>::max_digits10);
    out << "# scene: " << scene.name << "\n# settle_s: " << reference.settle_s << '\n';
    for (std::size_t i = 0; i < reference.presses.size(); ++i)
      out << "# " << press_name(i) << "_begin_s: " << reference.presses[i].begin_s << "\n# "
          << press_name(i) << "_s: " << reference.presses[i].press_s << '\n';
    out << kColumns << '\n';
    for (const recording::TickRow& row : reference.rows) {
      out << row.time_s;
      for (const Eigen::Vector3d& v : {row.position_m, row.rendered_N})
        for (const double value : v) out << ',' << value;
      out << ',' << row.contacts << '\n';
    }
  });
}

FitReference read_reference(const std::filesystem::path& file,
                            const scene::SceneDescription& scene) {
  const laboratory::CsvFile csv(file, kColumns);
  FitReference reference;
  reference.settle_s = csv.head_number("settle_s", {0.0, kLongestRun_s});
  reference.rows = read_rows(csv);
  if (reference.rows.empty())
    throw std::runtime_error(file.string() + ": expected rows, a tick each");
  const bodies::World world = scene::build_world(scene);
  const std::vector<laboratory::NamedState> states =
      laboratory::read_states(state_file_of(file), world);
  const bool is_static = world.nodes.empty() && world.rigid_bodies.empty();
  const auto state_at = [&](const std::string& name, double time_s) {
    const auto found =
        std::find_if(states.begin(), states.end(),
                     [&](const laboratory::NamedState& state) { return state.name == name; });
    if (found != states.end()) return found->state;
    if (!is_static)
      throw std::runtime_error(state_file_of(file).string() + ": expected a world at moment '" +
                               name + "': it belongs to another reference");
    laboratory::WorldState state = laboratory::state_of(world);
    state.time_s = time_s;
    return state;
  };
  reference.start = state_at(kStart, reference.settle_s);
  for (std::size_t i = 0; csv.has_head(press_name(i) + "_s"); ++i) {
    ReferencePress& press = reference.presses.emplace_back();
    const double end_s = reference.rows.back().time_s;
    press.press_s = csv.head_number(press_name(i) + "_s", {reference.rows.front().time_s, end_s});
    press.begin_s = csv.head_number(press_name(i) + "_begin_s", {0.0, press.press_s});
    press.world = state_at(press_name(i), reference.settle_s + press.begin_s);
  }
  return reference;
}

}  // namespace stillgrid::fit_run
