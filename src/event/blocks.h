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

#include "event/fetch.h"
#include "event/pack.h"
#include "event/partition.h"
#include "event/span.h"
#include "event/vectors.h"

#define EM_BLOCKS_EMPTY UINT32_MAX /* what a slot without a ball holds */

enum {
  EM_BLOCKS_ROOM = 4,    /* least slots of a cell */
  EM_BLOCKS_MORE = 8,    /* balls that their cells may have no room for, before all are widened */
  EM_BLOCKS_BEYOND = 16, /* places written behind candidates */
  EM_BLOCKS_MANY = 32,   /* balls that may move on together */
  EM_BLOCKS_STAYS = 6    /* the leave time is not that of an exit */
};

/* One axis. Cells 0 and n + 1 are those beyond the ends: round the period, or empty. Along x, where
 * rows are, they have slots of their own, which hold the same balls. */
struct em_blocks_axis {
  int n;
  double low, edge, period; /* m, m, m; 0 where not periodic, and where there is one cell */
  ptrdiff_t *line;          /* what cell k adds to the number of a cell's first slot */
  double *border;           /* lower border of cell k; far away at closed ends */
};

struct em_places {
  v4d period, per_period; /* m, 1/m: those of the axes */
  v4d pull;               /* m/s², what gravity is along each axis */
  v4l turned;             /* where it pulls upwards */
  uint32_t count;
  /* Of each ball: its cell along each axis, counted from 1, and the side by which it leaves, twice
   * the axis, and one more for the upper side. */
  struct em_plan *plan;
  struct em_blocks_axis axis[3];
  size_t cells;
  uint32_t room, room_bits; /* slots of a cell: 1 << room_bits */
  uint32_t *slot;
  uint32_t more[EM_BLOCKS_MORE], more_count; /* balls without a slot: candidates of all */
  uint32_t *near; /* surfaces near each cell; NULL where there are none */
  double slack;   /* m */
  double room_m;  /* m, of the sphere in which a ball stays too; INFINITY: none is needed */
  struct em_vec *centre;
  uint32_t *found;  /* scratch: candidates, of up to EM_BLOCKS_MANY balls that move on, */
  uint32_t *finder; /* and whose they are */
};

/* Doubles the room of every cell; false: no memory. */
bool em_partition_cells_widen(struct em_places *places);
/* Balls that their cells have no room for: appends them, but ball `self`, and returns the end;
 * takes one out. */
uint32_t *em_partition_cells_more(const struct em_places *places, uint32_t self, uint32_t *end);
void em_partition_cells_no_more(struct em_places *places, uint32_t ball);

/* The number of a cell's first slot. */
static inline ptrdiff_t em_blocks_number(const struct em_places *p, const uint16_t at[3]) {
  return p->axis[0].line[at[0]] + p->axis[1].line[at[1]] + p->axis[2].line[at[2]];
}

static inline uint32_t *em_blocks_slot(const struct em_places *p, const uint16_t at[3]) {
  return p->slot + em_blocks_number(p, at);
}

/* What surfaces are near a cell, where there are any at all. */
static inline uint32_t *em_blocks_near(const struct em_places *p, ptrdiff_t number) {
  return p->near + ((size_t)number >> p->room_bits);
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
  if (periodic) place = place - p->period * v4d_nearest((place - low) * p->per_period);
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
    const double most = em_lesser(cap, em_span_limit(w, from));
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

/* Puts a ball's number in a slot of a cell that is x along its row, and of its image beyond an end
 * of the row: which cells have one cannot be foretold, so that the others write twice. */
static inline void em_blocks_put(const struct em_places *p, uint32_t *slot, uint16_t x,
                                 uint32_t number, bool periodic) {
  const struct em_blocks_axis *row = &p->axis[0];
  const int turn = periodic && row->period > 0.0 ? (x == 1) - (x == row->n) : 0;
  const ptrdiff_t image = (ptrdiff_t)turn * row->n * (ptrdiff_t)p->room;
  slot[0] = number;
  if (periodic) slot[image] = number;
}

/* In which slot of a cell a number stands; `room`: in none. */
static inline uint32_t em_blocks_slot_of(const struct em_places *p, const uint32_t *slot,
                                         uint32_t number) {
  for (uint32_t k = 0; k < p->room; k += EM_BLOCKS_ROOM) {
    const unsigned here = v4i_bits(*(const v4i *)(slot + k) == (int)number);
    if (here) return k + (uint32_t)__builtin_ctz(here);
  }
  return p->room;
}

/* Into its cell, the one with this number. */
static inline bool em_blocks_enter(struct em_places *p, uint32_t i, ptrdiff_t number,
                                   bool periodic) {
  const uint16_t *at = p->plan[i].cell;
  uint32_t *slot = p->slot + number;
  const uint32_t k = em_blocks_slot_of(p, slot, EM_BLOCKS_EMPTY);
  if (__builtin_expect(k == p->room, 0)) {
    if (p->more_count < EM_BLOCKS_MORE) {
      p->more[p->more_count++] = i;
      return true;
    }
    if (!em_partition_cells_widen(p)) return false;
    slot = em_blocks_slot(p, at);
  }
  em_blocks_put(p, slot + k, at[0], i, periodic);
  return true;
}

static inline void em_blocks_quit(struct em_places *p, uint32_t i, ptrdiff_t number,
                                  bool periodic) {
  uint32_t *slot = p->slot + number;
  const uint32_t k = em_blocks_slot_of(p, slot, i);
  if (__builtin_expect(k < p->room, 1)) {
    em_blocks_put(p, slot + k, p->plan[i].cell[0], EM_BLOCKS_EMPTY, periodic);
    return;
  }
  em_partition_cells_no_more(p, i);
}

/* Twelve slots, four each at three places (em_blocks_three) or twelve at one (em_blocks_row), of
 * which em_blocks_append appends the balls; it writes EM_BLOCKS_BEYOND places. A ball's number is
 * not negative, as a signed one, EM_BLOCKS_EMPTY is. */
#if defined(__AVX512F__)

typedef __m512i em_blocks_twelve;

static inline em_blocks_twelve em_blocks_three(const uint32_t *s0, const uint32_t *s1,
                                               const uint32_t *s2) {
  const __m128i a = _mm_loadu_si128((const __m128i *)s0);
  const __m128i b = _mm_loadu_si128((const __m128i *)s1);
  const __m128i c = _mm_loadu_si128((const __m128i *)s2);
  return _mm512_inserti64x4(_mm512_castsi256_si512(_mm256_set_m128i(b, a)),
                            _mm256_zextsi128_si256(c), 1);
}

/* Twelve and no more: in large systems further slots would be waited for. */
static inline em_blocks_twelve em_blocks_row(const uint32_t *slot) {
  const __m256i most = _mm256_loadu_si256((const __m256i *)slot);
  const __m256i rest = _mm256_zextsi128_si256(_mm_loadu_si128((const __m128i *)(slot + 8)));
  return _mm512_inserti64x4(_mm512_castsi256_si512(most), rest, 1);
}

/* All but ball `self`. */
static inline em_blocks_twelve em_blocks_but(em_blocks_twelve all, uint32_t self) {
  const __mmask16 here = _mm512_cmpeq_epi32_mask(all, _mm512_set1_epi32((int)self));
  return _mm512_mask_set1_epi32(all, here, -1);
}

static inline uint32_t *em_blocks_append(em_blocks_twelve all, uint32_t *end) {
  const __mmask16 in = _mm512_mask_cmpneq_epi32_mask(0x0FFF, all, _mm512_set1_epi32(-1));
  _mm512_storeu_si512(end, _mm512_maskz_compress_epi32(in, all));
  return end + __builtin_popcount(in);
}

#elif defined(__AVX2__)

typedef struct {
  __m256i eight;
  __m128i four;
} em_blocks_twelve;

static inline em_blocks_twelve em_blocks_three(const uint32_t *s0, const uint32_t *s1,
                                               const uint32_t *s2) {
  const __m128i a = _mm_loadu_si128((const __m128i *)s0);
  const __m128i b = _mm_loadu_si128((const __m128i *)s1);
  return (em_blocks_twelve){_mm256_set_m128i(b, a), _mm_loadu_si128((const __m128i *)s2)};
}

static inline em_blocks_twelve em_blocks_row(const uint32_t *slot) {
  return (em_blocks_twelve){_mm256_loadu_si256((const __m256i *)slot),
                            _mm_loadu_si128((const __m128i *)(slot + 8))};
}

static inline em_blocks_twelve em_blocks_but(em_blocks_twelve all, uint32_t self) {
  const __m256i me = _mm256_set1_epi32((int)self);
  all.eight = _mm256_or_si256(all.eight, _mm256_cmpeq_epi32(all.eight, me));
  all.four = _mm_or_si128(all.four, _mm_cmpeq_epi32(all.four, _mm256_castsi256_si128(me)));
  return all;
}

static inline uint32_t *em_blocks_append(em_blocks_twelve all, uint32_t *end) {
  const unsigned some = ~(unsigned)_mm256_movemask_ps((__m256)all.eight) & 255u;
  const unsigned more = ~(unsigned)_mm_movemask_ps((__m128)all.four) & 15u;
  _mm256_storeu_si256((__m256i *)end, pack(all.eight, some));
  end += __builtin_popcount(some);
  _mm_storeu_si128((__m128i *)end, pack_four(all.four, more));
  return end + __builtin_popcount(more);
}

#else

typedef struct {
  uint32_t slot[12];
} em_blocks_twelve;

static inline em_blocks_twelve em_blocks_three(const uint32_t *s0, const uint32_t *s1,
                                               const uint32_t *s2) {
  em_blocks_twelve all;
  memcpy(all.slot, s0, 4 * sizeof *s0);
  memcpy(all.slot + 4, s1, 4 * sizeof *s1);
  memcpy(all.slot + 8, s2, 4 * sizeof *s2);
  return all;
}

static inline em_blocks_twelve em_blocks_row(const uint32_t *slot) {
  return em_blocks_three(slot, slot + 4, slot + 8);
}

static inline em_blocks_twelve em_blocks_but(em_blocks_twelve all, uint32_t self) {
  for (int k = 0; k < 12; k++)
    all.slot[k] |= all.slot[k] == self ? EM_BLOCKS_EMPTY : 0;
  return all;
}

static inline uint32_t *em_blocks_append(em_blocks_twelve all, uint32_t *end) {
  for (int k = 0; k < 12; k++) {
    *end = all.slot[k];
    end += all.slot[k] != EM_BLOCKS_EMPTY;
  }
  return end;
}

#endif

/* Appends the balls without a slot, and behind their end, which it returns, any balls. */
static inline uint32_t *em_blocks_end(const struct em_places *p, uint32_t self, uint32_t *end) {
  if (__builtin_expect(p->more_count, 0)) end = em_partition_cells_more(p, self, end);
  memset(end, 0, 8 * sizeof *end);
  return end;
}

/* How far it is, in slots, from a cell to the one below, to itself, and to the one above along an
 * axis. */
static inline void em_blocks_pitch(const struct em_places *p, int axis, const uint16_t at[3],
                                   ptrdiff_t pitch[3]) {
  const ptrdiff_t *line = p->axis[axis].line + at[axis];
  for (int k = 0; k < 3; k++)
    pitch[k] = line[k - 1] - line[0];
}

/* Appends the balls of the 27 cells around and of that of ball i, but i itself, and behind their
 * end, which it returns, any balls. Rows along x lie side by side. */
static inline uint32_t *em_blocks_around(const struct em_places *p, uint32_t i, uint32_t *end) {
  const uint16_t *at = p->plan[i].cell;
  const uint32_t *slot = em_blocks_slot(p, at) - p->room;
  ptrdiff_t y[3], z[3];
  em_blocks_pitch(p, 1, at, y);
  em_blocks_pitch(p, 2, at, z);
  for (uint32_t s = 0; s < 3 * p->room;
       s += 12) /* once, as a rule: what is below has no branches */
#pragma GCC unroll 9
    for (int k = 0; k < 9; k++) {
      const em_blocks_twelve row = em_blocks_row(slot + z[k / 3] + y[k % 3] + s);
      end = em_blocks_append(k == 4 ? em_blocks_but(row, i) : row, end);
    }
  return em_blocks_end(p, i, end);
}

/* The cell along an axis that ball i enters when it leaves its own. */
static inline uint16_t em_blocks_turn(const struct em_places *p, const struct em_plan *here,
                                      unsigned axis) {
  const int n = p->axis[axis].n, to = here->cell[axis] + 2 * (here->exit & 1) - 1;
  return (uint16_t)(to == 0 ? n : to > n ? 1 : to);
}

/* The same along all. */
static inline void em_blocks_next(const struct em_places *p, uint32_t i, uint16_t next[3]) {
  const struct em_plan *here = &p->plan[i];
  const unsigned a = here->exit / 2;
  const uint16_t turned = em_blocks_turn(p, here, a);
  for (unsigned k = 0; k < 3; k++)
    next[k] = k == a ? turned : here->cell[k];
}

/* Nine cells side by side along two axes; the one at `slot` is in their midst. */
struct em_blocks_slab {
  const uint32_t *slot;
  ptrdiff_t u[3], v[3];
};

/* Those that are new to a ball that has entered the cell `at` by the side `exit`. */
static inline struct em_blocks_slab em_blocks_beyond(const struct em_places *p,
                                                     const uint16_t at[3], unsigned exit) {
  const int a = (int)exit / 2;
  ptrdiff_t across[3];
  em_blocks_pitch(p, a, at, across);
  struct em_blocks_slab s = {.slot = em_blocks_slot(p, at) + across[exit & 1 ? 2 : 0]};
  em_blocks_pitch(p, a == 0, at, s.u);
  em_blocks_pitch(p, 2 - (a == 2), at, s.v);
  return s;
}

/* Appends their balls, but ball i, and any balls behind them. */
static inline uint32_t *em_blocks_nine(const struct em_places *p, const struct em_blocks_slab *s,
                                       uint32_t i, uint32_t *end) {
  for (uint32_t h = 0; h < p->room; h += EM_BLOCKS_ROOM)
#pragma GCC unroll 3
    for (int k = 0; k < 3; k++) {
      const uint32_t *here = s->slot + s->v[k] + h;
      end = em_blocks_append(em_blocks_three(here + s->u[0], here, here + s->u[2]), end);
    }
  return em_blocks_end(p, i, end);
}

/* --- see partition.h -------------------------------------------------------------------------- */

/* The scratch keeps the first `place` of what was found before. */
static inline const uint32_t *em_blocks_candidates(struct em_world *w, uint32_t i, uint32_t place,
                                                   uint32_t *count) {
  const struct em_places *p = w->places;
  uint32_t *const from = p->found + place;
  *count = (uint32_t)(em_blocks_around(p, i, from) - from);
  return from;
}

/* Ball i reaches the end of its cell at the time `now`, or will: puts it into the next. False: no
 * memory. */
static inline bool em_blocks_step(struct em_world *w, uint32_t i, double now, bool falls,
                                  bool periodic) {
  struct em_places *p = w->places;
  struct em_plan *here = &p->plan[i];
  if (here->exit != EM_BLOCKS_STAYS) {
    const unsigned a = here->exit / 2;
    const ptrdiff_t *line = p->axis[a].line, number = em_blocks_number(p, here->cell);
    const uint16_t from = here->cell[a], to = em_blocks_turn(p, here, a);
    const ptrdiff_t next = number + line[to] - line[from];
    if (p->near) here->near = *em_blocks_near(p, next);
    em_blocks_quit(p, i, number, periodic);
    here->cell[a] = to;
    if (!em_blocks_enter(p, i, next, periodic)) return false;
  }
  const struct em_vec x = em_body_at(w, i, now);
  if (p->centre) p->centre[i] = x;
  em_blocks_leave(w, i, now, x, em_body_velocity(w, i, now), falls, periodic);
  return true;
}

/* Appends the balls that are new to ball i, now that it has left its cell by the side `exit`, and
 * behind their end, which it returns, any balls. */
static inline uint32_t *em_blocks_new(const struct em_places *p, uint32_t i, unsigned exit,
                                      uint32_t *end) {
  if (p->centre) return em_blocks_around(p, i, end);
  if (exit == EM_BLOCKS_STAYS) return end;
  const struct em_blocks_slab s = em_blocks_beyond(p, p->plan[i].cell, exit);
  return em_blocks_nine(p, &s, i, end);
}

static inline const uint32_t *em_blocks_cross(struct em_world *w, uint32_t i, double now,
                                              uint32_t *count, bool falls, bool periodic) {
  const struct em_places *p = w->places;
  const unsigned exit = p->plan[i].exit;
  *count = 1;
  if (!em_blocks_step(w, i, now, falls, periodic)) return NULL;
  *count = (uint32_t)(em_blocks_new(p, i, exit, p->found) - p->found);
  return p->found;
}

/* Asks memory for the slots that will be looked through. Always inline, for a compiler may take a
 * function that does nothing else for one without effect, and leave its calls out. */
static inline __attribute__((always_inline)) void em_blocks_fetch(const struct em_world *w,
                                                                  uint32_t i, bool leaves) {
  const struct em_places *p = w->places;
  const struct em_plan *here = &p->plan[i];
  const uint32_t *slot = em_blocks_slot(p, here->cell);
  if (leaves && here->exit != EM_BLOCKS_STAYS) { /* out of one cell, into the other */
    uint16_t next[3];
    em_blocks_next(p, i, next);
    em_fetch(slot);
    em_fetch(em_blocks_slot(p, next));
    const struct em_blocks_slab s = em_blocks_beyond(p, next, here->exit);
    for (int k = 0; k < 9; k++)
      em_fetch(s.slot + s.u[k % 3] + s.v[k / 3]);
    return;
  }
  ptrdiff_t y[3], z[3];
  em_blocks_pitch(p, 1, here->cell, y);
  em_blocks_pitch(p, 2, here->cell, z);
  for (int k = 0; k < 9; k++) {
    const uint32_t *row = slot + y[k % 3] + z[k / 3];
    em_fetch(row - p->room);
    em_fetch(row + 2 * p->room - 1);
  }
}

/* The balls that will be tested when ball i's event comes up, and behind them any balls. */
static inline const uint32_t *em_blocks_upcoming(struct em_world *w, uint32_t i, bool leaves,
                                                 uint32_t *count) {
  const struct em_places *p = w->places;
  const struct em_plan *here = &p->plan[i];
  if (!leaves || here->exit == EM_BLOCKS_STAYS) return em_blocks_candidates(w, i, 0, count);
  uint16_t next[3];
  em_blocks_next(p, i, next);
  const struct em_blocks_slab s = em_blocks_beyond(p, next, here->exit);
  *count = (uint32_t)(em_blocks_nine(p, &s, i, p->found) - p->found);
  return p->found;
}

#endif
