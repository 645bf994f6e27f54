/* What a run that is recorded consists of. */
#ifndef EVENTMILL_RECORDER_INSIDE_H
#define EVENTMILL_RECORDER_INSIDE_H

#include "eventmill/precision.h"
#include "eventmill/recorder.h"
#include "eventmill/world.h"
#include "record/summary.h"
#include "record/writer.h"

struct recorder {
  const struct em_scene *scene;
  struct em_scene *own; /* a copy: of a run that is resumed, or with its blades turned; or NULL */
  const struct em_recorder_options *options;
  struct em_world *world;
  struct em_writer *writer;         /* NULL: no file */
  struct em_balls *balls;           /* room for a state */
  double *speeds, *impulse;         /* room; angular impulses at the sample before */
  double sample_before;             /* s, time of that sample */
  uint64_t frames, samples, blocks; /* index of the next one of each */
  uint64_t *block_base, *block;     /* counts at the block's start; room for a block */
  struct em_run_state state;
  struct em_run_session session;
  struct em_summary_part part;
  struct em_precision *precision; /* NULL: none is asked for */
  bool resumed, finished, enough;
  double reached;                    /* s: the last sampling time that the world arrived at */
  double begun, flushed, flush_cost; /* s, wall clock */
  uint64_t at_begin;                 /* collisions */
};

enum { COUNTS = EM_CLASS_COUNT * EM_TALLY_BINS };

/* Takes the block of the histogram from start to end (s), which is in r->block, to the figures
 * whose precision counts. Errors: EM_MEMORY. */
enum em_status em_recorder_add_precision(struct recorder *r, double start, double end,
                                         struct em_error *err);
/* Are all targets reached? What is known of them goes to options->found. */
bool em_recorder_is_enough(const struct recorder *r);

/* Does the time (s) belong to a run of that duration (s), rounding of either put aside? */
bool em_recorder_is_within(double time, double duration);

/* Goes on with the run that is stored at the path. Errors: EM_INPUT (of another scene, or beyond
 * the duration already), EM_FORMAT, EM_FILE, EM_MEMORY, and those of em_world_resume. */
enum em_status em_recorder_resume(struct recorder *r, struct em_error *err);

#endif
