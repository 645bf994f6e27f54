/* The state in which a run begins. */
#include "record/recorder_start.h"

#include <stdlib.h>

#include "record/run_file_inside.h"

enum em_status em_recorder_start(struct em_balls **start, const struct em_scene *scene,
                                 const volatile sig_atomic_t *stop, struct em_error *err) {
  struct em_balls *previous = NULL;
  const char *origin = em_run_file_origin(scene);
  enum em_status status = origin ? em_run_file_last(origin, &previous, err) : EM_OK;
  if (!status) status = em_start_make(start, scene, previous, stop, err);
  em_start_free(previous);
  return status;
}

enum em_status em_recorder_start_scene(struct em_scene **copy, const struct em_scene *scene,
                                       struct em_error *err) {
  *copy = NULL;
  if (!em_run_file_origin(scene)) return EM_OK;
  char *text = em_scene_text(scene);
  enum em_status status =
      text ? em_scene_parse(copy, text, scene->file, 0, NULL, err)
           : em_error_set(err, EM_MEMORY, scene->file, 0, "no memory for a copy of the scene");
  free(text);
  return status ? status : em_run_file_turn(*copy, err);
}
