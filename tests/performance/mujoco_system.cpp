#include "tests/performance/mujoco_system.hpp"

#include <array>
#include <stdexcept>

namespace stillgrid::performance {

MujocoSystem load_mujoco(const std::string& text, const std::string& included) {
  constexpr const char* kFile = "model.xml";
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), kFile, static_cast<int>(text.size()));
  text.copy(static_cast<char*>(files->filedata[0]), text.size());
  if (!included.empty()) {
    mj_makeEmptyFileVFS(files.get(), "included.xml", static_cast<int>(included.size()));
    included.copy(static_cast<char*>(files->filedata[1]), included.size());
  }
  std::array<char, 1000> error{};
  MujocoSystem system{{mj_loadXML(kFile, files.get(), error.data(), static_cast<int>(error.size())),
                       mj_deleteModel},
                      {nullptr, mj_deleteData}};
  mj_deleteVFS(files.get());
  if (!system.model) throw std::runtime_error(error.data());
  system.data.reset(mj_makeData(system.model.get()));
  return system;
}

}  // namespace stillgrid::performance
