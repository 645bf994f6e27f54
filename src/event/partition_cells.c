/* Cells: making them; see blocks.h. */
#include "event/blocks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CROWD 0.6   /* of the mean distance of balls: the least edge; measured */
#define WIDER 1.001 /* than a ball: what lets balls be moved on early */
#define FAR   1e100 /* m: the border of a closed end, which no ball reaches */

enum {
  TILE = 8, /* cells of a row in one cache line, if they have two slots: see set_row */
  /* Fewer cells along a periodic edge are made one (see em_span_room): two balls that are moved on
   * early are up to three cells apart, and only nearest images are met. */
  TURN_LEAST = 6,
  /* There may be a crowd for as many balls, before all cells are given more room; fewer in large
   * systems, where crowds are waited for: measured. */
  CROWDED = 100,
  CROWDED_LARGE = 400
};

static void split(struct em_vec a, double part[3]) {
  part[0] = a.x;
  part[1] = a.y;
  part[2] = a.z;
}

/* Candidates of EM_BLOCKS_MANY balls from 9 cells, or of two from 27. */
static size_t found_room(size_t room) {
  return 9 * (room + EM_BLOCKS_CROWD) * EM_BLOCKS_MANY + EM_BLOCKS_BEYOND;
}

/* --- slots ------------------------------------------------------------------------------------ */

static void put(const struct em_places *p, uint32_t *slot, uint32_t of, uint32_t number) {
  em_blocks_put(p, slot, p->plan[of].cell[0], number);
}

bool em_partition_cells_join(struct em_places *p, uint32_t *slot, uint32_t ball) {
  uint32_t *last = slot + p->room - 1;
  if (!(*last & EM_SLOTS_CROWD)) {
    const uint32_t k = p->spare;
    if (k == p->crowds) return false;
    p->spare = p->crowd[k].ball[0];
    p->crowd[k] = (struct em_blocks_crowd){1, {*last}};
    put(p, last, ball, EM_SLOTS_CROWD | k);
  }
  struct em_blocks_crowd *crowd = &p->crowd[*last & ~EM_SLOTS_CROWD];
  if (crowd->count == EM_BLOCKS_CROWD) return false;
  crowd->ball[crowd->count++] = ball;
  return true;
}

void em_partition_cells_part(struct em_places *p, uint32_t *slot, uint32_t ball) {
  uint32_t *last = slot + p->room - 1, place = 0;
  const uint32_t number = *last & ~EM_SLOTS_CROWD;
  struct em_blocks_crowd *crowd = &p->crowd[number];
  while (crowd->ball[place] != ball)
    place++;
  crowd->ball[place] = crowd->ball[--crowd->count];
  if (crowd->count > 1) return;
  put(p, last, ball, crowd->ball[0]);
  crowd->ball[0] = p->spare;
  p->spare = number;
}

uint32_t *em_partition_cells_disperse(const struct em_places *p, uint32_t self, uint32_t *candidate,
                                      uint32_t *end) {
  while (candidate < end) {
    if (!(*candidate & EM_SLOTS_CROWD)) {
      candidate++;
      continue;
    }
    const struct em_blocks_crowd *crowd = &p->crowd[*candidate & ~EM_SLOTS_CROWD];
    *candidate = *--end;
    for (uint32_t k = 0; k < crowd->count; k++) {
      *end = crowd->ball[k];
      end += crowd->ball[k] != self;
    }
  }
  return end;
}

/* Puts all balls into their cells, which are empty; false: they have not enough room. */
static bool fill_slots(struct em_places *p) {
  for (uint32_t k = 0; k < p->crowds; k++)
    p->crowd[k] = (struct em_blocks_crowd){0, {k + 1}};
  p->spare = 0;
  for (uint32_t i = 0; i < p->count; i++)
    if (!em_blocks_enter(p, i, em_blocks_number(p, p->plan[i].cell))) return false;
  return true;
}

/* Distances between cells are counted in slots. */
static void set_room(struct em_places *p, uint32_t room) {
  const ptrdiff_t was = p->room ? p->room : 1, is = room;
  for (int a = 0; a < 3; a++)
    for (int k = 0; k < p->axis[a].n + 2; k++) {
      struct em_blocks_pitch *pitch = &p->axis[a].pitch[k];
      p->axis[a].line[k] = p->axis[a].line[k] / was * is;
      pitch->to[0] = pitch->to[0] / was * is;
      pitch->to[1] = pitch->to[1] / was * is;
    }
  for (int k = 0; k < p->axis[0].n + 2; k++)
    p->image[k] = p->image[k] / was * is;
  p->room = room;
  p->room_bits = (uint32_t)__builtin_ctz(room);
}

/* Empty ones for cells of this room, and some beyond, which are read too. If it is more than it
 * was, the scratch keeps what was found. */
static bool take_slots(struct em_places *p, uint32_t room) {
  const uint32_t old = p->room;
  const size_t n = p->cells * room + 8;
  uint32_t *slot = em_body_array(n, sizeof *slot);
  uint32_t *found = em_body_array(found_room(room), sizeof *found);
  uint32_t *finder = em_body_array(found_room(room), sizeof *finder);
  if (!slot || !found || !finder) {
    free(slot);
    free(found);
    free(finder);
    return false;
  }
  for (size_t k = 0; k < n; k++)
    slot[k] = EM_SLOTS_EMPTY;
  if (old && old < room) {
    memcpy(found, p->found, found_room(old) * sizeof *found);
    memcpy(finder, p->finder, found_room(old) * sizeof *finder);
  }
  free(p->slot);
  free(p->found);
  free(p->finder);
  p->slot = slot;
  p->found = found;
  p->finder = finder;
  set_room(p, room);
  return true;
}

bool em_partition_cells_widen(struct em_places *p) {
  do
    if (!take_slots(p, p->room ? 2 * p->room : EM_BLOCKS_ROOM)) return false;
  while (!fill_slots(p));
  return true;
}

/* Would few cells be full if they had half the room? */
static bool is_roomy(const struct em_places *p) {
  uint32_t full = 0;
  for (uint32_t i = 0; i < p->count; i++) {
    const uint32_t *slot = em_blocks_slot(p, p->plan[i].cell);
    uint32_t held = 0;
    for (uint32_t k = 0; k < p->room; k++)
      held += slot[k] & EM_SLOTS_CROWD ? p->room : slot[k] != EM_SLOTS_EMPTY;
    full += 2 * held > p->room;
  }
  return full <= p->crowds;
}

/* Balls that crowded, as they do where they start, may crowd no more; if memory is short, cells
 * stay as they are. */
static bool renew(struct em_world *w) {
  struct em_places *p = w->places;
  if (p->room == EM_BLOCKS_ROOM || !is_roomy(p) || !take_slots(p, p->room / 2)) return true;
  return fill_slots(p) || em_partition_cells_widen(p);
}

static const uint32_t *candidates(struct em_world *w, uint32_t i, uint32_t *count) {
  return em_blocks_candidates(w, i, 0, count);
}

static void moved(struct em_world *w, uint32_t i) {
  em_blocks_moved(w, i, true, true);
}

static const uint32_t *cross(struct em_world *w, uint32_t i, double now, uint32_t *count) {
  return em_blocks_cross(w, i, now, count, true, true);
}

static void fetch(const struct em_world *w, uint32_t i, bool beyond, bool leaves) {
  if (beyond) em_blocks_fetch(w, i, leaves);
}

/* --- making ----------------------------------------------------------------------------------- */

static void free_places(struct em_places *p) {
  if (!p) return;
  for (int a = 0; a < 3; a++) {
    free(p->axis[a].line);
    free(p->axis[a].pitch);
    free(p->axis[a].border);
  }
  free(p->image);
  free(p->slot);
  free(p->crowd);
  free(p->near);
  free(p->centre);
  free(p->found);
  free(p->finder);
  free(p);
}

/* Cells as small as touching balls allow, but not many more than balls. */
static void set_cells(struct em_world *w, struct em_places *p) {
  double extent[3], low[3], period[3];
  split(em_vec_sub(w->high, w->low), extent);
  split(w->low, low);
  split(w->period, period);
  p->gravity = (v4d){w->gravity.x, w->gravity.y, w->gravity.z, 0.0};
  p->turned = p->gravity > v4d_all(0.0);
  p->pull = v4d_choose(p->turned, p->gravity, -p->gravity);
  p->slack = 1e-6 * w->largest;
  const double each = em_scene_volume(w->scene) / fmax(1.0, w->count);
  double edge = fmax(WIDER * 2.0 * w->largest, CROWD * cbrt(each));
  const double most = 8.0 * w->count + 64.0;
  while (fmax(1.0, extent[0] / edge) * fmax(1.0, extent[1] / edge) * fmax(1.0, extent[2] / edge) >
         most)
    edge *= 1.1;
  p->room_m = INFINITY;
  w->early = INFINITY;
  for (int a = 0; a < 3; a++) {
    struct em_blocks_axis *axis = &p->axis[a];
    axis->low = low[a];
    axis->n = extent[a] > edge ? (int)fmin(extent[a] / edge, UINT16_MAX - 2.0) : 1;
    if (period[a] > 0.0 && axis->n < TURN_LEAST) {
      axis->n = 1;
      p->room_m = em_span_room(w);
    }
    axis->edge = extent[a] / axis->n;
    if (axis->n > 1) w->early = fmin(w->early, 0.49 * (axis->edge - 2.0 * w->largest));
    axis->period = axis->n > 1 ? period[a] : 0.0;
    p->period[a] = axis->period;
    p->per_period[a] = axis->period > 0.0 ? 1.0 / period[a] : 0.0;
  }
  if (w->early == INFINITY) w->early = 0.0;
  w->early = fmin(w->early, p->room_m / 12.0); /* nor far beyond the spheres */
}

/* Rows are cut into tiles, each of one cache line where a cell has two slots: some cells, and at
 * both ends images of those that come before and after, so that any three side by side are in one
 * tile. A row of 12 cells, with its images in brackets, of which the outermost are there where it
 * is periodic:
 *
 *     (12) 1 2 3 4 5 6 (7)    (6) 7 8 9 10 11 12 (1)
 *
 * No cell has two images, for a row of more than one tile has more than one in each. Returns
 * how many cells that is. */
static uint32_t set_row(const struct em_blocks_axis *row, ptrdiff_t *image) {
  const uint32_t n = (uint32_t)row->n, tiles = (n + TILE - 3) / (TILE - 2);
  for (uint32_t t = 0, k = 1; t < tiles; t++)
    for (uint32_t place = 1; k <= (t + 1) * n / tiles; k++, place++)
      row->line[k] = TILE * t + place;
  for (uint32_t t = 1; t <= tiles; t++) {
    const uint32_t last = t * n / tiles, next = last < n ? last + 1 : 1;
    if (last == n && !(row->period > 0.0)) break;
    image[last] = row->line[next] - 1 - row->line[last];
    image[next] = row->line[last] + 1 - row->line[next];
  }
  for (uint32_t k = 1; k <= n; k++)
    row->pitch[k] = (struct em_blocks_pitch){{-1, 1}};
  return TILE * tiles;
}

/* Along y and z closed ends have an empty cell beyond them, periodic ones go on at the other end.
 */
static uint32_t set_column(const struct em_blocks_axis *axis, uint32_t step) {
  const uint32_t n = (uint32_t)axis->n;
  const bool open = axis->period > 0.0;
  ptrdiff_t *line = axis->line;
  for (uint32_t k = 0; k < n + 2; k++)
    line[k] = (ptrdiff_t)step * (open ? (k + n - 1) % n : k);
  for (uint32_t k = 1; k <= n; k++)
    axis->pitch[k] = (struct em_blocks_pitch){{line[k - 1] - line[k], line[k + 1] - line[k]}};
  return open ? n : n + 2;
}

static bool set_axes(struct em_places *p) {
  p->cells = 1;
  p->image = em_body_array((size_t)p->axis[0].n + 2, sizeof *p->image);
  for (int a = 0; a < 3; a++) {
    struct em_blocks_axis *axis = &p->axis[a];
    const size_t n = (size_t)axis->n;
    axis->line = em_body_array(n + 2, sizeof *axis->line);
    axis->pitch = em_body_array(n + 2, sizeof *axis->pitch);
    axis->border = em_body_array(n + 3, sizeof *axis->border);
    if (!axis->line || !axis->pitch || !axis->border || !p->image) return false;
    for (size_t k = 0; k < n + 3; k++)
      axis->border[k] = axis->low + ((double)k - 1.0) * axis->edge;
    if (!(axis->period > 0.0)) {
      axis->border[1] = -FAR;
      axis->border[n + 1] = FAR;
    }
    p->cells *= a == 0 ? set_row(axis, p->image) : set_column(axis, (uint32_t)p->cells);
  }
  return true;
}

static bool take_arrays(const struct em_world *w, struct em_places *p) {
  if (!set_axes(p)) return false;
  const bool any = w->drum || w->walls || w->blade_count;
  if (any) p->near = em_body_array(p->cells, sizeof *p->near);
  if (p->room_m < INFINITY) p->centre = em_body_array(p->count, sizeof *p->centre);
  p->crowds = p->count / (p->count < EM_FETCH_FROM ? CROWDED : CROWDED_LARGE) + 8;
  p->crowd = em_body_array(p->crowds, sizeof *p->crowd);
  return p->crowd && (p->near || !any) && (p->centre || p->room_m == INFINITY);
}

/* Surfaces that a ball with its centre in a box c ± half can touch. */
static uint32_t surfaces_near(const struct em_world *w, const double c[3], const double half[3],
                              double slack) {
  const double reach = w->largest + slack;
  const double low[3] = {w->low.x, w->low.y, w->low.z}, high[3] = {w->high.x, w->high.y, w->high.z};
  uint32_t near =
      em_partition_blades(w, em_vec_make(c[0], c[1], c[2]), w->largest,
                          em_vec_make(half[0] + slack, half[1] + slack, half[2] + slack));
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
        *em_blocks_near(p, em_blocks_number(p, at)) =
            surfaces_near(w, c, half, 2.0 * p->slack + w->early + w->content);
      }
  for (uint32_t i = 0; i < p->count; i++)
    p->plan[i].near = *em_blocks_near(p, em_blocks_number(p, p->plan[i].cell));
}

static uint16_t number_along(const struct em_blocks_axis *axis, double x) {
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
      p->plan[i].cell[a] = number_along(&p->axis[a], x[a]);
    if (p->centre) p->centre[i] = r;
    const struct em_vec v = em_body_velocity(w, i, w->clock);
    em_blocks_leave(w, i, w->clock, (v4d){r.x, r.y, r.z, 0.0}, (v4d){v.x, v.y, v.z, 0.0}, true,
                    true);
  }
  return em_partition_cells_widen(p);
}

static enum em_status make(struct em_world *w, struct em_error *err) {
  struct em_places *p = em_body_array(1, sizeof *p);
  if (!p) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the cells");
  p->count = w->count;
  p->plan = w->plan;
  set_cells(w, p);
  w->places = p;
  if (!take_arrays(w, p) || !fill(w, p)) {
    w->places = NULL;
    free_places(p);
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the cells");
  }
  if (p->near) set_near(w, p);
  w->crosses_all = p->centre;
  return EM_OK;
}

static size_t bytes(const struct em_places *p) {
  const size_t each = p->centre ? sizeof *p->centre : 0;
  const size_t cell = p->room * sizeof *p->slot + (p->near ? sizeof *p->near : 0);
  return sizeof *p + p->count * each + p->cells * cell + p->crowds * sizeof *p->crowd +
         2 * found_room(p->room) * sizeof *p->found;
}

static bool in_crowd(const struct em_places *p, uint32_t number, uint32_t ball) {
  const struct em_blocks_crowd *crowd = &p->crowd[number & ~EM_SLOTS_CROWD];
  for (uint32_t k = 0; number & EM_SLOTS_CROWD && k < crowd->count; k++)
    if (crowd->ball[k] == ball) return true;
  return false;
}

/* How many slots hold the number that this one holds: its image, too, where it has one. */
static size_t copies(const struct em_places *p, const uint32_t *slot, uint16_t x) {
  return p->image[x] != 0 && slot[p->image[x]] == *slot ? 2 : 1;
}

/* Every ball is in its cell, and nothing else is anywhere but images beside the ends of tiles.
 */
static bool is_valid(const struct em_world *w) {
  const struct em_places *p = w->places;
  size_t sum = 0, held = 0;
  for (size_t k = 0; k < p->cells * p->room; k++)
    held += p->slot[k] != EM_SLOTS_EMPTY;
  for (uint32_t i = 0; i < p->count; i++) {
    const uint16_t *at = p->plan[i].cell;
    const uint32_t *slot = em_blocks_slot(p, at), *last = slot + p->room - 1;
    const uint32_t k = em_blocks_slot_of(p, slot, i);
    if (k < p->room) {
      sum += copies(p, slot + k, at[0]);
    } else {
      if (!in_crowd(p, *last, i)) return false;
      if (p->crowd[*last & ~EM_SLOTS_CROWD].ball[0] == i) sum += copies(p, last, at[0]);
    }
  }
  return sum == held;
}

const struct em_partition_kind em_partition_cells = {
    .name = "cells",
    .make = make,
    .free = free_places,
    .candidates = candidates,
    .lasting = true,
    .moved = moved,
    .cross = cross,
    .renew = renew,
    .fetch = fetch,
    .bytes = bytes,
    .is_valid = is_valid,
};
