/* What an open run file consists of. */
#ifndef EVENTMILL_RUN_FILE_INSIDE_H
#define EVENTMILL_RUN_FILE_INSIDE_H

#include "eventmill/run_file.h"
#include "record/h5.h"

struct em_run_file {
  char *path;
  hid_t file;
  char *text;
  struct em_scene *scene;
  struct em_run_state state;
  size_t balls, frames, bins, blocks;
  bool has_spin, has_rows;
  double *frame_time, *edges, *block_start, *block_end;
  uint64_t rows;
};

enum em_status em_run_file_damaged(const struct em_run_file *file, const char *what,
                                   struct em_error *err);
/* The run that balls of the scene start from, or NULL. */
const char *em_run_file_origin(const struct em_scene *scene);
/* Looks for the collision table; false: it is damaged. */
bool em_run_file_rows_find(struct em_run_file *file);

#endif
