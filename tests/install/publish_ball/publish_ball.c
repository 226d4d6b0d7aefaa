/* A ball of 20 mm that stays where it is, published in virtual time: publish_ball SESSION */
#include <stdio.h>
#include <stillgrid/stillgrid.h>
#include <string.h>

static int fail(const char* call) {
  fprintf(stderr, "publish_ball: %s: %s\n", call, stillgrid_last_error());
  return 1;
}

int main(int argc, char** argv) {
  const stillgrid_material rubber = {500.0, 1.0, 0.3};
  const double radius_m = 0.02, position_m[3] = {0.0, 0.0, -0.03};
  stillgrid_scene scene;
  stillgrid_shapes shapes;
  stillgrid_publisher* publisher;
  uint64_t time_ns;
  int code;
  if (argc != 2) return 1;
  memset(&scene, 0, sizeof scene);
  scene.struct_size = sizeof scene;
  scene.clock = STILLGRID_VIRTUAL_TIME;
  scene.session = argv[1];
  scene.period_s = 0.02;
  scene.sphere_capacity = 1;
  scene.material_count = 1;
  scene.materials = &rubber;
  memset(&shapes, 0, sizeof shapes);
  shapes.struct_size = sizeof shapes;
  shapes.count = 1;
  shapes.radii_m = &radius_m;
  if (stillgrid_publisher_open(&scene, &publisher) < 0) return fail("open");
  if (stillgrid_publisher_set_shapes(publisher, &shapes) < 0) return fail("set_shapes");
  while ((code = stillgrid_publisher_wait(publisher, &time_ns)) != STILLGRID_NOTHING) {
    if (code < 0) return fail("wait");
    if (code == STILLGRID_AGAIN) continue;
    if (stillgrid_publisher_set_spheres(publisher, 1, position_m, NULL) < 0)
      return fail("set_spheres");
    if (stillgrid_publisher_publish(publisher, time_ns) < 0) return fail("publish");
  }
  stillgrid_publisher_close(publisher);
  return 0;
}
