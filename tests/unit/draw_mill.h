/* What tests of the drawing share: a small mill with its start, and a folder for files. */
#ifndef EVENTMILL_TEST_DRAW_MILL_H
#define EVENTMILL_TEST_DRAW_MILL_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "eventmill/picture.h"
#include "eventmill/scene.h"
#include "eventmill/start.h"

#define DRAW_MILL                                                                      \
  "title = \"small mill\"; duration = 0.06; seed = 3; gravity = [0.0, 0.0, -9.81];\n"  \
  "chamber = { shape = \"drum\"; diameter = 0.06; length = 0.05; };\n"                 \
  "rotor = { rpm = 2000.0; radius = 0.003; reach = 0.02; blades = ( { y = 0.017; },\n" \
  "  { y = 0.034; angle_deg = 90.0; tip = \"hemisphere\"; } ); };\n"                   \
  "balls = { count = 150; diameter = 0.004; density = 7850.0; speed = 2.0; };\n"       \
  "record = { frames = 100.0; collisions = true; };\n"

static inline struct em_scene *draw_scene(const char *text, size_t count,
                                          const char *const *overrides) {
  struct em_scene *scene = NULL;
  struct em_error err = {0};
  if (em_scene_parse(&scene, text, "test.cfg", count, overrides, &err)) {
    fprintf(stderr, "%s\n", err.text);
    abort();
  }
  return scene;
}

static inline struct em_balls *draw_start(const struct em_scene *scene) {
  struct em_balls *balls = NULL;
  struct em_error err = {0};
  if (em_start_make(&balls, scene, NULL, NULL, &err)) {
    fprintf(stderr, "%s\n", err.text);
    abort();
  }
  return balls;
}

/* A path in a folder of this process; four hold at a time. */
static inline const char *draw_path(const char *name) {
  static char folder[64], path[4][256];
  static int next;
  if (folder[0] == '\0') {
    snprintf(folder, sizeof folder, "/tmp/em-draw-XXXXXX");
    if (mkdtemp(folder) == NULL) abort();
  }
  char *p = path[next++ % 4];
  snprintf(p, sizeof path[0], "%s/%s", folder, name);
  return p;
}

static inline void draw_clean(void) {
  char command[128];
  snprintf(command, sizeof command, "rm -rf '%s'", draw_path(""));
  if (system(command) != 0) fprintf(stderr, "left: %s\n", draw_path(""));
}

#endif
