#include "sim_server/surface_file.hpp"

#include <cstddef>
#include <nlohmann/json.hpp>
#include <ostream>

#include "shared/files/json_number.hpp"
#include "shared/files/whole_file.hpp"

namespace stillgrid::sim_server {
namespace {

using Json = nlohmann::ordered_json;

Json point_json(const bodies::SurfacePoint& point) {
  Json spheres = Json::array(), weights = Json::array();
  for (std::size_t i = 0; i < static_cast<std::size_t>(point.count); ++i) {
    spheres.push_back(point.spheres[i]);
    weights.push_back(files::json_number::number(static_cast<float>(point.weights[i])));
  }
  Json json{{"spheres", std::move(spheres)}, {"weights", std::move(weights)}};
  if (point.count > 0) return json;
  Json& still_m = json["still_m"] = Json::array();
  for (const double x_m : point.still_m)
    still_m.push_back(files::json_number::number(static_cast<float>(x_m)));
  return json;
}

Json surface_json(const bodies::BodySurface& surface) {
  Json json{{"body", surface.body}, {"vertices", Json::array()}};
  for (const bodies::SurfacePoint& point : surface.vertices)
    json["vertices"].push_back(point_json(point));
  const bool is_lines = surface.triangles.empty();
  Json& faces = json[is_lines ? "lines" : "triangles"] = Json::array();
  for (const Eigen::Vector3i& t : surface.triangles) faces.push_back({t.x(), t.y(), t.z()});
  for (const Eigen::Vector2i& line : surface.lines) faces.push_back({line.x(), line.y()});
  return json;
}

}  // namespace

void write_surfaces(const std::string& scene, const std::vector<std::string>& names,
                    std::size_t sphere_count, std::span<const bodies::BodySurface> surfaces,
                    const std::filesystem::path& file) {
  const auto text = [](const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
  };
  files::write_whole(file, [&](std::ostream& out) {
    out << "{\"scene\":" << text(scene) << ",\"spheres\":" << sphere_count
        << ",\"names\":" << text(names) << ",\"bodies\":[";
    const char* separator = "\n";
    for (const bodies::BodySurface& surface : surfaces) {
      out << separator << text(surface_json(surface));
      separator = ",\n";
    }
    out << "\n]}\n";
  });
}

}  // namespace stillgrid::sim_server
