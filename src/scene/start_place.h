/* Ways to place the balls of a scene in a field. */
#ifndef EVENTMILL_SCENE_START_PLACE_H
#define EVENTMILL_SCENE_START_PLACE_H

#include <gsl/gsl_rng.h>

#include "scene/start_field.h"

/* Free room between neighbours, as a share of the ball's radius. */
#define EM_START_CLEARANCE 1e-9

/* Balls first … first + count − 1, of one species. */
struct em_start_group {
  const struct em_species *species;
  size_t number, first; /* of the species, of its first ball */
};

/* The box that a species' centres may be in. */
void em_start_place_box(const struct em_start_field *field, const struct em_species *species,
                        struct em_vec *low, struct em_vec *high);

/* A point that is uniform in the part of the chamber where the species' centres may be. */
struct em_vec em_start_place_point(const struct em_start_field *field,
                                   const struct em_species *species, gsl_rng *rng);

/* Random insertion of all groups, the largest balls first; where that finds no room, the rest is
 * strewn with overlaps, which are then pushed apart. The field keeps the balls. */
enum em_status em_start_place_random(struct em_start_field *field, size_t count,
                                     struct em_start_group *group, gsl_rng *rng,
                                     struct em_error *err);

/* A face-centred lattice for groups that share one region, dealt to them at random. */
enum em_status em_start_lattice_fill(struct em_start_field *field, size_t count,
                                     const struct em_start_group *group, gsl_rng *rng,
                                     struct em_error *err);

/* Pushes the balls of the groups apart until none overlaps, or the field's `stop` ends it; true
 * when that is reached. All other balls in the field stay where they are. `loose[k]`: ball k may
 * move, within species[k]'s box. */
bool em_start_relax_push(struct em_start_field *field, const bool *loose, gsl_rng *rng);

#endif
