/* Reading a run file (layout: docs/run-file.md). Every size is checked against the file before
 * memory is taken; a truncated, damaged or foreign file gives EM_FILE or EM_FORMAT, never a crash.
 */
#ifndef EVENTMILL_RUN_FILE_H
#define EVENTMILL_RUN_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "eventmill/error.h"
#include "eventmill/scene.h"
#include "eventmill/start.h"

#ifdef __cplusplus
extern "C" {
#endif

struct em_run_file;
struct em_snapshot;

/* Why a run ended. A file that was left by a kill says `running`. */
#define EM_END_LIST(X)          \
  X(RUNNING, "running")         \
  X(DONE, "done")               \
  X(INTERRUPTED, "interrupted") \
  X(COLLAPSE, "collapse")       \
  X(JAM, "jam")                 \
  X(FAILED, "failed")
#define EM_END_ENUM(code, text) EM_END_##code,
enum em_end { EM_END_LIST(EM_END_ENUM) EM_END_COUNT };
#undef EM_END_ENUM

/* Where the run stands. */
struct em_run_state {
  enum em_end end;
  char message[1024];     /* what went wrong; of DONE: a warning, or empty */
  double time;            /* s, simulated */
  uint64_t collisions;    /* since the start */
  double energy_start;    /* J: kinetic, spin and potential energy at time 0 */
  double kinetic_start;   /* J: kinetic and spin energy at time 0 */
  double potential_start; /* J */
};

/* One process that worked on the run; a resumed run has several. Times as ISO 8601, UTC. */
struct em_run_session {
  char version[128], compiler[256], flags[512], libraries[512];
  char host[256], command[4096], started[32], ended[32];
  double wall_time, cpu_time; /* s */
  double from, to;            /* s, simulated */
};

/* A named observable against time, as doubles; value[i * width + j]. */
struct em_series {
  size_t count, width;
  double *time; /* s */
  double *value;
  char unit[32];
};

/* Opens a file and reads its scene, state and sizes. Errors: EM_FILE (cannot be read), EM_FORMAT
 * (no run file, or damaged), EM_MEMORY. */
enum em_status em_run_file_open(struct em_run_file **file, const char *path, struct em_error *err);
void em_run_file_close(struct em_run_file *file);

const char *em_run_file_path(const struct em_run_file *file);
/* The scene, parsed from the stored text; owned by the file. */
const struct em_scene *em_run_file_scene(const struct em_run_file *file);
const char *em_run_file_scene_text(const struct em_run_file *file);
const struct em_run_state *em_run_file_state(const struct em_run_file *file);
/* Session k < count. Errors: EM_FORMAT (damaged). */
size_t em_run_file_session_count(const struct em_run_file *file);
enum em_status em_run_file_session(const struct em_run_file *file, size_t k,
                                   struct em_run_session *session, struct em_error *err);
const char *em_run_file_end_name(enum em_end end);

/* Frames. Times are rising. `before`: index of the last frame at or before `time`, the first one
 * when there is none; count must not be 0. */
size_t em_run_file_ball_count(const struct em_run_file *file);
size_t em_run_file_frame_count(const struct em_run_file *file);
double em_run_file_frame_time(const struct em_run_file *file, size_t k); /* s */
size_t em_run_file_frame_before(const struct em_run_file *file, double time);

/* Balls with mass, radius and species filled in, for em_run_file_frame; em_start_free. Errors:
 * EM_MEMORY, EM_FORMAT (damaged). */
enum em_status em_run_file_balls(const struct em_run_file *file, struct em_balls **balls,
                                 struct em_error *err);
/* Positions, velocities and spins (0 when the scene has none) of frame k. Errors: EM_INPUT (no such
 * frame, or another number of balls), EM_FORMAT (damaged). */
enum em_status em_run_file_frame(const struct em_run_file *file, size_t k, struct em_balls *balls,
                                 struct em_error *err);
/* The last frame of the file at `path`: what species with start = "run" begin from; em_start_free.
 * Errors: those of em_run_file_open, _balls and _frame, EM_INPUT (no frames). */
enum em_status em_run_file_last(const char *path, struct em_balls **balls, struct em_error *err);
/* Turns the blades of a scene whose balls start from a run to where they stood at that run's last
 * frame, when it had as many blades; other scenes stay as they are. em_recorder_run does so by
 * itself. Errors: those of em_run_file_open. */
enum em_status em_run_file_turn(struct em_scene *scene, struct em_error *err);

/* Observables: names as in docs/run-file.md ("kinetic_energy", "collisions", ...). A series is to
 * be freed. Errors: EM_INPUT (no such observable), EM_MEMORY, EM_FORMAT (damaged). */
bool em_run_file_has(const struct em_run_file *file, const char *name);
enum em_status em_run_file_series(const struct em_run_file *file, const char *name,
                                  struct em_series **series, struct em_error *err);
void em_run_file_series_free(struct em_series *series);

/* Online histograms of v_n: blocks of time that follow one another without a gap. edges has
 * bins + 1 entries (m/s); counts is [EM_CLASS_COUNT * bins], class after class. Errors: EM_INPUT
 * (no such block), EM_FORMAT (damaged). */
size_t em_run_file_bins(const struct em_run_file *file);
const double *em_run_file_edges(const struct em_run_file *file);
size_t em_run_file_block_count(const struct em_run_file *file);
double em_run_file_block_start(const struct em_run_file *file, size_t k); /* s */
double em_run_file_block_end(const struct em_run_file *file, size_t k);   /* s */
enum em_status em_run_file_block(const struct em_run_file *file, size_t k, uint64_t *counts,
                                 struct em_error *err);

/* The collision table, streamed: columns that are not asked for stay NULL. */
enum em_column {
  EM_COLUMN_TIME = 1,    /* s */
  EM_COLUMN_CLASS = 2,   /* enum em_class */
  EM_COLUMN_BALL = 4,    /* index */
  EM_COLUMN_PARTNER = 8, /* other ball, blade or wall number, as in struct em_contact */
  EM_COLUMN_PLACE = 16,  /* m */
  EM_COLUMN_NORMAL = 32, /* unit vector from the partner to the ball */
  EM_COLUMN_VN = 64,     /* m/s */
  EM_COLUMN_VT = 128,    /* m/s */
  EM_COLUMN_LOST = 256,  /* J */
  EM_COLUMN_ALL = 511
};
enum { EM_ROWS_BLOCK = 65536 };
struct em_rows {
  size_t count; /* rows that are filled, ≤ EM_ROWS_BLOCK */
  double *time;
  uint8_t *cls;
  uint32_t *ball, *partner;
  float (*place)[3], (*normal)[3];
  float *vn, *vt, *lost;
};

/* Room for EM_ROWS_BLOCK rows of the columns asked for; NULL when memory is short. */
struct em_rows *em_run_file_rows_new(unsigned columns);
void em_run_file_rows_free(struct em_rows *rows);

bool em_run_file_has_rows(const struct em_run_file *file);
uint64_t em_run_file_row_count(const struct em_run_file *file);
/* Reads the rows from `first` on, at most EM_ROWS_BLOCK; rows->count is 0 at the end. Errors:
 * EM_FORMAT (damaged). */
enum em_status em_run_file_rows(const struct em_run_file *file, uint64_t first,
                                struct em_rows *rows, struct em_error *err);

/* The engine's state at the last flush; em_world_snapshot_free. Errors: EM_MEMORY, EM_FORMAT
 * (damaged). */
enum em_status em_run_file_checkpoint(const struct em_run_file *file, struct em_snapshot **snapshot,
                                      struct em_error *err);

#ifdef __cplusplus
}
#endif

#endif
