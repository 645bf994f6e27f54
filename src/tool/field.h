/* Sums over the cells of a drum, streamed from the frames or the collision table of a run. */
#ifndef EVENTMILL_FIELD_H
#define EVENTMILL_FIELD_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/cells.h"
#include "eventmill/interval.h"
#include "tool/window.h"

/* code, name, symbol, unit of the mapped value */
#define EM_FIELD_LIST(X)                                             \
  X(COUNT, "count", "balls per volume", "1/cm³")                     \
  X(HITS, "hits", "collisions per volume and time", "1/(cm³ s)")     \
  X(SPEED, "speed", "mean speed of the balls", "m/s")                \
  X(VN, "vn", "mean normal collision speed", "m/s")                  \
  X(ENERGY, "energy", "Σ ½ m_eff v_n² per volume and time", "W/cm³") \
  X(LOST, "lost", "dissipated per volume and time", "W/cm³")
#define EM_FIELD_ENUM(code, name, symbol, unit) EM_FIELD_##code,
enum em_field_of { EM_FIELD_LIST(EM_FIELD_ENUM) EM_FIELD_COUNT_OF };
#undef EM_FIELD_ENUM

enum {
  EM_FIELD_GROUPS = 16
}; /* successive stretches of time, for errors that respect correlation */

struct em_field {
  enum em_field_of of;
  struct em_cells *cells;
  double group_time;              /* s of each group; for frames: frames of each, as doubles */
  size_t groups;                  /* in use */
  double weight[EM_FIELD_GROUPS]; /* frames, or s */
  double *n, *sum;                /* [groups * cells], values and their sum; of counts, each is 1 */
  double *square;                 /* [cells], sum of their squares */
  double total;                   /* values in all cells */
  double outside;                 /* values in no cell */
  double rim; /* share of ball centres in the outer 7.84 % (1 of 25 tubes) of the area that
                 centres reach; NAN for collisions */
};

int em_field_find(const char *name); /* -1: no such quantity */
const char *em_field_name(enum em_field_of of);
const char *em_field_symbol(enum em_field_of of);
const char *em_field_unit(enum em_field_of of);
bool em_field_is_mean(enum em_field_of of); /* a mean per value; else a density */

/* Takes over the cells. classes: bits; 0: all. Errors: EM_INPUT (what is needed is not in the
 * file), EM_MEMORY and those of reading. */
enum em_status em_field_new(struct em_field **field, const struct em_run_file *run,
                            enum em_field_of of, unsigned classes, struct em_cells *cells,
                            const struct em_window *window, struct em_error *err);
void em_field_free(struct em_field *field);

double em_field_values(const struct em_field *field, size_t cell); /* how many fell into it */

/* The mapped value of a cell, and of a tube in all slices together; NAN without data. */
struct em_interval em_field_value(const struct em_field *field, size_t cell, double level);
struct em_interval em_field_tube_value(const struct em_field *field, size_t tube, double level);

/* Relative standard deviation of the values in a cell (16-2); NAN for fewer than 2, and for what is
 * no mean. */
double em_field_spread(const struct em_field *field, size_t cell);

#endif
