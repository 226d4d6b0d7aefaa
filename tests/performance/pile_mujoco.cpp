#include <mujoco/mujoco.h>

#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

#include "tests/performance/pile.hpp"

namespace stillgrid::performance {
namespace {

/// Its data have room for all contacts times all contacts and velocities: 1,000 are refused.
constexpr std::size_t kMaxSpheres = 400;
constexpr const char* kFile = "pile.xml";

std::string model_of(const Pile& pile) {
  std::ostringstream text;
  text << "<mujoco><option timestep=\"" << kPileStep_s << "\" gravity=\"0 0 " << -kPileGravity_m_s2
       << "\" solver=\"CG\" jacobian=\"sparse\" cone=\"elliptic\"/><size nconmax=\""
       << 4 * pile.spheres.size() << "\" njmax=\"" << 12 * pile.spheres.size() << "\" nstack=\""
       << 20'000 * pile.spheres.size() << "\"/><default><geom friction=\"" << pile.friction
       << " 0 0\" condim=\"3\"/></default>"
       << "<worldbody><geom type=\"plane\" size=\"0 0 1\"/>";
  if (!pile.bin_m.isZero())
    text << "<geom type=\"plane\" size=\"0 0 1\" zaxis=\"1 0 0\"/>"
         << "<geom type=\"plane\" size=\"0 0 1\" zaxis=\"0 1 0\"/>"
         << "<geom type=\"plane\" size=\"0 0 1\" zaxis=\"-1 0 0\" pos=\"" << pile.bin_m.x()
         << " 0 0\"/><geom type=\"plane\" size=\"0 0 1\" zaxis=\"0 -1 0\" pos=\"0 "
         << pile.bin_m.y() << " 0\"/>";
  for (const PileSphere& sphere : pile.spheres)
    text << "<body pos=\"" << sphere.position_m.transpose() << "\"><freejoint/><geom size=\""
         << sphere.radius_m << "\" mass=\"" << sphere.mass_kg << "\"/></body>";
  text << "</worldbody></mujoco>";
  return text.str();
}

struct DeleteModel {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
struct DeleteData {
  void operator()(mjData* data) const { mj_deleteData(data); }
};

std::unique_ptr<mjModel, DeleteModel> load(const std::string& text) {
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), kFile, static_cast<int>(text.size()));
  text.copy(static_cast<char*>(files->filedata[0]), text.size());
  std::array<char, 1000> error{};
  std::unique_ptr<mjModel, DeleteModel> model(
      mj_loadXML(kFile, files.get(), error.data(), static_cast<int>(error.size())));
  mj_deleteVFS(files.get());
  if (!model) throw std::runtime_error(error.data());
  return model;
}

class MujocoPile : public PileEngine {
 public:
  explicit MujocoPile(const Pile& pile)
      : model_(load(model_of(pile))), data_(mj_makeData(model_.get())) {}

  void step() override { mj_step(model_.get(), data_.get()); }
  [[nodiscard]] int touching() const override { return data_->ncon; }
  [[nodiscard]] int sleeping() const override { return 0; }
  [[nodiscard]] double mean_height_m() const override {
    double sum_m = 0.0;
    for (int body = 1; body < model_->nbody; ++body) sum_m += data_->xpos[3 * body + 2];
    return sum_m / (model_->nbody - 1);
  }

 private:
  std::unique_ptr<mjModel, DeleteModel> model_;
  std::unique_ptr<mjData, DeleteData> data_;
};

}  // namespace

std::unique_ptr<PileEngine> mujoco_pile(const Pile& pile) {
  if (pile.spheres.size() > kMaxSpheres) return nullptr;
  return std::make_unique<MujocoPile>(pile);
}

}  // namespace stillgrid::performance
