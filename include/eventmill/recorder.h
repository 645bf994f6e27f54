/* Runs a scene from its start, or from a checkpoint, to its end, and records it in a run file. */
#ifndef EVENTMILL_RECORDER_H
#define EVENTMILL_RECORDER_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>

#include "eventmill/contact.h"
#include "eventmill/error.h"
#include "eventmill/precision.h"
#include "eventmill/run_file.h"
#include "eventmill/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

struct em_observer;

/* What is known while a run goes on. */
struct em_recorder_progress {
  double time, from, duration;   /* s, simulated: now, begin of this session, end */
  double wall;                   /* s since this session began */
  uint64_t collisions, at_begin; /* since the start; at the begin of this session */
};

struct em_recorder_options {
  const char *path;                  /* the run file; NULL: none is written */
  bool resume;                       /* go on from the checkpoint in `path`, if that file exists */
  bool force;                        /* replace an existing file */
  const char *command;               /* command line, for the provenance; may be NULL */
  const volatile sig_atomic_t *stop; /* non-zero: end with a checkpoint. May be NULL */
  void (*progress)(void *self, const struct em_recorder_progress *progress); /* may be NULL */
  void *self;
  const struct em_observer *observer; /* is told of all contacts of this session; may be NULL */
  /* Ends before the duration is over when all of these are reached, at the end of a block of the
   * histogram (em_precision_is_due), over the steady part. What was known at the end goes to
   * `found`. Rates of record.histograms above 0 are needed, and for the median speed and the power
   * no lower ones of record.observables. */
  size_t target_count;
  const struct em_precision_target *target;
  struct em_precision_found *found; /* target_count; may be NULL */
};

/* The key figures. Those of the steady part are taken from t ≥ 0.2 s, or from half the duration
 * when that is shorter: speeds and power from observables, v_n from the blocks of the histogram
 * that lie in it (all, when none does). NAN where there is nothing to tell. */
struct em_summary {
  bool begun; /* false: it came to no start, and all else is 0 */
  enum em_end end;
  bool resumed;
  uint64_t collisions;
  uint64_t by_class[EM_CLASS_COUNT];
  double collisions_per_second; /* of wall time, this session */
  double simulated_time;        /* s, since the start */
  double wall_time;             /* s, this session */
  double realtime_factor;       /* simulated / wall time, this session */
  double steady;                /* s: begin of the steady part */
  double median_speed;          /* m/s: mean over time of the median */
  double median_vn;             /* m/s */
  double rate_above_3;          /* 1/s: contacts with v_n > 3 m/s per simulated time */
  double share_above_3;         /* their share */
  double power;                 /* W: work of all blades and of the turning drum per time */
  double energy_error; /* |E(0) + work − dissipated − E| over the largest of: kinetic energy
                          (with spin) at the start and now, work, dissipated energy, change
                          of potential energy. NAN when gravity acts across a periodic
                          boundary */
  uint64_t tc, elastic, jam; /* contacts on which a remedy acted */
  char warning[300];         /* that many balls of a driven scene rest; or empty. A run that is done
                                has it as its message */
};

/* Runs the scene. The file is valid at every moment; errors that come after its creation leave it
 * so, and it can be resumed. An existing file is touched only with `resume` or `force`, and in the
 * latter case not before its replacement is complete. What is resumed is the stored scene with the
 * new duration: a run that its balls started from is not read again. Where balls start from a run,
 * the blades begin where they stood then. summary (may be NULL) is filled as far as the run came.
 * Errors: EM_INPUT (scene does not fit the file to be resumed, or the targets; the file exists),
 * EM_FILE (cannot be written; another process writes it; disk full), EM_FORMAT (damaged file),
 * EM_STOPPED, and those of em_recorder_start and em_world_run; where such an error's end cannot be
 * stored either, err tells both. `*created` (may be NULL) tells whether the run file exists. */
enum em_status em_recorder_run(const struct em_scene *scene,
                               const struct em_recorder_options *options,
                               struct em_summary *summary, bool *created, struct em_error *err);

/* The scene's balls at its start, placed by em_start_make; of a scene that starts from a run, after
 * that run's last frame: turn its blades (em_run_file_turn) before. em_start_free. Errors: those of
 * em_run_file_last and em_start_make. */
enum em_status em_recorder_start(struct em_balls **start, const struct em_scene *scene,
                                 const volatile sig_atomic_t *stop, struct em_error *err);

/* The name of a run file that a scene gets by default: the scene's file name without folder and
 * ".cfg", and ".h5"; `size` bytes at most. */
void em_recorder_default_path(const struct em_scene *scene, char *path, size_t size);

#ifdef __cplusplus
}
#endif

#endif
