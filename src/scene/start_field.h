/* The room in which balls are placed: walls, blades, and the balls that are there already. */
#ifndef EVENTMILL_SCENE_START_FIELD_H
#define EVENTMILL_SCENE_START_FIELD_H

#include <stdbool.h>
#include <stdint.h>

#include "eventmill/start.h"

struct em_start_field {
  const struct em_scene *scene;
  struct em_balls *balls;            /* borrowed */
  const volatile sig_atomic_t *stop; /* non-zero: the placing shall end. NULL: never */
  struct em_vec low, high, size;
  bool drum, periodic[3];
  struct em_blade *blade; /* owned; all blades, those without tips as flat ones */
  size_t blade_count;
  int32_t cells[3];
  struct em_vec per_length; /* cells per m */
  int32_t *head, *next;     /* owned; balls by cell, -1 ends a list */
};

/* An empty field; balls have their radii, their positions count only once they are put in. */
enum em_status em_start_field_make(struct em_start_field *field, const struct em_scene *scene,
                                   struct em_balls *balls, struct em_error *err);
void em_start_field_free(struct em_start_field *field);

/* Shall the placing end? The error for it. */
bool em_start_field_stops(const struct em_start_field *field);
enum em_status em_start_field_stopped(struct em_error *err);

/* Takes all balls out; puts ball k in at its position. */
void em_start_field_clear(struct em_start_field *field);
void em_start_field_put(struct em_start_field *field, size_t k);

/* The number of the cell that a position is in. */
size_t em_start_field_cell(const struct em_start_field *field, struct em_vec r);

/* Shortest vector from b to a (m), across periodic boundaries. */
struct em_vec em_start_field_between(const struct em_start_field *field, struct em_vec a,
                                     struct em_vec b);

/* A position moved into the period. */
struct em_vec em_start_field_wrap(const struct em_start_field *field, struct em_vec r);

/* Smallest gap (m) between a ball of that radius at r and the walls; between it and the blades
 * (with its blade, if asked for), INFINITY where there are none near. */
double em_start_field_wall_gap(const struct em_start_field *field, struct em_vec r, double radius);
double em_start_field_blade_gap(const struct em_start_field *field, struct em_vec r, double radius,
                                const struct em_blade **nearest);

/* Calls visit for each ball in the cells around r, until it returns false. */
bool em_start_field_each(const struct em_start_field *field, struct em_vec r,
                         bool (*visit)(void *self, size_t k), void *self);

/* Would ball k at r be free of all others, walls and blades, by `clearance` of its radius? */
bool em_start_field_fits(const struct em_start_field *field, size_t k, struct em_vec r,
                         double clearance);

#endif
