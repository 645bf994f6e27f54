/* What the tests of the engine share: a world from a few words, and a trail of its collisions. */
#ifndef EVENTMILL_TESTS_TRIAL_H
#define EVENTMILL_TESTS_TRIAL_H

#include <stdbool.h>
#include <stdint.h>

#include "eventmill/world.h"

/* A scene, its balls (the start; overwritten by trial_state), its world. */
struct trial {
  struct em_scene *scene;
  struct em_balls *balls;
  struct em_world *world;
  struct em_error err;
};

/* All fail the running test on an error. scene: a file (*.cfg) or a scene's text; format: overrides
 * KEY=VALUE, separated by spaces. trial_scene stops before the start, trial_balls before the world,
 * so that a test can place balls of its own in between. */
void trial_scene(struct trial *t, const char *scene, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void trial_balls(struct trial *t);
void trial_world(struct trial *t);
void trial_open(struct trial *t, const char *scene, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void trial_free(struct trial *t);

void trial_run(struct trial *t, double until);
void trial_collide(struct trial *t, uint64_t count);
void trial_valid(struct trial *t, double tolerance);
void trial_state(struct trial *t);

/* Total energy (J) now; overwrites t->balls. */
double trial_energy(struct trial *t);
/* (E + lost − work − E0)/(|E0| + lost + |work|): what the books miss, since the world was made. */
double trial_books(struct trial *t, double energy0);

/* The sequence of collisions, to the last bit. */
struct trail {
  uint64_t hash, count;
  double last; /* s, time of the last one */
};
void trail_watch(struct trail *trail, struct em_world *world);
/* The same for the state of all balls, spins and tallies of a world. */
uint64_t trail_of_state(const struct em_world *world);

/* Random numbers of the tests (splitmix64). */
uint64_t dice_bits(uint64_t *seed);
double dice(uint64_t *seed); /* [0, 1) */
double dice_in(uint64_t *seed, double low, double high);
double dice_power(uint64_t *seed, double low, double high); /* uniform in the logarithm */
struct em_vec dice_direction(uint64_t *seed);

/* How often a hard case is tried: few times, or, in the long form of a program (LONG_FORM), many
 * times, multiplied by the environment's EVENTMILL_TRIES, but never less often than few. */
#ifdef LONG_FORM
#define TRIES(few, many) hard_tries(few, many)
#else
#define TRIES(few, many) ((uint64_t)(few))
#endif
uint64_t hard_tries(double few, double many);

/* Of the tests that follow only those run whose names match the environment's EVENTMILL_CASE. */
void hard_choose(void);

/* One line of the table of hard cases. */
void hard_row(const char *name, const char *hard, double tries, const char *checked,
              const char *worst, ...) __attribute__((format(printf, 5, 6)));

#endif
