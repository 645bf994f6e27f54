/* mill check: validates a scene, and prints it in full with what it calls for. */
#include <stdio.h>
#include <stdlib.h>

#include "eventmill/start.h"
#include "eventmill/world.h"
#include "scene/scene_source.h"
#include "tool/mill.h"

static const int options_taken[] = {EM_MILL_JOINED, 0};

static const struct em_mill_help help = {
    .name = "check",
    .takes = options_taken,
    .text =
        "Usage: mill check SCENE [KEY=VALUE ...]\n\n"
        "Validates a scene, places its balls, and prints the scene with all defaults filled in.\n"
        "What it prints is itself a scene; comments tell the effects that it calls for, the\n"
        "variant of the event loop that will run it, the memory that a ball takes, and what\n"
        "follows from other entries, which can thus still be changed: what engine.accuracy sets,\n"
        "the remedy against jams, what a class of contacts has in common with all.\n\n"
        "      --joined  print the scene as it is written, but with its includes in place and\n"
        "                the names of files absolute, so that it can be moved; nothing is "
        "validated\n"
        "  -h, --help    this text\n\n"
        "Examples:\n"
        "  mill check geometries/simoloyer-2l.cfg\n"
        "  mill check geometries/simoloyer-2l.cfg rotor.rpm=1700 > fast.cfg\n",
};

static void print_effects(const struct em_scene *scene) {
  const unsigned effects = em_scene_effects(scene);
  printf("# effects:");
  for (int k = 0; k < EM_EFFECT_COUNT; k++)
    if (effects >> k & 1) printf(" %s", em_scene_effect_name((enum em_effect_bit)k));
  printf("%s\n", effects ? "" : " none");
}

/* Makes the balls and the world: what cannot be started is not valid. */
static enum em_status make_world(const struct em_scene *scene, struct em_world **world,
                                 struct em_error *err) {
  struct em_balls *balls = NULL;
  enum em_status status = em_recorder_start(&balls, scene, NULL, err);
  if (!status) status = em_world_new(world, scene, balls, err);
  em_start_free(balls);
  return status;
}

static int check(const struct em_scene *scene) {
  struct em_world *world = NULL;
  struct em_error err = {0};
  if (make_world(scene, &world, &err)) {
    em_mill_complain(&err);
    return err.code == EM_MEMORY ? EM_MILL_FAILED : EM_MILL_USAGE;
  }
  print_effects(scene);
  printf("# loop: %s\n", em_world_variant(world));
  printf("# balls: %zu, %.0f bytes each\n", em_scene_ball_count(scene),
         em_world_bytes_per_ball(world));
  printf("# events: %.0f of these bytes for those that a ball waits for; a collision is %s\n",
         em_world_bytes_of_events(world),
         scene->record.collisions ? "recorded with all its figures" : "counted, not stored");
  em_world_free(world);
  (void)em_scene_print(scene, stdout);
  return EM_MILL_DONE;
}

/* Prints the text of the scene. */
static int print_joined(const struct em_mill_options *options) {
  if (options->override_count > 0)
    return em_mill_usage(&help, "--joined goes without KEY=VALUE, found", options->overrides[0]);
  char *text = NULL;
  struct em_scene_source source = {0};
  struct em_error err = {0};
  enum em_status status = em_scene_source_load(&text, options->scene, &err);
  if (!status) status = em_scene_source_join_whole(&source, text, options->scene, &err);
  free(text);
  if (status) {
    em_mill_complain(&err);
    return status == EM_MEMORY ? EM_MILL_FAILED : EM_MILL_USAGE;
  }
  fputs(source.text, stdout);
  em_scene_source_free(&source);
  return EM_MILL_DONE;
}

int em_mill_check(int argc, char **argv) {
  struct em_mill_options options;
  struct em_scene *scene = NULL;
  int code = em_mill_options(&options, &help, argc, argv);
  if (code < 0 && options.joined) code = print_joined(&options);
  if (code < 0) code = em_mill_scene(&scene, &options);
  if (code < 0) code = check(scene);
  em_scene_free(scene);
  free(options.overrides);
  return code;
}
