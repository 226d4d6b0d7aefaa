#include <sstream>

#include "tests/performance/mujoco_system.hpp"
#include "tests/performance/pile.hpp"

namespace stillgrid::performance {
namespace {

/// Its data have room for all contacts times all contacts and velocities: 1,000 are refused.
constexpr std::size_t kMaxSpheres = 400;

std::string model_of(const Pile& pile) {
  std::ostringstream text;
  text << "<mujoco><option timestep='" << kPileStep_s << "' gravity='0 0 " << -kPileGravity_m_s2
       << "' solver='CG' jacobian='sparse' cone='elliptic'/><size nconmax='"
       << 4 * pile.spheres.size() << "' njmax='" << 12 * pile.spheres.size() << "' nstack='"
       << 20'000 * pile.spheres.size() << "'/><default><geom friction='" << pile.friction
       << " 0 0' condim='3'/></default>"
       << "<worldbody><geom type='plane' size='0 0 1'/>";
  if (!pile.bin_m.isZero())
    text << "<geom type='plane' size='0 0 1' zaxis='1 0 0'/>"
         << "<geom type='plane' size='0 0 1' zaxis='0 1 0'/>"
         << "<geom type='plane' size='0 0 1' zaxis='-1 0 0' pos='" << pile.bin_m.x()
         << " 0 0'/><geom type='plane' size='0 0 1' zaxis='0 -1 0' pos='0 " << pile.bin_m.y()
         << " 0'/>";
  for (const PileSphere& sphere : pile.spheres)
    text << "<body pos='" << sphere.position_m.transpose() << "'><freejoint/><geom size='"
         << sphere.radius_m << "' mass='" << sphere.mass_kg << "'/></body>";
  text << "</worldbody></mujoco>";
  return text.str();
}

class MujocoPile : public PileEngine {
 public:
  explicit MujocoPile(const Pile& pile) : system_(load_mujoco(model_of(pile))) {}

  void step() override { mj_step(system_.model.get(), system_.data.get()); }
  [[nodiscard]] int touching() const override { return system_.data->ncon; }
  [[nodiscard]] int sleeping() const override { return 0; }
  [[nodiscard]] double mean_height_m() const override {
    double sum_m = 0.0;
    for (int body = 1; body < system_.model->nbody; ++body)
      sum_m += system_.data->xpos[3 * body + 2];
    return sum_m / (system_.model->nbody - 1);
  }

 private:
  MujocoSystem system_;
};

}  // namespace

std::unique_ptr<PileEngine> mujoco_pile(const Pile& pile) {
  if (pile.spheres.size() > kMaxSpheres) return nullptr;
  return std::make_unique<MujocoPile>(pile);
}

}  // namespace stillgrid::performance
