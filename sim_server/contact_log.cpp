#include "sim_server/contact_log.hpp"

#include <stdexcept>

namespace stillgrid::sim_server {

ContactLog::ContactLog(const std::filesystem::path& file, const std::vector<std::string>& hands)
    : file_(file), hands_(hands), out_(file) {
  if (!out_) throw std::runtime_error(file.string() + ": expected a file that can be written");
  out_.precision(9);
  out_ << "time_s,body_a,body_b,contacts,fx_N,fy_N,fz_N,tx_N_m,ty_N_m,tz_N_m,x_m,y_m,z_m\n";
}

void ContactLog::add(const dynamics::Simulation& simulation) {
  const bodies::World& world = simulation.world();
  const auto name_of = [&](int body) {
    const auto k = static_cast<std::size_t>(body);
    if (k < world.bodies.size()) return world.bodies[k].name;
    const std::string& hand = hands_[k - world.bodies.size()];
    return hand.empty() ? std::string("(tool)") : "(tool of " + hand + ")";
  };
  simulation.list_contact_forces(forces_);
  for (const dynamics::ContactForce& pair : forces_) {
    out_ << world.time_s << ',' << name_of(pair.body_a) << ',' << name_of(pair.body_b) << ','
         << pair.contacts;
    for (const auto* vector : {&pair.force_N, &pair.torque_N_m, &pair.centre_m})
      out_ << ',' << vector->x() << ',' << vector->y() << ',' << vector->z();
    out_ << '\n';
  }
}

void ContactLog::finish() {
  out_.close();
  if (!out_) throw std::runtime_error(file_.string() + ": could not be written to its end");
}

}  // namespace stillgrid::sim_server
