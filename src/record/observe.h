/* The observables of a run: which ones a scene has, and their values now. */
#ifndef EVENTMILL_OBSERVE_H
#define EVENTMILL_OBSERVE_H

#include <stdbool.h>

#include "eventmill/scene.h"
#include "eventmill/start.h"
#include "eventmill/world.h"

/* All that an observable is computed from. */
struct em_observe_state {
  const struct em_world *world;
  double time;                     /* s */
  struct em_energy energy;         /* J */
  double median_speed, mean_speed; /* m/s */
  double resting;                  /* share of the balls that cannot rise by their diameter */
  double interval;                 /* s since the sample before; 0 at the first one */
  const double *impulse_before;    /* N m s, angular impulse per blade at the sample before */
};

/* Whether a scene calls for it, and how many numbers it has there; `fill` writes them: doubles, or
 * uint64_t when is_count. */
struct em_observable {
  const char *name, *unit;
  bool is_count, is_vector;
  size_t (*width)(const struct em_scene *scene); /* 0: the scene has no such observable */
  void (*fill)(const struct em_observe_state *state, void *cells);
};

extern const struct em_observable em_observe_list[];
extern const size_t em_observe_count;

/* Fills in energy and speeds of a state of the balls, and how many of them rest: ½ v² < |g| d, seen
 * from the room or from a chamber that turns. speeds: room for one number per ball. */
void em_observe_balls(struct em_observe_state *state, const struct em_scene *scene,
                      const struct em_balls *balls, double *speeds);

/* The work (J) that all moving surfaces have done on the balls since the start. */
double em_observe_work(const struct em_world *world);
/* The energy (J) dissipated in all contacts since the start. */
double em_observe_lost(const struct em_world *world);

#endif
