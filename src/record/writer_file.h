/* The writer's inside: its datasets, made for a new file or found in an old one. */
#ifndef EVENTMILL_WRITER_FILE_H
#define EVENTMILL_WRITER_FILE_H

#include "record/log.h"
#include "record/table.h"
#include "record/twin.h"
#include "record/writer.h"

enum {
  EM_WRITER_OBSERVABLES = 32,
  EM_WRITER_FRAME_LOGS = 5,
  EM_WRITER_SAMPLE_LOGS = EM_WRITER_OBSERVABLES + 2
};

struct em_writer {
  char *path;
  struct em_twin *twin;
  hid_t file; /* -1: closed */
  const struct em_scene *scene;
  bool has_spin;
  struct em_log frame_step, frame_time, position, velocity, spin;
  struct em_log sample_step, sample_time;
  bool has_observable[EM_WRITER_OBSERVABLES];
  struct em_log observable[EM_WRITER_OBSERVABLES];
  uint64_t blocks;        /* complete ones in the file */
  uint64_t rows;          /* of the table, at the last flush */
  struct em_table *table; /* NULL: not asked for */
  size_t session;
};

/* Sets up the logs that the scene calls for. false: no memory. */
bool em_writer_file_logs(struct em_writer *writer);
void em_writer_file_free_logs(struct em_writer *writer);

/* Makes all groups and datasets. */
bool em_writer_file_create(struct em_writer *writer, const struct em_balls *balls,
                           const struct em_snapshot *snapshot);
/* Finds them, compares their lengths with those at the checkpoint, stores the scene's text anew. */
bool em_writer_file_resume(struct em_writer *writer);

/* Writes the run's state and the datasets' lengths. */
bool em_writer_file_state(struct em_writer *writer, const struct em_run_state *state);

#endif
