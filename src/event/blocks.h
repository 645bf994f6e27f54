/* Cells: blocks a little wider than the largest ball. Balls that touch are in the same or in
 * adjacent cells, so that a ball's candidates are the balls of 27 cells, however many there are.
 *
 * Every cell has room for a few balls, two as a rule, side by side along x: the cells to the left,
 * here and to the right are one row of slots in one cache line, and nine such rows are looked
 * through by vectors. Of more than these few the last slot names a crowd, where the others are; if
 * there are too many crowds, all cells are given more room. What the loop asks of cells stands
 * here, to be worked on in place; the rest is in partition_cells.c. */
#ifndef EVENTMILL_EVENT_BLOCKS_H
#define EVENTMILL_EVENT_BLOCKS_H

#include <math.h>
#include <string.h>

#include "event/fetch.h"
#include "event/partition.h"
#include "event/slots.h"
#include "event/span.h"
#include "event/vectors.h"

enum {
  EM_BLOCKS_ROOM = 2,    /* least slots of a cell */
  EM_BLOCKS_CROWD = 7,   /* balls of a crowd */
  EM_BLOCKS_BEYOND = 16, /* places written behind candidates */
  EM_BLOCKS_MANY = 32,   /* balls that may move on together */
  EM_BLOCKS_STAYS = 6    /* the leave time is not that of an exit */
};

/* How far it is, in slots, from a cell to the one below and to the one above along an axis. */
struct em_blocks_pitch {
  ptrdiff_t to[2];
};

/* One axis. Cells 0 and n + 1 are those beyond the ends: round the period, or empty. */
struct em_blocks_axis {
  int n;
  double low, edge, period; /* m, m, m; 0 where not periodic, and where there is one cell */
  ptrdiff_t *line;          /* what cell k adds to the number of a cell's first slot */
  struct em_blocks_pitch *pitch;
  double *border; /* lower border of cell k; far away at closed ends */
};

/* The balls that share the last slot of a cell. */
struct em_blocks_crowd {
  uint32_t count, ball[EM_BLOCKS_CROWD]; /* of a free one, the first: the next free one */
};

struct em_places {
  v4d period, per_period; /* m, 1/m: those of the axes */
  v4d gravity, pull;      /* m/s²; what it is along each axis */
  v4l turned;             /* where it pulls upwards */
  uint32_t count;
  /* Of each ball: its cell along each axis, counted from 1, and the side by which it leaves, twice
   * the axis, and one more for the upper side. */
  struct em_plan *plan;
  struct em_blocks_axis axis[3];
  ptrdiff_t *image; /* slots to the image of a cell that is x along its row; 0 where it has none:
                     * see set_row in partition_cells.c */
  size_t cells;
  uint32_t room, room_bits; /* slots of a cell: 1 << room_bits */
  uint32_t *slot;
  struct em_blocks_crowd *crowd;
  uint32_t crowds, spare; /* how many there may be; the first free one, `crowds`: none */
  uint32_t *near;         /* surfaces near each cell; NULL where there are none */
  double slack;           /* m */
  double room_m;          /* m, of the sphere in which a ball stays too; INFINITY: none is needed */
  struct em_vec *centre;
  uint32_t *found;  /* scratch: candidates, of up to EM_BLOCKS_MANY balls that move on, */
  uint32_t *finder; /* and whose they are */
};

/* Doubles the room of every cell, and puts all balls into their cells; false: no memory. */
bool em_partition_cells_widen(struct em_places *places);
/* Puts a ball into the crowd of a full cell, whose slots these are, or takes it out; false: there
 * is no room. */
bool em_partition_cells_join(struct em_places *places, uint32_t *slot, uint32_t ball);
void em_partition_cells_part(struct em_places *places, uint32_t *slot, uint32_t ball);
/* Exchanges the crowds among candidates for their balls, but ball `self`, and returns the end. */
uint32_t *em_partition_cells_disperse(const struct em_places *places, uint32_t self,
                                      uint32_t *candidate, uint32_t *end);

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

/* Sets the leave time of ball i, which is at a place with a speed at the time `from`, and its exit.
 * The last lane of the speed is 0. */
static inline void em_blocks_leave(struct em_world *w, uint32_t i, double from, v4d place,
                                   v4d speed, bool falls, bool periodic) {
  struct em_places *p = w->places;
  struct em_plan *here = &p->plan[i];
  const double *bx = p->axis[0].border + here->cell[0], *by = p->axis[1].border + here->cell[1];
  const double *bz = p->axis[2].border + here->cell[2];
  const v4d low = {bx[0], by[0], bz[0], 0.0}, high = {bx[1], by[1], bz[1], 0.0};
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
  em_blocks_leave(w, i, b->t, (v4d){b->x, b->y, b->z, 0.0}, (v4d){b->vx, b->vy, b->vz, 0.0}, falls,
                  periodic);
}

/* --- slots ------------------------------------------------------------------------------------ */

/* Puts a number in a slot of a cell that is x along its row, and of its image: which cells have one
 * cannot be foretold, so that the others write twice. */
static inline void em_blocks_put(const struct em_places *p, uint32_t *slot, uint16_t x,
                                 uint32_t number) {
  slot[0] = number;
  slot[p->image[x]] = number;
}

/* In which slot of a cell a number stands; `room`: in none. */
static inline uint32_t em_blocks_slot_of(const struct em_places *p, const uint32_t *slot,
                                         uint32_t number) {
  const uint32_t soon = slot[0] != number;
  if (__builtin_expect(slot[soon] == number, 1)) return soon;
  uint32_t k = EM_BLOCKS_ROOM;
  while (k < p->room && slot[k] != number)
    k++;
  return k;
}

/* Into its cell, the one with this number; false: cells have not enough room. */
static inline bool em_blocks_enter(struct em_places *p, uint32_t i, ptrdiff_t number) {
  uint32_t *slot = p->slot + number;
  const uint32_t k = em_blocks_slot_of(p, slot, EM_SLOTS_EMPTY);
  if (__builtin_expect(k == p->room, 0)) return em_partition_cells_join(p, slot, i);
  em_blocks_put(p, slot + k, p->plan[i].cell[0], i);
  return true;
}

static inline void em_blocks_quit(struct em_places *p, uint32_t i, ptrdiff_t number) {
  uint32_t *slot = p->slot + number;
  const uint32_t k = em_blocks_slot_of(p, slot, i);
  if (__builtin_expect(k < p->room, 1))
    em_blocks_put(p, slot + k, p->plan[i].cell[0], EM_SLOTS_EMPTY);
  else
    em_partition_cells_part(p, slot, i);
}

/* The end of candidates that begin at `from`, taken out of slots which joined are `seen`; behind it
 * stand any balls. */
static inline uint32_t *em_blocks_end(const struct em_places *p, uint32_t self, em_slots seen,
                                      uint32_t *from, uint32_t *end) {
  if (__builtin_expect(em_slots_crowded(seen), 0))
    end = em_partition_cells_disperse(p, self, from, end);
  memset(end, 0, 8 * sizeof *end);
  return end;
}

/* Nine places side by side along two axes; the one at `slot` is in their midst. */
struct em_blocks_slab {
  const uint32_t *slot;
  struct em_blocks_pitch u, v;
};

/* The nine rows along x around the cell `at`, each at the cell that is as far along it. */
static inline struct em_blocks_slab em_blocks_rows(const struct em_places *p,
                                                   const uint16_t at[3]) {
  return (struct em_blocks_slab){em_blocks_slot(p, at), p->axis[1].pitch[at[1]],
                                 p->axis[2].pitch[at[2]]};
}

/* The nine cells that are new to a ball that has entered the cell `at` by the side `exit`. */
static inline struct em_blocks_slab em_blocks_beyond(const struct em_places *p,
                                                     const uint16_t at[3], unsigned exit) {
  const unsigned a = exit / 2, u = a == 0, v = 2 - (a == 2);
  const struct em_blocks_pitch *pitch = &p->axis[a].pitch[at[a]];
  return (struct em_blocks_slab){
      em_blocks_slot(p, at) + pitch->to[exit & 1],
      p->axis[u].pitch[at[u]],
      p->axis[v].pitch[at[v]],
  };
}

/* To the one below (k = 0), to itself (1), to the one above (2). */
static inline ptrdiff_t em_blocks_to(struct em_blocks_pitch pitch, int k) {
  return k == 1 ? 0 : pitch.to[k / 2];
}

static inline const uint32_t *em_blocks_ninth(const struct em_blocks_slab *s, int k) {
  return s->slot + em_blocks_to(s->u, k % 3) + em_blocks_to(s->v, k / 3);
}

/* Appends the balls of nine rows, but ball i, and behind their end, which it returns, any balls.
 * The room of a cell, where it is known, spares branches; of rows of twelve slots no more than
 * these are read, for in large systems the others would be waited for. */
static inline __attribute__((always_inline)) uint32_t *
em_blocks_look(const struct em_places *p, const struct em_blocks_slab *rows, uint32_t room,
               uint32_t i, uint32_t *end) {
  uint32_t *const from = end;
  em_slots seen = em_slots_all(0);
  for (uint32_t s = 0, n = 3 * room; s < n; s += 8) {
    const unsigned bits = n - s < 8 ? (1u << (n - s)) - 1u : 255u;
#pragma GCC unroll 9
    for (int k = 0; k < 9; k++) {
      const uint32_t *here = em_blocks_ninth(rows, k) - room + s;
      const em_slots all = n - s == 4 ? em_slots_four(here) : em_slots_eight(here);
      seen = em_slots_join(seen, all);
      end = em_slots_append(k == 4 ? em_slots_but(all, i) : all, bits, end);
    }
  }
  return em_blocks_end(p, i, seen, from, end);
}

/* Those of the 27 cells around and of that of ball i. */
static inline uint32_t *em_blocks_around(const struct em_places *p, uint32_t i, uint32_t *end) {
  const struct em_blocks_slab rows = em_blocks_rows(p, p->plan[i].cell);
  return p->room == EM_BLOCKS_ROOM ? em_blocks_look(p, &rows, EM_BLOCKS_ROOM, i, end)
                                   : em_blocks_look(p, &rows, p->room, i, end);
}

/* Those of nine cells, of which none is that of ball i. */
static inline uint32_t *em_blocks_nine(const struct em_places *p, const struct em_blocks_slab *s,
                                       uint32_t i, uint32_t *end) {
  uint32_t *const from = end;
  em_slots seen = em_slots_all(0);
  if (p->room == EM_BLOCKS_ROOM) {
#pragma GCC unroll 3
    for (int k = 0; k < 9; k += 4) {
      const em_slots all = k < 8
                               ? em_slots_twos(em_blocks_ninth(s, k), em_blocks_ninth(s, k + 1),
                                               em_blocks_ninth(s, k + 2), em_blocks_ninth(s, k + 3))
                               : em_slots_two(em_blocks_ninth(s, k));
      seen = em_slots_join(seen, all);
      end = em_slots_append(all, k < 8 ? 255u : 3u, end);
    }
    return em_blocks_end(p, i, seen, from, end);
  }
  for (uint32_t h = 0; h < p->room; h += 4)
#pragma GCC unroll 9
    for (int k = 0; k < 9; k++) {
      const em_slots all = em_slots_four(em_blocks_ninth(s, k) + h);
      seen = em_slots_join(seen, all);
      end = em_slots_append(all, 15u, end);
    }
  return em_blocks_end(p, i, seen, from, end);
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

/* --- see partition.h -------------------------------------------------------------------------- */

/* The scratch keeps the first `place` of what was found before. */
static inline const uint32_t *em_blocks_candidates(struct em_world *w, uint32_t i, uint32_t place,
                                                   uint32_t *count) {
  const struct em_places *p = w->places;
  uint32_t *const from = p->found + place;
  *count = (uint32_t)(em_blocks_around(p, i, from) - from);
  return from;
}

/* Ball i reaches the end of its cell at the time `now`, or will: puts it into the next. One that
 * turns right at the border would go to and fro, if it fell back in less time than can be told.
 * False: no memory. */
static inline bool em_blocks_step(struct em_world *w, uint32_t i, double now, bool falls,
                                  bool periodic) {
  struct em_places *p = w->places;
  struct em_plan *here = &p->plan[i];
  const unsigned back = here->exit ^ 1u;
  if (here->exit != EM_BLOCKS_STAYS) {
    const unsigned a = here->exit / 2;
    const ptrdiff_t *line = p->axis[a].line, number = em_blocks_number(p, here->cell);
    const uint16_t from = here->cell[a], to = em_blocks_turn(p, here, a);
    const ptrdiff_t next = number + line[to] - line[from];
    if (p->near) here->near = *em_blocks_near(p, next);
    em_blocks_quit(p, i, number);
    here->cell[a] = to;
    if (!em_blocks_enter(p, i, next) && !em_partition_cells_widen(p)) return false;
  }
  const struct em_body *b = &w->body[i];
  const double dt = now - b->t;
  v4d speed = v4d_three(&b->vx), place = *(const v4d *)&b->x + speed * dt;
  if (falls) place = place + p->gravity * (0.5 * dt * dt), speed = speed + p->gravity * dt;
  if (p->centre) p->centre[i] = (struct em_vec){place[0], place[1], place[2]};
  em_blocks_leave(w, i, now, place, speed, falls, periodic);
  if (falls && __builtin_expect((here->leave <= now) & (here->exit == back), 0))
    here->leave = nextafter(now, INFINITY);
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
      em_fetch(em_blocks_ninth(&s, k));
    return;
  }
  const struct em_blocks_slab rows = em_blocks_rows(p, here->cell);
  for (int k = 0; k < 9; k++) {
    const uint32_t *row = em_blocks_ninth(&rows, k);
    em_fetch(row - p->room);
    if (p->room > EM_BLOCKS_ROOM) em_fetch(row + 2 * p->room - 1);
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
