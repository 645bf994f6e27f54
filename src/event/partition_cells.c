/* Cells: blocks a little wider than the largest ball. Balls that touch are in the same or in
 * adjacent cells, so that a ball's candidates are the balls of 27 cells, however many there are. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "event/partition.h"
#include "event/span.h"

enum {
  ROOM_LEAST = 4, /* balls per cell, doubled when one is full */
  TURN_LEAST = 5  /* fewer cells along a periodic edge are made one: see em_span_room */
};

struct em_places {
  uint32_t count;
  int n[3];       /* cells along each axis */
  double edge[3]; /* m */
  double low[3], period[3];
  double slack; /* m */
  double room;  /* m, of the sphere in which a ball stays too; INFINITY: none is needed */
  struct em_vec *centre;
  int (*cell)[3];  /* of each ball */
  uint32_t *held;  /* balls in each cell */
  uint32_t *id;    /* per cell: id[most] */
  uint32_t most;   /* room in a cell */
  uint32_t *mask;  /* blades in each cell; NULL without blades */
  uint32_t *found; /* scratch: candidates */
};

static void split(struct em_vec a, double part[3]) {
  part[0] = a.x;
  part[1] = a.y;
  part[2] = a.z;
}

static size_t cells(const struct em_places *p) {
  return (size_t)p->n[0] * (size_t)p->n[1] * (size_t)p->n[2];
}

static size_t index_of(const struct em_places *p, const int cell[3]) {
  return (size_t)cell[0] + (size_t)p->n[0] * ((size_t)cell[1] + (size_t)p->n[1] * (size_t)cell[2]);
}

/* Borders of cell k along an axis; the outermost of a closed axis have none outside. */
static double low_of(const struct em_places *p, int axis, int k) {
  const bool open = p->n[axis] == 1 || (k == 0 && p->period[axis] <= 0.0);
  return open ? -INFINITY : p->low[axis] + k * p->edge[axis];
}

static double high_of(const struct em_places *p, int axis, int k) {
  const bool open = p->n[axis] == 1 || (k == p->n[axis] - 1 && p->period[axis] <= 0.0);
  return open ? INFINITY : p->low[axis] + (k + 1) * p->edge[axis];
}

/* The coordinate as it is seen from cell k. */
static double seen(const struct em_places *p, int axis, int k, double x) {
  return em_span_image(x, p->low[axis] + (k + 0.5) * p->edge[axis], p->period[axis]);
}

static void set_leave(struct em_world *w, uint32_t i, double from) {
  const struct em_places *p = w->places;
  double x[3], v[3], g[3], stay = INFINITY;
  split(em_body_at(w, i, from), x);
  split(em_body_velocity(w, i, from), v);
  split(w->gravity, g);
  for (int a = 0; a < 3; a++) {
    const int k = p->cell[i][a];
    stay = fmin(stay,
                em_span_leave(seen(p, a, k, x[a]), v[a], g[a], low_of(p, a, k), high_of(p, a, k)));
  }
  double leave = from + stay;
  if (p->centre) leave = fmin(leave, em_partition_stay(w, i, from, p->centre[i], p->room));
  w->leave[i] = fmin(leave, em_span_limit(w, from));
}

static void moved(struct em_world *w, uint32_t i) {
  set_leave(w, i, w->body[i].t);
}

static bool widen(struct em_places *p) {
  const size_t n = cells(p), old = p->most, most = old ? 2 * old : ROOM_LEAST;
  uint32_t *id = em_body_array(n * most, sizeof *id);
  if (!id) return false;
  for (size_t c = 0; old && c < n; c++)
    memcpy(id + c * most, p->id + c * old, p->held[c] * sizeof *id);
  free(p->id);
  p->id = id;
  p->most = (uint32_t)most;
  return true;
}

static bool enter(struct em_places *p, uint32_t i) {
  const size_t c = index_of(p, p->cell[i]);
  if (p->held[c] == p->most && !widen(p)) return false;
  p->id[c * p->most + p->held[c]++] = i;
  return true;
}

static void quit(struct em_places *p, uint32_t i) {
  const size_t c = index_of(p, p->cell[i]);
  uint32_t *id = p->id + c * p->most, k = 0;
  while (id[k] != i)
    k++;
  id[k] = id[--p->held[c]];
}

/* The cells first … last along an axis that exist, each once; returns how many. */
static int range(const struct em_places *p, int axis, int first, int last, int list[3]) {
  int found = 0;
  for (int k = first; k <= last; k++) {
    const int n = p->n[axis];
    if (n == 1 && k != 0) continue;
    if (p->period[axis] > 0.0)
      list[found++] = (k + n) % n;
    else if (k >= 0 && k < n)
      list[found++] = k;
  }
  return found;
}

/* The balls of a block of at most 3 × 3 × 3 cells, except i. */
static uint32_t collect(struct em_places *p, uint32_t i, const int first[3], const int last[3]) {
  int list[3][3], size[3];
  uint32_t n = 0;
  for (int a = 0; a < 3; a++)
    size[a] = range(p, a, first[a], last[a], list[a]);
  for (int c = 0; c < size[2]; c++)
    for (int b = 0; b < size[1]; b++)
      for (int a = 0; a < size[0]; a++) {
        const int cell[3] = {list[0][a], list[1][b], list[2][c]};
        const size_t at = index_of(p, cell);
        const uint32_t *id = p->id + at * p->most;
        for (uint32_t k = 0; k < p->held[at]; k++)
          if (id[k] != i) p->found[n++] = id[k];
      }
  return n;
}

static const uint32_t *candidates(struct em_world *w, uint32_t i, uint32_t *count) {
  struct em_places *p = w->places;
  const int *c = p->cell[i];
  const int first[3] = {c[0] - 1, c[1] - 1, c[2] - 1}, last[3] = {c[0] + 1, c[1] + 1, c[2] + 1};
  *count = collect(p, i, first, last);
  return p->found;
}

/* The axis along which ball i leaves its cell at `now`, and to which side; 0: it does not. */
static int exit_side(const struct em_world *w, uint32_t i, double now, int *axis) {
  const struct em_places *p = w->places;
  double x[3], v[3], g[3];
  split(em_body_at(w, i, now), x);
  split(em_body_velocity(w, i, now), v);
  split(w->gravity, g);
  for (int a = 0; a < 3; a++) {
    const int k = p->cell[i][a];
    const int side =
        em_span_side(seen(p, a, k, x[a]), v[a], g[a], low_of(p, a, k), high_of(p, a, k), p->slack);
    *axis = a;
    if (side) return side;
  }
  return 0;
}

static const uint32_t *cross(struct em_world *w, uint32_t i, double now, uint32_t *count) {
  struct em_places *p = w->places;
  int axis, *c = p->cell[i];
  const int side = exit_side(w, i, now, &axis);
  *count = 1;
  if (side) {
    quit(p, i);
    c[axis] = (c[axis] + side + p->n[axis]) % p->n[axis];
    if (!enter(p, i)) return NULL;
  }
  if (p->centre) p->centre[i] = em_body_at(w, i, now);
  set_leave(w, i, now);
  if (p->centre) return candidates(w, i, count);
  int first[3] = {c[0] - 1, c[1] - 1, c[2] - 1}, last[3] = {c[0] + 1, c[1] + 1, c[2] + 1};
  first[axis] = last[axis] = c[axis] + side; /* only these cells are new */
  *count = side ? collect(p, i, first, last) : 0;
  return p->found;
}

static uint32_t surfaces(const struct em_world *w, uint32_t i) {
  const struct em_places *p = w->places;
  return EM_NEAR_WALL | (p->mask ? p->mask[index_of(p, p->cell[i])] : 0);
}

static void free_places(struct em_places *p) {
  if (!p) return;
  free(p->centre);
  free(p->cell);
  free(p->held);
  free(p->id);
  free(p->mask);
  free(p->found);
  free(p);
}

/* Cells as small as touching balls allow, but not many more than balls. */
static void set_cells(const struct em_world *w, struct em_places *p) {
  double extent[3];
  split(em_vec_sub(w->high, w->low), extent);
  split(w->low, p->low);
  split(w->period, p->period);
  p->slack = 1e-6 * w->largest;
  double edge = 2.0 * w->largest + 4.0 * p->slack;
  const double most = 4.0 * w->count + 64.0;
  while (fmax(1.0, extent[0] / edge) * fmax(1.0, extent[1] / edge) * fmax(1.0, extent[2] / edge) >
         most)
    edge *= 1.1;
  p->room = INFINITY;
  for (int a = 0; a < 3; a++) {
    p->n[a] = extent[a] > edge ? (int)(extent[a] / edge) : 1;
    if (p->period[a] > 0.0 && p->n[a] < TURN_LEAST) {
      p->n[a] = 1;
      p->room = em_span_room(w);
    }
    p->edge[a] = extent[a] / p->n[a];
  }
}

static bool take_arrays(const struct em_world *w, struct em_places *p) {
  p->cell = em_body_array(p->count, sizeof *p->cell);
  p->found = em_body_array(p->count, sizeof *p->found);
  p->held = em_body_array(cells(p), sizeof *p->held);
  if (w->blade_count) p->mask = em_body_array(cells(p), sizeof *p->mask);
  if (p->room < INFINITY) p->centre = em_body_array(p->count, sizeof *p->centre);
  return p->cell && p->found && p->held && widen(p) && (p->mask || !w->blade_count) &&
         (p->centre || p->room == INFINITY);
}

static void set_blades(const struct em_world *w, struct em_places *p) {
  const double half =
      0.5 * sqrt(p->edge[0] * p->edge[0] + p->edge[1] * p->edge[1] + p->edge[2] * p->edge[2]);
  int c[3];
  for (c[2] = 0; c[2] < p->n[2]; c[2]++)
    for (c[1] = 0; c[1] < p->n[1]; c[1]++)
      for (c[0] = 0; c[0] < p->n[0]; c[0]++) {
        const struct em_vec centre = {p->low[0] + (c[0] + 0.5) * p->edge[0],
                                      p->low[1] + (c[1] + 0.5) * p->edge[1],
                                      p->low[2] + (c[2] + 0.5) * p->edge[2]};
        p->mask[index_of(p, c)] = em_partition_blades(w, centre, w->largest, half + 2.0 * p->slack);
      }
}

static int cell_along(const struct em_places *p, int axis, double x) {
  const int n = p->n[axis];
  double d = x - p->low[axis];
  if (p->period[axis] > 0.0) d -= p->period[axis] * floor(d / p->period[axis]);
  const int k = (int)floor(d / p->edge[axis]);
  return k < 0 ? 0 : k >= n ? n - 1 : k;
}

static bool fill(struct em_world *w, struct em_places *p) {
  for (uint32_t i = 0; i < p->count; i++) {
    double x[3];
    split(em_body_at(w, i, w->clock), x);
    for (int a = 0; a < 3; a++)
      p->cell[i][a] = cell_along(p, a, x[a]);
    if (p->centre) p->centre[i] = em_body_at(w, i, w->clock);
    if (!enter(p, i)) return false;
    set_leave(w, i, w->clock);
  }
  return true;
}

static enum em_status make(struct em_world *w, struct em_places **places, struct em_error *err) {
  struct em_places *p = calloc(1, sizeof *p);
  if (!p) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the cells");
  p->count = w->count;
  set_cells(w, p);
  if (!(p->room > 0.0)) {
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
  if (p->mask) set_blades(w, p);
  *places = p;
  return EM_OK;
}

static size_t bytes(const struct em_places *p) {
  const size_t each = sizeof *p->cell + sizeof *p->found + (p->centre ? sizeof *p->centre : 0);
  const size_t cell = sizeof *p->held + p->most * sizeof *p->id + (p->mask ? sizeof *p->mask : 0);
  return sizeof *p + p->count * each + cells(p) * cell;
}

/* Every ball is in its cell, once. */
static bool is_valid(const struct em_world *w) {
  const struct em_places *p = w->places;
  size_t sum = 0;
  for (size_t c = 0; c < cells(p); c++)
    sum += p->held[c];
  for (uint32_t i = 0; i < p->count; i++) {
    const size_t c = index_of(p, p->cell[i]);
    uint32_t seen_here = 0;
    for (uint32_t k = 0; k < p->held[c]; k++)
      seen_here += p->id[c * p->most + k] == i;
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
