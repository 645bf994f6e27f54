/* Shells: spheres in a grid of cells, and the search for all that come near a new one. */
#ifndef EVENTMILL_SHELLS_H
#define EVENTMILL_SHELLS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "eventmill/vec.h"

enum {
  EM_SHELLS_STEP = 8,   /* a cell's room is a multiple of this */
  EM_SHELLS_FIELDS = 5, /* per cell: x[room], y[room], z[room], hull[room], id[room] */
};

/* The grid. Single precision: a centre is what it says, exactly; `slack` covers the rounding of
 * distances. Empty places of a cell have x = INFINITY, so that nothing is near them. */
struct em_shells {
  int n[3];                      /* cells along x, y, z */
  double edge[3], per_edge[3];   /* m, 1/m */
  float period[3];               /* m, 0 where not periodic */
  float lowest[3], cells_per[3]; /* low and per_edge once more */
  bool whole; /* a periodic edge has less than three cells: nearest images one by one */
  struct em_vec low;
  float slack;      /* m */
  double hull_most; /* m: largest hull that may be entered */
  uint32_t room;    /* shells per cell */
  float *block;     /* cells × EM_SHELLS_FIELDS × room */
  uint32_t *held;   /* shells in each cell */
  uint32_t *cell;   /* of each shell */
  uint32_t count;   /* shells that there can be */
  bool avx2;
};

/* In the box low … high, is a centre rounded by at most `rounding` (m), and is the square of any
 * distance from `hull` (m) on a normal number, to all its digits? */
bool em_shells_resolve(struct em_vec low, struct em_vec high, double rounding, double hull);

/* By how much (m) two shells in the box may be further apart than their hulls and still be found
 * near. */
double em_shells_slack(struct em_vec low, struct em_vec high);

/* Makes an empty grid for `count` shells in the box low … high, period 0 where it is not periodic.
 * A cell is at least as wide as two shells of hull_most reach. false: no memory. */
bool em_shells_init(struct em_shells *s, uint32_t count, struct em_vec low, struct em_vec high,
                    struct em_vec period, double hull_most, bool avx2);
void em_shells_release(struct em_shells *s);

/* Enters shell i with its centre and hull (m): room for the ball's centre plus the ball's radius.
 */
bool em_shells_enter(struct em_shells *s, uint32_t i, const float centre[3], float hull);
void em_shells_quit(struct em_shells *s, uint32_t i);
void em_shells_clear(struct em_shells *s);

/* Fills in all shells whose hulls come within reach of this one, and returns how many; `most` of
 * them means that there may be more. */
uint32_t em_shells_find(const struct em_shells *s, const float centre[3], float hull, uint32_t *id,
                        uint32_t most);
uint32_t em_shells_avx2_find(const struct em_shells *s, const float centre[3], float hull,
                             uint32_t *id, uint32_t most);

/* Asks memory for the cells that em_shells_find will look through. */
void em_shells_fetch(const struct em_shells *s, const float centre[3], float hull);

size_t em_shells_bytes(const struct em_shells *s);
/* Is shell i where its centre says? */
bool em_shells_holds(const struct em_shells *s, uint32_t i, const float centre[3]);

#endif
