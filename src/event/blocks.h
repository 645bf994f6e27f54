/* Cells: blocks a little wider than the largest ball. Balls that touch are in the same or in
 * adjacent cells, so that a ball's candidates are the balls of 27 cells, however many there are.
 *
 * Every cell has room for a few balls, side by side along x: the cells to the left, here and to the
 * right are one row of slots, and nine such rows are looked through by vectors. What the loop asks
 * of cells stands here, to be worked on in place; the rest is in partition_cells.c. */
#ifndef EVENTMILL_EVENT_BLOCKS_H
#define EVENTMILL_EVENT_BLOCKS_H

#include <math.h>
#include <string.h>

#include "event/pack.h"
#include "event/partition.h"
#include "event/span.h"
#include "event/vectors.h"

#define EM_BLOCKS_EMPTY UINT32_MAX /* what a slot without a ball holds */

enum {
  EM_BLOCKS_ROOM = 4,    /* least slots of a cell, doubled when one is full */
  EM_BLOCKS_BEYOND = 16, /* slots that may be read behind a row, places written behind candidates */
  EM_BLOCKS_STAYS = 6    /* the leave time is not that of an exit */
};

/* One axis. Cells 0 and n + 1 are those beyond the ends: round the period, or empty. Along x, where
 * rows are, they have slots of their own, which hold the same balls. */
struct em_blocks_axis {
  int n;
  double low, edge, period; /* m, m, m; 0 where not periodic */
  uint32_t *line;           /* what cell k adds to the number of a cell */
  double *border;           /* lower border of cell k; far away at closed ends */
};

struct em_places {
  v4d period, per_period; /* m, 1/m; 0 where not periodic, and along an axis of one cell */
  v4d pull;               /* m/s², what gravity is along each axis */
  v4l turned;             /* where it pulls upwards */
  uint32_t count;
  /* Of each ball: its cell along each axis, counted from 1, and the side by which it leaves, twice
   * the axis, and one more for the upper side. */
  struct em_plan *plan;
  struct em_blocks_axis axis[3];
  int from[3], to[3]; /* cells beside a ball's: 0 … 2, or just 1 where there is one cell */
  size_t cells;
  uint32_t room; /* slots of a cell */
  uint32_t *slot;
  uint32_t *near; /* surfaces near each cell; NULL where there are none */
  double slack;   /* m */
  double room_m;  /* m, of the sphere in which a ball stays too; INFINITY: none is needed */
  struct em_vec *centre;
  uint32_t *found; /* scratch: candidates */
};

/* Doubles the room of every cell; false: no memory. */
bool em_partition_cells_widen(struct em_places *places);

static inline size_t em_blocks_number(const struct em_places *p, const uint16_t at[3]) {
  return (size_t)p->axis[0].line[at[0]] + p->axis[1].line[at[1]] + p->axis[2].line[at[2]];
}

/* --- leaving ---------------------------------------------------------------------------------- */

/* Time until x + v t leaves low … high along each axis; x may be beyond by a rounding. *up: by the
 * upper border. */
static inline v4d em_blocks_straight(v4d x, v4d v, v4d low, v4d high, v4l *up) {
  const v4d zero = v4d_all(0.0);
  *up = v > zero;
  const v4d t = (v4d_choose(*up, high, low) - x) / v;
  return v4d_choose(v == zero, v4d_all(INFINITY), v4d_choose(t > zero, t, zero));
}

/* The same for x + v t + g t²/2. Rising against gravity (u > 0) a ball reaches the border above, if
 * at all, at 2 above / (u + √(u² − 2 g above)); a path that turns at it does not cross it. The one
 * below it reaches at 2 below / (√(u² + 2 g below) − u). */
static inline v4d em_blocks_curved(const struct em_places *p, v4d x, v4d v, v4d low, v4d high,
                                   v4l *up) {
  const v4d zero = v4d_all(0.0), g = p->pull;
  const v4d u = v4d_choose(p->turned, -v, v), to_low = x - low, to_high = high - x;
  v4d above = v4d_choose(p->turned, to_low, to_high),
      below = v4d_choose(p->turned, to_high, to_low);
  above = v4d_choose(above > zero, above, zero);
  below = v4d_choose(below > zero, below, zero);
  const v4d left = u * u - 2.0 * g * above, root = v4d_sqrt(u * u + 2.0 * g * below);
  const v4l mounts = u > zero, over = mounts & (left > zero);
  const v4d way = v4d_choose(over, 2.0 * above, v4d_choose(mounts, u + root, 2.0 * below));
  const v4d rate =
      v4d_choose(over, u + v4d_sqrt(v4d_choose(over, left, zero)), v4d_choose(mounts, g, root - u));
  *up = over ^ p->turned;
  return v4d_choose(rate == zero, v4d_choose(g > zero, zero, v4d_all(INFINITY)), way / rate);
}

/* Sets the leave time of ball i, which is at x with velocity v at the time `from`, and its exit. */
static inline void em_blocks_leave(struct em_world *w, uint32_t i, double from, struct em_vec x,
                                   struct em_vec v, bool falls, bool periodic) {
  struct em_places *p = w->places;
  struct em_plan *here = &p->plan[i];
  const double *bx = p->axis[0].border + here->cell[0], *by = p->axis[1].border + here->cell[1];
  const double *bz = p->axis[2].border + here->cell[2];
  const v4d low = {bx[0], by[0], bz[0], 0.0}, high = {bx[1], by[1], bz[1], 0.0};
  const v4d speed = {v.x, v.y, v.z, 0.0};
  v4d place = {x.x, x.y, x.z, 0.0};
  if (periodic)
    place = place - p->period * (((place - low) * p->per_period + EM_NEAREST) - EM_NEAREST);
  v4l up;
  const v4d all = falls ? em_blocks_curved(p, place, speed, low, high, &up)
                        : em_blocks_straight(place, speed, low, high, &up);
  const v4d stay = v4d_least_of(all);
  const unsigned axis = (unsigned)__builtin_ctz(v4l_bits(all == stay));
  here->exit = (uint16_t)(2 * axis + (v4l_bits(up) >> axis & 1));
  double leave = from + stay[0];
  if (p->centre || w->blade_count) {
    const double cap =
        p->centre ? em_partition_stay(w, i, from, p->centre[i], p->room_m) : INFINITY;
    const double most = fmin(cap, em_span_limit(w, from));
    if (most < leave) here->exit = EM_BLOCKS_STAYS, leave = most;
  }
  w->plan[i].leave = leave;
}

static inline void em_blocks_moved(struct em_world *w, uint32_t i, bool falls, bool periodic) {
  const struct em_body *b = &w->body[i];
  em_blocks_leave(w, i, b->t, (struct em_vec){b->x, b->y, b->z},
                  (struct em_vec){b->vx, b->vy, b->vz}, falls, periodic);
}

/* --- slots ------------------------------------------------------------------------------------ */

/* Puts a number in slot k of a cell, and of its image beyond an end of the row. */
static inline void em_blocks_put(struct em_places *p, const uint16_t at[3], uint32_t k,
                                 uint32_t number) {
  const struct em_blocks_axis *x = &p->axis[0];
  uint32_t *slot = p->slot + em_blocks_number(p, at) * p->room + k;
  *slot = number;
  if (x->period > 0.0 && at[0] == 1) slot[(size_t)x->n * p->room] = number;
  if (x->period > 0.0 && at[0] == x->n) *(slot - (size_t)x->n * p->room) = number;
}

/* In which slot of a cell a number stands; `room`: in none. */
static inline uint32_t em_blocks_slot_of(const struct em_places *p, const uint16_t at[3],
                                         uint32_t number) {
  const uint32_t *slot = p->slot + em_blocks_number(p, at) * p->room;
  for (uint32_t k = 0; k < p->room; k += EM_BLOCKS_ROOM) {
    const unsigned here = v4i_bits(*(const v4i *)(slot + k) == (int)number);
    if (here) return k + (uint32_t)__builtin_ctz(here);
  }
  return p->room;
}

static inline bool em_blocks_enter(struct em_places *p, uint32_t i) {
  const uint16_t *at = p->plan[i].cell;
  const uint32_t k = em_blocks_slot_of(p, at, EM_BLOCKS_EMPTY);
  if (k == p->room && !em_partition_cells_widen(p)) return false;
  em_blocks_put(p, at, k, i);
  return true;
}

static inline void em_blocks_quit(struct em_places *p, uint32_t i) {
  const uint16_t *at = p->plan[i].cell;
  em_blocks_put(p, at, em_blocks_slot_of(p, at, i), EM_BLOCKS_EMPTY);
}

/* Appends the balls in up to 12 slots but ball `self`; writes EM_BLOCKS_BEYOND places. */
static inline uint32_t *em_blocks_append(const uint32_t *slot, uint32_t width, uint32_t self,
                                         uint32_t *end) {
#if defined(__AVX512F__)
  const __mmask16 lanes = (__mmask16)((1u << width) - 1u);
  /* Twelve and no more: in large systems further slots would be waited for. */
  const __m256i most = _mm256_loadu_si256((const __m256i *)slot);
  const __m128i rest = _mm_loadu_si128((const __m128i *)(slot + 8));
  const __m512i all =
      _mm512_inserti64x4(_mm512_castsi256_si512(most), _mm256_zextsi128_si256(rest), 1);
  const __mmask16 some = _mm512_mask_cmpneq_epi32_mask(lanes, all, _mm512_set1_epi32(-1));
  const __mmask16 in = _mm512_mask_cmpneq_epi32_mask(some, all, _mm512_set1_epi32((int)self));
  _mm512_storeu_si512(end, _mm512_maskz_compress_epi32(in, all));
  return end + __builtin_popcount(in);
#elif defined(__AVX2__)
  const __m256i me = _mm256_set1_epi32((int)self), none = _mm256_set1_epi32(-1);
  const unsigned lanes = (1u << width) - 1u;
  for (uint32_t k = 0; k < width; k += 8) {
    const __m256i all = _mm256_loadu_si256((const __m256i *)(slot + k));
    const __m256i out = _mm256_or_si256(_mm256_cmpeq_epi32(all, me), _mm256_cmpeq_epi32(all, none));
    const unsigned in = ~(unsigned)_mm256_movemask_ps((__m256)out) & lanes >> k & 255u;
    _mm256_storeu_si256((__m256i *)end, pack(all, in));
    end += __builtin_popcount(in);
  }
  return end;
#else
  for (uint32_t k = 0; k < width; k++) {
    *end = slot[k];
    end += slot[k] != EM_BLOCKS_EMPTY && slot[k] != self;
  }
  return end;
#endif
}

/* The rows of the cells from[a] … to[a] beside that of ball i (0: one lower, 1: its own, 2: one
 * higher); returns how many. */
static inline uint32_t em_blocks_rows(const struct em_places *p, uint32_t i, const int from[3],
                                      const int to[3], const uint32_t *row[9]) {
  const uint16_t *at = p->plan[i].cell;
  const ptrdiff_t x = (ptrdiff_t)p->axis[0].line[at[0]] + from[0] - 1;
  const uint32_t *y = p->axis[1].line + at[1] - 1, *z = p->axis[2].line + at[2] - 1;
  uint32_t n = 0;
  for (int c = from[2]; c <= to[2]; c++)
    for (int b = from[1]; b <= to[1]; b++)
      row[n++] = p->slot + ((ptrdiff_t)z[c] + y[b] + x) * p->room;
  return n;
}

/* The balls in these cells but ball i go to p->found, and any balls behind them; returns how many.
 */
static inline uint32_t em_blocks_collect(const struct em_places *p, uint32_t i, const int from[3],
                                         const int to[3]) {
  const uint32_t *row[9];
  const uint32_t n = em_blocks_rows(p, i, from, to, row);
  const uint32_t width = (uint32_t)(to[0] - from[0] + 1) * p->room;
  uint32_t *end = p->found;
  for (uint32_t h = 0; h < n; h++)
    for (uint32_t k = 0; k < width; k += 12)
      end = em_blocks_append(row[h] + k, width - k < 12 ? width - k : 12, i, end);
  memset(end, 0, 8 * sizeof *end);
  return (uint32_t)(end - p->found);
}

/* --- see partition.h -------------------------------------------------------------------------- */

static inline const uint32_t *em_blocks_candidates(struct em_world *w, uint32_t i,
                                                   uint32_t *count) {
  const struct em_places *p = w->places;
  *count = em_blocks_collect(p, i, p->from, p->to);
  return p->found;
}

static inline const uint32_t *em_blocks_cross(struct em_world *w, uint32_t i, double now,
                                              uint32_t *count, bool falls, bool periodic) {
  struct em_places *p = w->places;
  struct em_plan *here = &p->plan[i];
  const unsigned exit = here->exit, a = exit / 2;
  *count = 1;
  if (exit != EM_BLOCKS_STAYS) {
    em_blocks_quit(p, i);
    const int n = p->axis[a].n, next = here->cell[a] + (exit & 1 ? 1 : -1);
    here->cell[a] = (uint16_t)(next == 0 ? n : next > n ? 1 : next);
    if (!em_blocks_enter(p, i)) return NULL;
  }
  const struct em_vec x = em_body_at(w, i, now);
  if (p->centre) p->centre[i] = x;
  em_blocks_leave(w, i, now, x, em_body_velocity(w, i, now), falls, periodic);
  if (p->centre) return em_blocks_candidates(w, i, count);
  *count = 0;
  if (exit == EM_BLOCKS_STAYS) return p->found;
  int from[3] = {p->from[0], p->from[1], p->from[2]}, to[3] = {p->to[0], p->to[1], p->to[2]};
  from[a] = to[a] = exit & 1 ? 2 : 0; /* only these cells are new */
  *count = em_blocks_collect(p, i, from, to);
  return p->found;
}

/* The cells beside those that ball i enters when it leaves its own; false: none, or beyond an end
 * of the grid, which is rare. */
static inline bool em_blocks_ahead(const struct em_places *p, uint32_t i, int from[3], int to[3]) {
  const struct em_plan *here = &p->plan[i];
  const unsigned a = here->exit / 2;
  if (here->exit == EM_BLOCKS_STAYS) return false;
  const int next = here->cell[a] + (here->exit & 1 ? 2 : -2);
  memcpy(from, p->from, sizeof p->from);
  memcpy(to, p->to, sizeof p->to);
  from[a] = to[a] = here->exit & 1 ? 3 : -1;
  return next >= 1 && next <= p->axis[a].n;
}

/* Asks memory for the slots that will be looked through. */
static inline void em_blocks_fetch(const struct em_world *w, uint32_t i, bool leaves) {
  const struct em_places *p = w->places;
  int from[3], to[3];
  if (!leaves || !em_blocks_ahead(p, i, from, to)) {
    memcpy(from, p->from, sizeof from);
    memcpy(to, p->to, sizeof to);
  } else { /* out of one cell, into the other */
    const struct em_plan *here = &p->plan[i];
    uint16_t next[3];
    memcpy(next, here->cell, sizeof next);
    next[here->exit / 2] = (uint16_t)(next[here->exit / 2] + (here->exit & 1 ? 1 : -1));
    __builtin_prefetch(p->slot + em_blocks_number(p, here->cell) * p->room);
    __builtin_prefetch(p->slot + em_blocks_number(p, next) * p->room);
  }
  const uint32_t *row[9];
  const uint32_t n = em_blocks_rows(p, i, from, to, row);
  for (uint32_t k = 0; k < n; k++) {
    __builtin_prefetch(row[k]);
    __builtin_prefetch(row[k] + 3 * p->room - 1);
  }
}

/* Asks memory for the balls that will be tested. */
static inline void em_blocks_fetch_balls(struct em_world *w, uint32_t i, bool leaves) {
  const struct em_places *p = w->places;
  int from[3], to[3];
  const bool ahead = leaves && em_blocks_ahead(p, i, from, to);
  const uint32_t n = em_blocks_collect(p, i, ahead ? from : p->from, ahead ? to : p->to);
  for (uint32_t k = 0; k < n; k++) {
    __builtin_prefetch(&w->body[p->found[k]]);
    __builtin_prefetch(&w->counter[p->found[k]]);
  }
}

static inline uint32_t em_blocks_surfaces(const struct em_world *w, uint32_t i) {
  const struct em_places *p = w->places;
  return p->near ? p->near[em_blocks_number(p, p->plan[i].cell)] : 0;
}

#endif
