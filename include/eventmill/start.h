/* The state in which a scene begins. */
#ifndef EVENTMILL_START_H
#define EVENTMILL_START_H

#include <signal.h>

#include "eventmill/error.h"
#include "eventmill/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The balls of a scene, species after species. All arrays have `count` entries and are owned. */
struct em_balls {
  size_t count;
  struct em_vec *position; /* m */
  struct em_vec *velocity; /* m/s */
  struct em_vec *spin;     /* rad/s */
  double *radius;          /* m */
  double *mass;            /* kg */
  uint16_t *species;
};

/* Places the balls of a scene (mt19937 with the scene's seed), free of overlap with each other, the
 * walls and the blades at time 0. For species that start from a run file, `previous` holds its last
 * frame (else NULL). *stop, when it turns non-zero, ends the placing (EM_STOPPED); stop may be
 * NULL. Errors: EM_INPUT (they don't fit; after a set number of tries), EM_MEMORY. */
enum em_status em_start_make(struct em_balls **balls, const struct em_scene *scene,
                             const struct em_balls *previous, const volatile sig_atomic_t *stop,
                             struct em_error *err);

/* Mass (kg) of one ball of a species: the one place where it is worked out, so that a restart has
 * the same bits. */
double em_start_mass(const struct em_species *species);

/* Room for count balls, all zero; NULL when memory is short. */
struct em_balls *em_start_new(size_t count);
void em_start_free(struct em_balls *balls);

#ifdef __cplusplus
}
#endif

#endif
