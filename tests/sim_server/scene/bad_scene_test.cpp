#include <catch2/catch.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "sim_server/scene/scene_file.hpp"
#include "tests/sim_server/scene/temporary_scene.hpp"

namespace stillgrid::scene::bad_scene_test {

namespace {

/// A scene with one fault, and how its refusal begins and ends.
struct BadScene {
  std::string_view text;
  std::string_view where;  // line and column
  std::string_view key;
  std::string_view value;
  std::string_view expected;  // the beginning
};

void check_refusal(const BadScene& scene, const std::string& text) {
  INFO(text);
  const std::string line = refusal_of(text);
  CHECK(line.find('\n') == std::string::npos);
  std::string beginning(scene.where);
  beginning.append(": ").append(scene.key).append(": value ").append(scene.value);
  beginning.append(": expected ").append(scene.expected);
  CHECK(line.substr(0, beginning.size()) == beginning);
}

// Each text is the whole file.
constexpr BadScene kBadFiles[] = {
    {"", "1:1", "format", "missing", "2"},
    {"format = 1", "1:10", "format", "1", "2"},
    {"format = '1'", "1:10", "format", "'1'", "2, found a string"},
    {"format = 2\nformat = 2", "2:10", "syntax", "\"format = 2\"", "TOML: "},
    {"format = 2\nworld = {", "2:10", "syntax", "\"world = {\"", "TOML: "},
    {"format = 2\n[world\n", "2:7", "syntax", "\"[world\"", "TOML: "},
    {"format = 2\ncolour = 'red'", "2:1", "colour", "'red'", "no such key here, but body, "},
    {"format = 2\nworld = 3", "2:9", "world", "3", "a table, found an integer"},
    {"format = 2\n[world]\nwind = 3.5", "3:1", "world.wind", "3.5", "no such key here, but "},
    {"format = 2\n[world]\ngravity_m_s2 = -9.81", "3:16", "world.gravity_m_s2", "-9.81",
     "3 numbers, each a number from -1e12 to 1e12, found a number"},
    {"format = 2\n[world]\ngravity_m_s2 = [0.0, -9.81]", "3:16", "world.gravity_m_s2", "[0, -9.81]",
     "3 numbers"},
    {"format = 2\n[world]\ngravity_m_s2 = [0.0, 0.0, 'down']", "3:27", "world.gravity_m_s2",
     "'down'", "a number from -1e12 to 1e12, found a string"},
    {"format = 2\n[world]\ngravity_m_s2 = [0.0, 0.0, nan]", "3:27", "world.gravity_m_s2", "nan",
     "a number from"},
    {"format = 2\n[simulation]\nrate_hz = 0.0", "3:11", "simulation.rate_hz", "0",
     "a period from 1e-05 to 100 s, a rate from 0.01 to 100000 Hz"},
    {"format = 2\n[simulation]\nrate_hz = -33", "3:11", "simulation.rate_hz", "-33",
     "a period from 1e-05 to 100 s, a rate from 0.01 to 100000 Hz"},
    {"format = 2\n[simulation]\nrate_hz = 10\nperiod_s = 0.1", "4:12", "simulation.period_s", "0.1",
     "rate_hz or period_s, not both"},
    {"format = 2\n[simulation]\nrate_hz = \"auto\"", "3:11", "simulation.rate_hz", "'auto'",
     "a number: no rate is chosen; write 10 to 100, snapshots a second"},
    {"format = 2\n[simulation]\nrate_hz = \"fast\"", "3:11", "simulation.rate_hz", "'fast'",
     "a number: no rate is chosen"},
    {"format = 2\n[tool]\n[[hand]]\nname = \"a\"", "2:1", "tool", "{...}",
     "no such table beside [[hand]], each of which has its own"},
    {"format = 2\n[[hand]]\nname = \"a b\"", "3:8", "hand.name", "'a b'",
     "1 to 16 letters, digits, '_' or '-'"},
    {"format = 2\n[[hand]]\nname = \"a\"\n[[hand]]\nname = \"a\"", "5:8", "hand.name", "'a'",
     "a name that nothing else of its sort has"},
    {"format = 2\n[[hand]]\nfile = \"a.csv\"", "2:1", "hand.name", "missing", ""},
    {"format = 2\nhand = [{name=\"a\"},{name=\"b\"},{name=\"c\"},{name=\"d\"},{name=\"e\"}]",
     "2:59", "hand.name", "'e'", "at most 4 hands"},
    {"format = 2\n[simulation]\nintegrator = 'cvode_bdf'\nsubsteps = 3", "4:12",
     "simulation.substeps", "3", "no such key beside this integrator"},
    {"format = 2\n[hand]\nsettle_s = 1.0", "2:1", "hand.file", "missing", ""},
    {"format = 2\n[hand]\nfile = \"a.csv\"\nsettle_s = 601.0", "4:12", "hand.settle_s", "601",
     "at most 600 s"},
    {"format = 2\n[simulation]\nrate_hz = 1e10", "3:11", "simulation.rate_hz", "1e+10",
     "a period from 1e-05 to 100 s"},
    {"format = 2\n[simulation]\nperiod_s = 1000.0", "3:12", "simulation.period_s", "1000",
     "a period from 1e-05 to 100 s"},
    {"format = 2\n[simulation]\nperiod_s = -0.01", "3:12", "simulation.period_s", "-0.01",
     "a number from 1e-9"},
    {"format = 2\n[simulation]\nintegrator = 'leapfrog'", "3:14", "simulation.integrator",
     "'leapfrog'", "one of velocity_verlet, implicit_euler, cvode_bdf, auto"},
    {"format = 2\n[simulation]\nintegrator = 'bdf2'", "3:14", "simulation.integrator", "'bdf2'",
     "one of velocity_verlet, implicit_euler, cvode_bdf, auto"},
    {"format = 2\n[simulation]\nsolver = 'newton_cg'", "3:1", "simulation.solver", "'newton_cg'",
     "no such key here, but "},
    {"format = 2\n[simulation]\nsleeping = 1", "3:12", "simulation.sleeping", "1",
     "true or false, found"},
    {"format = 2\n[grid]\nvoxel_ratio = inf", "3:15", "grid.voxel_ratio", "inf", "a number from"},
    {"format = 2\n[tool]\nradius_m = 1e-3\nspheres = []", "4:11", "tool.spheres", "[]",
     "radius_m or spheres, not both"},
    {"format = 2\n[tool]\nspheres = []", "3:11", "tool.spheres", "[]", "1 to 16 spheres, found 0"},
    {"format = 2\n[tool]\nspheres = [{ position_m = [0, 0, 0] }]", "3:12", "tool.spheres.radius_m",
     "missing", "a number from 1e-9"},
    {"format = 2\n[tool]\nspheres = [{ radius_m = 1, mass_kg = 1 }]", "3:28",
     "tool.spheres.mass_kg", "1", "no such key here, but position_m, radius_m"},
    {"format = 2\n[device]\norientation_xyzw = [0, 0, 0, 0]", "3:20", "device.orientation_xyzw",
     "[0, 0, 0, 0]", "a quaternion x, y, z, w whose norm"},
    {"format = 2\n[device]\norientation_xyzw = [0.0, 0.0, 0.0, 1.002]", "3:20",
     "device.orientation_xyzw", "[0, 0, 0, 1.002]", "a quaternion"},
    {"format = 2\n[device]\nposition_m = [0, 2e6, 0]", "3:14", "device.position_m", "[0, 2e+06, 0]",
     "numbers from -1e6 to 1e6"},
    {"format = 2\n[device]\nscale = 1e7", "3:9", "device.scale", "1e+07", "at most 1e6"},
    {"format = 2\n[material]\nname = 'm'", "2:1", "material", "{...}",
     "an array of tables, found a table"},
    {"format = 2\n[[material]]\nname = 'm'", "2:1", "material.contact_stiffness_N_per_m", "missing",
     "a number from"},
    {"format = 2\n[[material]]\nname = 'm'\ncontact_stiffness_N_per_m = 0", "4:29",
     "material.contact_stiffness_N_per_m", "0", "a number from 1e-9"},
    {"format = 2\n[[material]]\nname = 'm'\ncontact_stiffness_N_per_m = 1\nfriction = -0.1", "5:12",
     "material.friction", "-0.1", "a number from 0 to 1e12"},
    {"format = 2\n[[material]]\nname = ''\ncontact_stiffness_N_per_m = 1", "3:8", "material.name",
     "''", "a name without comma"},
    {"format = 2\nmaterial = [{ name = 'm', contact_stiffness_N_per_m = 1 },\n"
     "{ name = 'm', contact_stiffness_N_per_m = 1 }]",
     "3:10", "material.name", "'m'", "a name that nothing else of its sort has"},
    {"format = 2\n[[body]]\nname = 'b'\nkind = 'plane'\nmaterial = 'm'", "5:12", "body.material",
     "'m'", "a [[material]] of the scene, which has none"},
};

// Each text stands from the third line on, after a format and a material "m", in a [[body]].
constexpr BadScene kBadBodies[] = {
    {"kind = 'sphere'", "3:1", "body.name", "missing", "a name"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nmass_kg = 1\nradius_m = 0x10", "8:12",
     "body.radius_m", "0x10", "a number from 1e-9 to 1e12, in decimal digits"},
    {"name = 'b'\nkind = 'thread'\nmaterial = 'm'\nmass_kg = 1\nnodes = 3\nfrom_m = [0, 0, 0]\n"
     "to_m = [0.1, 0, 0]\nspheres = { radius_m = 5.0 }",
     "11:24", "body.spheres.radius_m", "5", "at most the body's longest side"},
    {"name = 'a,b'", "4:8", "body.name", "'a,b'", "a name without comma"},
    {"name = 'b'", "3:1", "body.kind", "missing",
     "one of sheet, thread, soft_block, rigid_box, mesh, sphere, plane, compound"},
    {"name = 'b'\nkind = 'blob'", "5:8", "body.kind", "'blob'",
     "one of sheet, thread, soft_block, rigid_box, mesh, sphere, plane, compound"},
    {"name = 'b'\nkind = 'soft_block'\nmaterial = 'm'\nmass_kg = 1\nnodes = [8, 8]", "8:9",
     "body.nodes", "[8, 8]", "three integers, along x, along y and along z"},
    {"name = 'b'\nkind = 'soft_block'\nmaterial = 'm'\nmass_kg = 1\nnodes = [8, 8, 1]", "8:16",
     "body.nodes", "1", "an integer from 2 to 1000"},
    {"name = 'b'\nkind = 'soft_block'\nmaterial = 'm'\nmass_kg = 1\nnodes = [50, 50, 50]", "8:9",
     "body.nodes", "[50, 50, 50]", "at most 100000 nodes"},
    {"name = 'b'\nkind = 'soft_block'\nmaterial = 'm'\nmass_kg = 1\nnodes = [2, 2, 2]", "3:1",
     "body.size_m", "missing", "3 numbers"},
    {"name = 'b'\nkind = 'soft_block'\nmaterial = 'm'\nmass_kg = 1\nnodes = [2, 2, 2]\n"
     "size_m = [1, 1, 1]",
     "3:1", "body.spring_stiffness_N_per_m.structural", "missing", "a number from 1e-9"},
    {"name = 'b'\nkind = 'soft_block'\nmaterial = 'm'\nmass_kg = 1\nnodes = [2, 2, 2]\n"
     "size_m = [1, 1, 1]\nspring_stiffness_N_per_m = { structural = 1 }\npinned = 'corners'",
     "11:10", "body.pinned", "'corners'", "one of none"},
    {"name = 'b'\nkind = 'soft_block'\nmaterial = 'm'\nmass_kg = 1\nnodes = [2, 2, 2]\n"
     "size_m = [1, 1, 1]\nspring_stiffness_N_per_m = { structural = 1 }\npinned = [8]",
     "11:11", "body.pinned", "8", "an integer from 0 to 7"},
    {"name = 'b'\nkind = 'soft_block'\nmaterial = 'm'\nmotion = 'prescribed'", "7:10",
     "body.motion", "'prescribed'", "one of free, static"},
    {"name = 'b'\nkind = 'plane'\nmaterial = 'steel'", "6:12", "body.material", "'steel'",
     "one of m"},
    {"name = 'b'\nkind = 'plane'\nmaterial = 'm'\nmotion = 'free'", "7:10", "body.motion", "'free'",
     "one of static"},
    {"name = 'b'\nkind = 'plane'\nmaterial = 'm'", "3:1", "body.normal", "missing", "3 numbers"},
    {"name = 'b'\nkind = 'plane'\nmaterial = 'm'\nnormal = [0, 0, 0]", "7:10", "body.normal",
     "[0, 0, 0]", "a vector that is not zero"},
    {"name = 'b'\nkind = 'plane'\nmaterial = 'm'\nnormal = [0, 0, 1]\nmass_kg = 1", "8:1",
     "body.mass_kg", "1", "no such key here, but "},
    {"name = 'b'\nkind = 'plane'\nmaterial = 'm'\nnormal = [0, 0, 1]\nstiffness_scale = 1", "8:1",
     "body.stiffness_scale", "1", "no such key here, but "},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nradius_m = 0.1\nmass_kg = 1\n"
     "stiffness_scale = 1e-7",
     "9:19", "body.stiffness_scale", "1e-07", "a number from 1e-6 to 1e6"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nradius_m = 0.1\nmass_kg = 1\n"
     "stiffness_scale = 0.0",
     "9:19", "body.stiffness_scale", "0", "a number from 1e-6 to 1e6"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nradius_m = 0.1\nmass_kg = 1\n"
     "stiffness_scale = 2e6",
     "9:19", "body.stiffness_scale", "2e+06", "a number from 1e-6 to 1e6"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nradius_m = 0.1", "3:1", "body.mass_kg",
     "missing", "a number from 1e-9"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nmass_kg = -1.5", "7:11", "body.mass_kg", "-1.5",
     "a number from 1e-9"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nmotion = 'static'\nradius_m = 0.1\n"
     "velocity_m_s = [0, 0, 1]",
     "9:16", "body.velocity_m_s", "[0, 0, 1]",
     "no such key of a body whose motion is \"static\", but of one that is \"free\" or "
     "\"prescribed\" (body 'b')"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nmotion = 'static'\nradius_m = 0.1\n"
     "mass_kg = 0.5",
     "9:11", "body.mass_kg", "0.5",
     "no such key of a body whose motion is \"static\", but of one that is \"free\" (body 'b')"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nmotion = 'prescribed'\nradius_m = 0.1\n"
     "velocity_m_s = [0, 0, 1]\nmass_kg = 0.5",
     "10:11", "body.mass_kg", "0.5",
     "no such key of a body whose motion is \"prescribed\", but of one that is \"free\""},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nradius_m = 0.1\nmass_kg = 0.5\n"
     "direction = [0, 0, 1]",
     "9:13", "body.direction", "[0, 0, 1]",
     "no such key of a body whose motion is \"free\", but of one that is \"prescribed\""},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nmotion = 'static'\nradius_m = 0.1\n"
     "spheres = { radius_m = 0.1 }",
     "9:1", "body.spheres", "{...}", "no such key here, but "},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nmotion = 'prescribed'", "3:1",
     "body.velocity_m_s", "missing", "3 numbers, each a number from"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nmotion = 'prescribed'\n"
     "direction = [0, 3, 4]\nvelocity_m_s = 0.5",
     "9:16", "body.velocity_m_s", "0.5",
     "a vector, which without `direction` says the same: [0, 0.3, 0.4]"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nmotion = 'prescribed'\n"
     "direction = [0, 3, 4]\nvelocity_m_s = [0, 0, 1]",
     "8:13", "body.direction", "[0, 3, 4]",
     "no such key beside velocity_m_s, but of amplitude_m with frequency_hz"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nmotion = 'prescribed'\nvelocity_m_s = 1\n"
     "amplitude_m = 1\nfrequency_hz = 1",
     "8:16", "body.velocity_m_s", "1", "either velocity_m_s, or amplitude_m with frequency_hz"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nmotion = 'prescribed'\namplitude_m = 0.1", "3:1",
     "body.frequency_hz", "missing", "a number from 1e-9"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nmotion = 'prescribed'\nkeyframes = []", "8:13",
     "body.keyframes", "[]", "1 to 10000 of { time_s = 1.0, displacement_m = [0, 0, 0.01] }"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nmotion = 'prescribed'\n"
     "keyframes = [{ time_s = 1.5, displacement_m = [0, 0, 1] },\n"
     "  { time_s = 1.5, displacement_m = [0, 0, 0] }]",
     "9:14", "body.keyframes.time_s", "1.5", "at least 1e-6 s after the keyframe before, at 1.5 s"},
    {"name = 'b'\nkind = 'sphere'\nmaterial = 'm'\nmotion = 'prescribed'\n"
     "keyframes = [{ time_s = 1, displacement_m = [0, 0, 1] }]\nfrequency_hz = 2",
     "9:16", "body.frequency_hz", "2", "no such key beside keyframes"},
    {"name = 'b'\nkind = 'sheet'\nmaterial = 'm'\nmotion = 'prescribed'", "7:10", "body.motion",
     "'prescribed'", "one of free, static"},
    {"name = 'b'\nkind = 'rigid_box'\nmaterial = 'm'\nmass_kg = 1\nsize_m = [1, 0, 1]", "8:14",
     "body.size_m", "0", "a number from 1e-9"},
    {"name = 'b'\nkind = 'rigid_box'\nmaterial = 'm'\nmass_kg = 1\nsize_m = [1, 0.1, 1]\n"
     "spheres = { radius_m = 0.06 }",
     "9:24", "body.spheres.radius_m", "0.06", "at most half of the box's shortest side"},
    {"name = 'b'\nkind = 'rigid_box'\nmaterial = 'm'\nmass_kg = 1\nsize_m = [1, 1, 1]\n"
     "spheres = { spacing_m = 1e-5 }",
     "9:25", "body.spheres.spacing_m", "1e-05", "at least a thousandth"},
    {"name = 'b'\nkind = 'sheet'\nmaterial = 'm'\nmass_kg = 1\nnodes = [1, 8]", "8:10",
     "body.nodes", "1", "an integer from 2 to 1000"},
    {"name = 'b'\nkind = 'sheet'\nmaterial = 'm'\nmass_kg = 1\nnodes = [8, 8, 8]", "8:9",
     "body.nodes", "[8, 8, 8]", "two integers"},
    {"name = 'b'\nkind = 'thread'\nmaterial = 'm'\nmass_kg = 1\nnodes = 2.5", "8:9", "body.nodes",
     "2.5", "an integer from 2 to 1000, found a number"},
    {"name = 'b'\nkind = 'thread'\nmaterial = 'm'\nmass_kg = 1\nnodes = 3\n"
     "from_m = [1, 1, 1]\nto_m = [1, 1, 1]",
     "10:8", "body.to_m", "[1, 1, 1]", "another point than from_m"},
    {"name = 'b'\nkind = 'thread'\nmaterial = 'm'\nmass_kg = 1\nnodes = 3\n"
     "from_m = [0, 1, 1]\nto_m = [1, 1, 1]",
     "3:1", "body.spring_stiffness_N_per_m.structural", "missing", "a number from 1e-9"},
    {"name = 'b'\nkind = 'thread'\nmaterial = 'm'\nmass_kg = 1\nnodes = 3\n"
     "from_m = [0, 1, 1]\nto_m = [1, 1, 1]\nspring_stiffness_N_per_m = { structural = 1, shear = 1 "
     "}",
     "11:46", "body.spring_stiffness_N_per_m.shear", "1", "no such key here, but bend, structural"},
    {"name = 'b'\nkind = 'thread'\nmaterial = 'm'\nmass_kg = 1\nnodes = 3\n"
     "from_m = [0, 1, 1]\nto_m = [1, 1, 1]\nspring_stiffness_N_per_m = { structural = 1 }\n"
     "pinned = 'corners'",
     "12:10", "body.pinned", "'corners'", "one of none, start, end, both"},
    {"name = 'b'\nkind = 'thread'\nmaterial = 'm'\nmass_kg = 1\nnodes = 3\n"
     "from_m = [0, 1, 1]\nto_m = [1, 1, 1]\nspring_stiffness_N_per_m = { structural = 1 }\n"
     "pinned = [0, 3]",
     "12:14", "body.pinned", "3", "an integer from 0 to 2"},
    {"name = 'b'\nkind = 'plane'\nmaterial = 'm'\nnormal = [0, 0, 1]\n[[body]]\nname = 'b'\n"
     "kind = 'plane'\nmaterial = 'm'\nnormal = [0, 0, 1]",
     "9:8", "body.name", "'b'", "a name that nothing else of its sort has"},
};

}  // namespace

TEST_CASE("A fault outside of bodies is refused where it stands", "[scene_file]") {
  for (const BadScene& scene : kBadFiles) check_refusal(scene, std::string(scene.text));
}

TEST_CASE("A fault in a body is refused where it stands", "[scene_file]") {
  const std::string before =
      "format = 2\nmaterial = [{ name = 'm', contact_stiffness_N_per_m = 1 }]\n[[body]]\n";
  for (const BadScene& scene : kBadBodies) check_refusal(scene, before + std::string(scene.text));
}

TEST_CASE("More than 64 materials or 16 tool spheres are refused", "[scene_file]") {
  std::string materials = "format = 2\n";
  for (int i = 0; i < 64; ++i) {
    materials +=
        "[[material]]\nname = '" + std::to_string(i) + "'\ncontact_stiffness_N_per_m = 1\n";
  }
  CHECK(refusal_of(materials).empty());
  materials += "[[material]]\nname = 'more'\n";
  CHECK(refusal_of(materials) ==
        "195:8: material.name: value 'more': expected at most 64 materials (material 'more')");

  std::string spheres = "format = 2\ntool.spheres = [{ radius_m = 0.1 }";
  for (int i = 1; i < 16; ++i) spheres += ", { radius_m = 0.1 }";
  CHECK(refusal_of(spheres + "]").empty());
  const std::string refusal = refusal_of(spheres + ", { radius_m = 0.1 }]");
  CHECK(refusal.find("2:16: tool.spheres: value ") == 0);
  CHECK(refusal.find(": expected 1 to 16 spheres, found 17") != std::string::npos);
}

TEST_CASE("A file that cannot be read is refused by name", "[scene_file]") {
  CHECK_THROWS_WITH(load_scene("/nowhere/at all.toml"),
                    "/nowhere/at all.toml: cannot be read: No such file or directory");
  CHECK_THROWS_WITH(load_scene(std::filesystem::temp_directory_path()),
                    Catch::Contains("expected a regular file"));
}

TEST_CASE("A refusal is one line whatever the file holds", "[scene_file]") {
  const std::string refusal =
      refusal_of("format = 2\n\"a\\nkey\" = \"\"\"two\nlines and \\u001b more\"\"\"");
  CHECK(refusal.find('\n') == std::string::npos);
  CHECK(refusal.find('\x1b') == std::string::npos);
  CHECK(refusal.find("2:1: a key: value ") == 0);
}

TEST_CASE("What nests too deep for a parser is refused where it stands", "[scene_file]") {
  constexpr std::size_t kParts = 40'000;
  std::string key = "a";
  for (std::size_t i = 1; i < kParts; ++i) key += ".a";
  const std::string within(kParts, '['), behind(kParts, ']');
  std::string tables;
  for (std::size_t i = 0; i < kParts; ++i) tables += "{ a = ";
  const std::string_view expects_key = ": expected a key of at most 16 parts";
  const std::string_view expects_value = ": expected a value of at most 16 brackets";
  const std::pair<std::string, std::string_view> deep[] = {
      {key + " = 1", expects_key},
      {"[" + key + "]", expects_key},
      {"[[ a ." + key + "]]", expects_key},
      {"a = { " + key + " = 1 }", expects_key},
      {"a = { x = \"\"\"a\"\"\"\", " + key + " = 1 }", expects_key},
      {"'a'.\"b\"." + key + " = 1", expects_key},
      {"a = " + within + behind, expects_value},
      {"a = " + tables, expects_value}};
  for (const auto& [text, expected] : deep) {
    const std::string refusal = refusal_of("format = 2\n" + text);
    INFO(refusal);
    CHECK(refusal.find("2:") == 0);
    REQUIRE(refusal.size() > expected.size());
    CHECK(refusal.substr(refusal.size() - expected.size()) == expected);
  }
  // Dots and brackets within texts and comments are none, and numbers' dots are no keys'.
  std::string numbers;
  for (int i = 0; i < 100; ++i) numbers += "1.5, ";
  const std::string shallow = "format = 2 # " + key + within + "\nname = '" + within + "'";
  CHECK(refusal_of(shallow).find("2:1: name: value ") == 0);
  CHECK(refusal_of("format = 2\na = [" + numbers + "]").find("2:1: a: value ") == 0);
  CHECK(refusal_of("format = 2\na = \"\"\"" + within + "\\\"" + key + "\"\"\"").find("2:1: a: ") ==
        0);
}

}  // namespace stillgrid::scene::bad_scene_test
