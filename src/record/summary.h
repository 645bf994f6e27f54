/* The key figures of a run, gathered while it goes on. */
#ifndef EVENTMILL_SUMMARY_H
#define EVENTMILL_SUMMARY_H

#include "eventmill/recorder.h"
#include "eventmill/world.h"
#include "record/observe.h"

/* What the key figures of the steady part need. */
struct em_summary_part {
  double steady; /* s: where it begins */
  size_t samples, room;
  double *time, *median, *work, *resting; /* of the observables, owned */
  uint64_t *vn;   /* [EM_TALLY_BINS], of the blocks in the steady part, owned */
  double covered; /* s, length of these blocks */
};

/* false: no memory. */
bool em_summary_begin(struct em_summary_part *part, double duration);
void em_summary_end(struct em_summary_part *part);

/* A sample of the observables; a complete block of the histogram ([EM_CLASS_COUNT *
 * EM_TALLY_BINS]). */
bool em_summary_sample(struct em_summary_part *part, double time, double median, double work,
                       double resting);
void em_summary_block(struct em_summary_part *part, double start, double end,
                      const uint64_t *counts);

/* What the user has to know: that many balls of a driven scene rest in its steady part, which
 * neither rotors nor a turning drum stir. Empty when there is nothing to say. */
void em_summary_warn(const struct em_summary_part *part, const struct em_scene *scene, char *text,
                     size_t size);

/* Does gravity pull balls across a periodic boundary, where potential energy has no meaning? */
bool em_summary_falls_for_ever(const struct em_scene *scene);

/* What an error of the energy balance is relative to: the largest of the energies (J) that took
 * part. kinetic: with spin; rise: of the potential energy. */
double em_summary_energy_scale(double kinetic_start, double kinetic, double rise, double work,
                               double lost);

/* Figures that follow from the world as it is. */
void em_summary_fill(struct em_summary *summary, const struct em_summary_part *part,
                     const struct em_scene *scene, const struct em_world *world,
                     const struct em_run_state *state, const struct em_observe_state *now);

#endif
