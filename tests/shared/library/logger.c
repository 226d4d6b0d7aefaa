/* logger SESSION LINES: what is published and felt, ten lines a second. */
#include <stdio.h>
#include <stdlib.h>
#include <stillgrid/stillgrid.h>
#include <time.h>

int main(int argc, char** argv) {
  const struct timespec pause = {0, 100000000};
  stillgrid_reader* reader = NULL;
  if (argc != 3 || stillgrid_reader_open(argv[1], NULL, &reader) != STILLGRID_OK) {
    fprintf(stderr, "logger: %s\n", argc == 3 ? stillgrid_last_error() : "expected SESSION LINES");
    return 1;
  }
  for (int line = 0; line < atoi(argv[2]); ++line) {
    stillgrid_session_state state = {.struct_size = sizeof state};
    stillgrid_snapshot snapshot = {.struct_size = sizeof snapshot}; /* no array: counts alone */
    stillgrid_tool tool = {.struct_size = sizeof tool};
    if (stillgrid_reader_poll(reader, &state) < 0) fprintf(stderr, "%s\n", stillgrid_last_error());
    if (stillgrid_reader_snapshot(reader, &snapshot) == STILLGRID_OK)
      printf("%s: snapshot %llu of %u spheres", state.scene_name,
             (unsigned long long)snapshot.snapshot_id, snapshot.count);
    else
      printf("nothing is published");
    if (stillgrid_reader_tool(reader, &tool) == STILLGRID_OK)
      printf("; %.3f %.3f %.3f N", tool.force_N[0], tool.force_N[1], tool.force_N[2]);
    printf("\n");
    nanosleep(&pause, NULL);
  }
  stillgrid_reader_close(reader);
  return 0;
}
