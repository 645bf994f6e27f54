/* Cells: blocks a little wider than the largest ball. Balls that touch are in the same or in
 * adjacent cells, so that a ball's candidates are the balls of 27 cells, however many there are. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "event/partition.h"
#include "event/span.h"

/* A block holds the balls of a cell, and in its last place how many they are. */
enum {
  BLOCK_LEAST = 8, /* doubled when one is full */
  TURN_LEAST = 5,  /* fewer cells along a periodic edge are made one: see em_span_room */
  STAYS = 6        /* the leave time is not that of an exit */
};

#define CROWD 0.75 /* least edge, of the mean distance of balls: gases cross less often */

/* Where a ball is: its cell along each axis, counted from 1, and the side by which it leaves, twice
 * the axis, and one more for the upper side. */
struct place {
  uint16_t at[3];
  uint16_t exit;
};

/* One axis. Cells 0 and n + 1 are those beyond the ends: round the period, or empty. */
struct axis {
  int n;
  double low, edge, period, per_period; /* m, m, m, 1/m; 0 where not periodic */
  uint32_t *line;                       /* what cell k adds to the number of a block */
  double *border;                       /* lower border of cell k; infinite at closed ends */
};

struct em_places {
  uint32_t count;
  struct axis axis[3];
  size_t blocks;
  uint32_t room; /* of a block, its last place included */
  uint32_t *block;
  uint32_t *near; /* surfaces near each block; NULL where there are none */
  struct place *place;
  double slack;  /* m */
  double room_m; /* m, of the sphere in which a ball stays too; INFINITY: none is needed */
  struct em_vec *centre;
  uint32_t *found; /* scratch: candidates */
};

static void split(struct em_vec a, double part[3]) {
  part[0] = a.x;
  part[1] = a.y;
  part[2] = a.z;
}

static size_t block_of(const struct em_places *p, const uint16_t at[3]) {
  return (size_t)p->axis[0].line[at[0]] + p->axis[1].line[at[1]] + p->axis[2].line[at[2]];
}

/* --- leaving ---------------------------------------------------------------------------------- */

/* Time until x + v t leaves low … high; x may be beyond by a rounding. */
static inline double straight(double x, double v, double low, double high) {
  const double gap = v > 0.0 ? high - x : x - low, t = gap / fabs(v);
  return v == 0.0 ? INFINITY : t > 0.0 ? t : 0.0;
}

/* The same for x + v t + g t²/2. A path that turns at a border does not cross it. */
static double curved(double x, double v, double g, double low, double high, bool *up) {
  double below = fmax(x - low, 0.0), above = fmax(high - x, 0.0);
  const bool rising = g > 0.0;
  if (rising) {
    const double swap = below;
    below = above, above = swap;
    v = -v, g = -g;
  }
  const double root = sqrt(v * v - 2.0 * g * below);
  const double fall = v > 0.0 ? (v + root) / -g : below > 0.0 ? 2.0 * below / (root - v) : 0.0;
  const double disc = v * v + 2.0 * g * above;
  const bool over = v > 0.0 && disc > 0.0;
  *up = over != rising;
  return over ? 2.0 * above / (v + sqrt(disc)) : fall;
}

static void set_leave(struct em_world *w, uint32_t i, double from, struct em_vec x,
                      struct em_vec v) {
  struct em_places *p = w->places;
  struct place *here = &p->place[i];
  const double at[3] = {x.x, x.y, x.z}, to[3] = {v.x, v.y, v.z};
  const double g[3] = {w->gravity.x, w->gravity.y, w->gravity.z};
  double stay = INFINITY;
  unsigned exit = STAYS;
  for (unsigned a = 0; a < 3; a++) {
    const struct axis *axis = &p->axis[a];
    const double low = axis->border[here->at[a]], high = axis->border[here->at[a] + 1];
    double y = at[a];
    const double middle = axis->low + (here->at[a] - 0.5) * axis->edge;
    if (axis->period > 0.0) y -= em_body_shift(y - middle, axis->period, axis->per_period);
    bool up = to[a] > 0.0;
    const double t =
        g[a] == 0.0 ? straight(y, to[a], low, high) : curved(y, to[a], g[a], low, high, &up);
    exit = t < stay ? 2 * a + up : exit;
    stay = t < stay ? t : stay;
  }
  here->exit = (uint16_t)exit;
  double leave = from + stay;
  if (p->centre || w->blade_count) {
    const double cap =
        p->centre ? em_partition_stay(w, i, from, p->centre[i], p->room_m) : INFINITY;
    const double most = fmin(cap, em_span_limit(w, from));
    if (most < leave) here->exit = STAYS, leave = most;
  }
  w->leave[i] = leave;
}

static void moved(struct em_world *w, uint32_t i) {
  const struct em_body *b = &w->body[i];
  set_leave(w, i, b->t, em_vec_make(b->x, b->y, b->z), em_vec_make(b->vx, b->vy, b->vz));
}

/* --- blocks ----------------------------------------------------------------------------------- */

static bool widen(struct em_places *p) {
  const size_t old = p->room, room = old ? 2 * old : BLOCK_LEAST;
  uint32_t *block = em_body_array(p->blocks * room, sizeof *block);
  if (!block) return false;
  for (size_t c = 0; old && c < p->blocks; c++) {
    const uint32_t held = p->block[(c + 1) * old - 1];
    memcpy(block + c * room, p->block + c * old, held * sizeof *block);
    block[(c + 1) * room - 1] = held;
  }
  uint32_t *found = em_body_array(27 * room + BLOCK_LEAST, sizeof *found);
  free(p->found);
  p->found = found;
  free(p->block);
  p->block = block;
  p->room = (uint32_t)room;
  return found;
}

static bool enter(struct em_places *p, uint32_t i) {
  const size_t c = block_of(p, p->place[i].at);
  if (p->block[(c + 1) * p->room - 1] == p->room - 1 && !widen(p)) return false;
  uint32_t *block = p->block + c * p->room, *held = &block[p->room - 1];
  block[(*held)++] = i;
  return true;
}

static void quit(struct em_places *p, uint32_t i) {
  uint32_t *block = p->block + block_of(p, p->place[i].at) * p->room;
  const uint32_t last = --block[p->room - 1];
  uint32_t k = 0;
  while (block[k] != i)
    k++;
  block[k] = block[last];
}

/* Adds the balls of a block behind `end`; may write eight places more. */
static inline uint32_t *add_block(const struct em_places *p, size_t c, uint32_t *end) {
  const uint32_t *block = p->block + c * p->room, held = block[p->room - 1];
  for (uint32_t k = 0; k < held; k += BLOCK_LEAST)
    memcpy(end + k, block + k, BLOCK_LEAST * sizeof *end);
  return end + held;
}

/* The balls of the cells from[a] … to[a] beside cell `at` (0: one lower, 1: itself, 2: one
 * higher). */
static inline uint32_t *collect(struct em_places *p, const uint16_t at[3], const int from[3],
                                const int to[3], uint32_t *end) {
  const uint32_t *x = p->axis[0].line + at[0] - 1, *y = p->axis[1].line + at[1] - 1;
  const uint32_t *z = p->axis[2].line + at[2] - 1;
  for (int c = from[2]; c <= to[2]; c++)
    for (int b = from[1]; b <= to[1]; b++) {
      const size_t row = (size_t)z[c] + y[b];
      for (int a = from[0]; a <= to[0]; a++)
        end = add_block(p, row + x[a], end);
    }
  return end;
}

/* With one cell along a periodic axis, that is its own neighbour: it counts once. */
static void span(const struct em_places *p, int from[3], int to[3]) {
  for (int a = 0; a < 3; a++) {
    from[a] = p->axis[a].n == 1 ? 1 : 0;
    to[a] = p->axis[a].n == 1 ? 1 : 2;
  }
}

static const uint32_t *candidates(struct em_world *w, uint32_t i, uint32_t *count) {
  struct em_places *p = w->places;
  int from[3], to[3];
  span(p, from, to);
  const uint32_t *end = collect(p, p->place[i].at, from, to, p->found);
  uint32_t k = 0;
  while (p->found[k] != i)
    k++;
  *count = (uint32_t)(end - p->found) - 1;
  p->found[k] = p->found[*count];
  return p->found;
}

static const uint32_t *cross(struct em_world *w, uint32_t i, double now, uint32_t *count) {
  struct em_places *p = w->places;
  struct place *here = &p->place[i];
  const unsigned exit = here->exit, a = exit / 2;
  *count = 1;
  if (exit != STAYS) {
    quit(p, i);
    const int n = p->axis[a].n, next = here->at[a] + (exit & 1 ? 1 : -1);
    here->at[a] = (uint16_t)(next == 0 ? n : next > n ? 1 : next);
    if (!enter(p, i)) return NULL;
  }
  const struct em_vec x = em_body_at(w, i, now);
  if (p->centre) p->centre[i] = x;
  set_leave(w, i, now, x, em_body_velocity(w, i, now));
  if (p->centre) return candidates(w, i, count);
  *count = 0;
  if (exit == STAYS) return p->found;
  int from[3], to[3];
  span(p, from, to);
  from[a] = to[a] = exit & 1 ? 2 : 0; /* only these cells are new */
  *count = (uint32_t)(collect(p, here->at, from, to, p->found) - p->found);
  return p->found;
}

static uint32_t surfaces(const struct em_world *w, uint32_t i) {
  const struct em_places *p = w->places;
  return p->near ? p->near[block_of(p, p->place[i].at)] : 0;
}

/* --- making ----------------------------------------------------------------------------------- */

static void free_places(struct em_places *p) {
  if (!p) return;
  for (int a = 0; a < 3; a++) {
    free(p->axis[a].line);
    free(p->axis[a].border);
  }
  free(p->block);
  free(p->near);
  free(p->place);
  free(p->centre);
  free(p->found);
  free(p);
}

/* Cells as small as touching balls allow, but not many more than balls. */
static void set_cells(const struct em_world *w, struct em_places *p) {
  double extent[3], low[3], period[3];
  split(em_vec_sub(w->high, w->low), extent);
  split(w->low, low);
  split(w->period, period);
  p->slack = 1e-6 * w->largest;
  const double each = em_scene_volume(w->scene) / fmax(1.0, w->count);
  double edge = fmax(2.0 * w->largest + 4.0 * p->slack, CROWD * cbrt(each));
  const double most = 4.0 * w->count + 64.0;
  while (fmax(1.0, extent[0] / edge) * fmax(1.0, extent[1] / edge) * fmax(1.0, extent[2] / edge) >
         most)
    edge *= 1.1;
  p->room_m = INFINITY;
  for (int a = 0; a < 3; a++) {
    struct axis *axis = &p->axis[a];
    axis->low = low[a];
    axis->period = period[a];
    axis->per_period = period[a] > 0.0 ? 1.0 / period[a] : 0.0;
    axis->n = extent[a] > edge ? (int)fmin(extent[a] / edge, UINT16_MAX - 2.0) : 1;
    if (period[a] > 0.0 && axis->n < TURN_LEAST) {
      axis->n = 1;
      p->room_m = em_span_room(w);
    }
    axis->edge = extent[a] / axis->n;
  }
}

/* Closed ends have an empty cell beyond them, periodic ones go on at the other end. */
static bool set_axis(struct axis *axis, uint32_t step, uint32_t *cells) {
  const uint32_t n = (uint32_t)axis->n;
  const bool open = axis->period > 0.0;
  axis->line = em_body_array(n + 2, sizeof *axis->line);
  axis->border = em_body_array(n + 3, sizeof *axis->border);
  if (!axis->line || !axis->border) return false;
  for (uint32_t k = 0; k < n + 2; k++)
    axis->line[k] = step * (!open ? k : (k + n - 1) % n);
  for (uint32_t k = 0; k < n + 3; k++)
    axis->border[k] = axis->low + ((double)k - 1.0) * axis->edge;
  if (!open || n == 1) {
    axis->border[1] = -INFINITY;
    axis->border[n + 1] = INFINITY;
  }
  *cells = open ? n : n + 2;
  return true;
}

static bool take_arrays(const struct em_world *w, struct em_places *p) {
  uint32_t step = 1, cells;
  for (int a = 0; a < 3; a++, step *= cells)
    if (!set_axis(&p->axis[a], step, &cells)) return false;
  p->blocks = step;
  p->place = em_body_array(p->count, sizeof *p->place);
  const bool any = w->drum || w->walls || w->blade_count;
  if (any) p->near = em_body_array(p->blocks, sizeof *p->near);
  if (p->room_m < INFINITY) p->centre = em_body_array(p->count, sizeof *p->centre);
  return p->place && widen(p) && (p->near || !any) && (p->centre || p->room_m == INFINITY);
}

/* Surfaces that a ball with its centre in a box c ± half can touch. */
static uint32_t surfaces_near(const struct em_world *w, const double c[3], const double half[3],
                              double slack) {
  const double reach = w->largest + slack;
  const double low[3] = {w->low.x, w->low.y, w->low.z}, high[3] = {w->high.x, w->high.y, w->high.z};
  uint32_t near = em_partition_blades(w, em_vec_make(c[0], c[1], c[2]), w->largest,
                                      hypot(half[0], hypot(half[1], half[2])) + slack);
  const double far = hypot(fabs(c[0]) + half[0], fabs(c[2]) + half[2]) + reach;
  if (w->drum && !(far < w->rho)) near |= EM_NEAR_WALL;
  for (int a = 0; a < 3; a++) {
    const double out = half[a] + reach;
    if (w->wall[2 * a] && !(c[a] - out > low[a] && c[a] + out < high[a])) near |= EM_NEAR_WALL;
  }
  return near;
}

static void set_near(const struct em_world *w, struct em_places *p) {
  const double half[3] = {0.5 * p->axis[0].edge, 0.5 * p->axis[1].edge, 0.5 * p->axis[2].edge};
  uint16_t at[3];
  for (at[2] = 1; at[2] <= p->axis[2].n; at[2]++)
    for (at[1] = 1; at[1] <= p->axis[1].n; at[1]++)
      for (at[0] = 1; at[0] <= p->axis[0].n; at[0]++) {
        double c[3];
        for (int a = 0; a < 3; a++)
          c[a] = p->axis[a].low + (at[a] - 0.5) * p->axis[a].edge;
        p->near[block_of(p, at)] = surfaces_near(w, c, half, 2.0 * p->slack);
      }
}

static uint16_t cell_along(const struct axis *axis, double x) {
  double d = x - axis->low;
  if (axis->period > 0.0) d -= axis->period * floor(d / axis->period);
  const int k = (int)floor(d / axis->edge);
  return (uint16_t)(k < 0 ? 1 : k >= axis->n ? axis->n : k + 1);
}

static bool fill(struct em_world *w, struct em_places *p) {
  for (uint32_t i = 0; i < p->count; i++) {
    const struct em_vec r = em_body_at(w, i, w->clock);
    double x[3];
    split(r, x);
    for (int a = 0; a < 3; a++)
      p->place[i].at[a] = cell_along(&p->axis[a], x[a]);
    if (p->centre) p->centre[i] = r;
    if (!enter(p, i)) return false;
    set_leave(w, i, w->clock, r, em_body_velocity(w, i, w->clock));
  }
  return true;
}

static enum em_status make(struct em_world *w, struct em_places **places, struct em_error *err) {
  struct em_places *p = calloc(1, sizeof *p);
  if (!p) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the cells");
  p->count = w->count;
  set_cells(w, p);
  if (!(p->room_m > 0.0)) {
    free_places(p);
    return em_error_set(err, EM_INPUT, w->scene->file, 0,
                        "chamber.size: a periodic edge is too short for balls of %g m diameter; "
                        "more than two diameters are needed",
                        2.0 * w->largest);
  }
  w->places = p;
  if (!take_arrays(w, p) || !fill(w, p)) {
    w->places = NULL;
    free_places(p);
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the cells");
  }
  if (p->near) set_near(w, p);
  *places = p;
  return EM_OK;
}

static size_t bytes(const struct em_places *p) {
  const size_t each = sizeof *p->place + (p->centre ? sizeof *p->centre : 0);
  const size_t block = p->room * sizeof *p->block + (p->near ? sizeof *p->near : 0);
  return sizeof *p + p->count * each + p->blocks * block + 27 * p->room * sizeof *p->found;
}

/* Every ball is in its cell, once. */
static bool is_valid(const struct em_world *w) {
  const struct em_places *p = w->places;
  size_t sum = 0;
  for (size_t c = 0; c < p->blocks; c++)
    sum += p->block[(c + 1) * p->room - 1];
  for (uint32_t i = 0; i < p->count; i++) {
    const uint32_t *block = p->block + block_of(p, p->place[i].at) * p->room;
    uint32_t seen_here = 0;
    for (uint32_t k = 0; k < block[p->room - 1]; k++)
      seen_here += block[k] == i;
    if (seen_here != 1) return false;
  }
  return sum == p->count;
}

const struct em_partition_kind em_partition_cells = {
    .name = "cells",
    .make = make,
    .free = free_places,
    .candidates = candidates,
    .moved = moved,
    .cross = cross,
    .surfaces = surfaces,
    .bytes = bytes,
    .is_valid = is_valid,
};
