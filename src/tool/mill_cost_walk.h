/* A world on its way from the steady state, with its books: what mill cost reads its figures from.
 */
#ifndef EVENTMILL_MILL_COST_WALK_H
#define EVENTMILL_MILL_COST_WALK_H

#include <signal.h>

#include "eventmill/precision.h"
#include "eventmill/world.h"

struct em_walk {
  struct em_world *world;
  struct em_balls *balls; /* room for a state */
  double *speeds;         /* room */
  struct em_precision *precision;
  uint64_t *vn, *before; /* counts of a block; before it */
  double start, done;    /* s: simulated */
  double work;           /* J, before the block */
  struct em_energy energy;
  const volatile sig_atomic_t *stop; /* as in em_world_run */
  double most;                       /* 1/s: collisions that are too many; 0: none are */
  bool falls; /* gravity pulls the balls across a periodic boundary: their energy has no meaning */
};

/* Begins at a state, in the shape that the scene needs: without spins, with other blades.
 * em_mill_cost_walk_end after errors too. Errors: those of em_world_resume. */
enum em_status em_mill_cost_walk_begin(struct em_walk *walk, const struct em_snapshot *from,
                                       const struct em_scene *scene,
                                       const volatile sig_atomic_t *stop, struct em_error *err);
void em_mill_cost_walk_end(struct em_walk *walk);

/* Goes on for `time` (s), a block of its figures where `booked`; *spent: s of computing, of the
 * events alone. What comes before the first block is in none. Errors: those of em_world_run,
 * EM_COLLAPSE (too many collisions). */
enum em_status em_mill_cost_walk_on(struct em_walk *walk, double time, bool booked, double *spent,
                                    struct em_error *err);

/* What the books of energy miss, relative to the largest amount in them; NAN where balls fall for
 * ever. */
double em_mill_cost_walk_energy(struct em_walk *walk);

/* The key figures over all blocks, EM_PRECISION_COUNT of them. */
void em_mill_cost_walk_figures(const struct em_walk *walk, struct em_interval *figure);

/* s of computing by this thread. */
double em_mill_cost_walk_clock(void);

#endif
