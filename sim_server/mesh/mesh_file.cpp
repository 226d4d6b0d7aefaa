#include "sim_server/mesh/mesh_file.hpp"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <cmath>
#include <sstream>
#include <string>

namespace stillgrid {
namespace {

/// One line, whatever the library wrote.
std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

void append(TriangleMesh& mesh, const aiMesh& part, double scale) {
  const int first = static_cast<int>(mesh.vertices_m.size());
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    const aiVector3D& v = part.mVertices[i];
    mesh.vertices_m.push_back(scale * Eigen::Vector3d(v.x, v.y, v.z));
  }
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    if (face.mNumIndices != 3) continue;  // a point or a line bounds nothing
    Eigen::Vector3i triangle;
    for (unsigned k = 0; k < 3; ++k)
      triangle[static_cast<int>(k)] = first + static_cast<int>(face.mIndices[k]);
    mesh.triangles.push_back(triangle);
  }
}

bool has_polygons(const aiScene& scene) {
  for (unsigned i = 0; i < scene.mNumMeshes; ++i)
    if (scene.mMeshes[i]->mPrimitiveTypes & aiPrimitiveType_POLYGON) return true;
  return false;
}

/// The library aborts on a part whose faces are not of the kinds that it says it has.
void check_faces(const aiScene& scene, const std::string& name) {
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
    const aiMesh& part = *scene.mMeshes[i];
    unsigned triangles = 0, polygons = 0;
    for (unsigned k = 0; k < part.mNumFaces; ++k) {
      triangles += part.mFaces[k].mNumIndices == 3 ? 1U : 0U;
      polygons += part.mFaces[k].mNumIndices > 3 ? 1U : 0U;
    }
    const bool claims_polygons = (part.mPrimitiveTypes & aiPrimitiveType_POLYGON) != 0;
    if (triangles + polygons == 0 || (claims_polygons && polygons == 0))
      throw MeshError(name + ": part " + std::to_string(i + 1) + " of " +
                      std::to_string(scene.mNumMeshes) + ": " + std::to_string(triangles) +
                      " triangles among " + std::to_string(part.mNumFaces) +
                      " faces, some of no corner: expected a surface");
  }
}

void check_size(const TriangleMesh& mesh, const std::string& name) {
  Eigen::Vector3d low = mesh.vertices_m.front(), high = low;
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    const Eigen::Vector3d& vertex = mesh.vertices_m[i];
    if (!vertex.allFinite())
      throw MeshError(name + ": vertex " + std::to_string(i) +
                      ": is no number: expected finite coordinates");
    low = low.cwiseMin(vertex);
    high = high.cwiseMax(vertex);
  }
  constexpr double kLeast_m = 1e-6, kMost_m = 1e3;
  const double size_m = (high - low).maxCoeff();
  const double farthest_m = std::max(high.cwiseAbs().maxCoeff(), low.cwiseAbs().maxCoeff());
  std::ostringstream value;
  if (size_m < kLeast_m || size_m > kMost_m)
    value << ": longest side of the box: value " << size_m;
  else if (farthest_m > kMost_m)
    value << ": farthest coordinate: value " << farthest_m;
  else
    return;
  throw MeshError(name + value.str() + " m after scaling: expected 1e-6 to 1000 m; see the scale");
}

}  // namespace

TriangleMesh load_mesh(const std::filesystem::path& path, double scale) {
  const std::string name = path.string();
  if (!std::filesystem::exists(path)) throw MeshError(name + ": no such file");
  if (std::filesystem::is_directory(path))
    throw MeshError(name + ": is a folder: expected a mesh (OBJ, OFF, STL or PLY)");
  Assimp::Importer importer;
  // Of a face only its place matters: with normals and colours corners would not join.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                              aiComponent_NORMALS | aiComponent_TEXCOORDS | aiComponent_COLORS |
                                  aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_MATERIALS);
  const auto cannot_be_read = [&] {
    return MeshError(name + ": cannot be read: " + one_line(importer.GetErrorString()) +
                     ": expected a mesh (OBJ, OFF, STL or PLY)");
  };
  const aiScene* scene = importer.ReadFile(name, aiProcess_RemoveComponent);
  if (scene == nullptr) throw cannot_be_read();
  check_faces(*scene, name);
  const unsigned steps = aiProcess_JoinIdenticalVertices | aiProcess_PreTransformVertices;
  scene = importer.ApplyPostProcessing(steps | (has_polygons(*scene) ? aiProcess_Triangulate : 0U));
  if (scene == nullptr) throw cannot_be_read();
  TriangleMesh mesh;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) append(mesh, *scene->mMeshes[i], scale);
  if (mesh.triangles.empty())
    throw MeshError(name + ": 0 triangles of " + std::to_string(mesh.vertices_m.size()) +
                    " vertices: expected a surface");
  check_size(mesh, name);
  return mesh;
}

}  // namespace stillgrid
