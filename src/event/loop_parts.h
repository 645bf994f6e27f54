/* What all variants of the loop share: lists and cells, periodic images, bookkeeping, order. */
#ifndef EVENTMILL_LOOP_PARTS_H
#define EVENTMILL_LOOP_PARTS_H

#include <math.h>
#include <string.h>

#include "event/blocks.h"
#include "event/body.h"
#include "event/calendar.h"
#include "event/collapse.h"
#include "event/fetch.h"
#include "event/lanes.h"
#include "event/local_first.h"
#include "event/neighbours.h"
#include "event/partition.h"

struct remedy {
  bool frictionless, elastic;
};

/* --- lists and cells -------------------------------------------------------------------------- */

/* The usual ones are worked on in place, the others by call. */

static inline uint32_t queue_first(struct em_world *w, double *time, uint32_t *rival) {
  return w->calendar ? em_calendar_first(w->queue, time, rival)
                     : w->queue_kind->first(w->queue, time, rival);
}

static inline void queue_set(struct em_world *w, uint32_t i, double time) {
  if (w->calendar)
    em_calendar_set(w->queue, i, time);
  else
    w->queue_kind->set(w->queue, i, time);
}

static inline const struct em_prediction *local_first(const struct em_world *w, uint32_t i) {
  return w->keeps_all ? w->local_kind->first(w->local, i) : em_local_first_get(w->local, i);
}

/* When ball i meets what it meets first, or leaves its place. Always inline: a hundredth of a
 * mill's instructions. */
static inline __attribute__((always_inline)) double local_least(const struct em_world *w,
                                                                uint32_t i) {
  const struct em_prediction *p =
      w->keeps_all ? w->local_kind->first(w->local, i) : &w->plan[i].first;
  return p && p->time < w->plan[i].leave ? p->time : w->plan[i].leave;
}

static inline bool local_add(struct em_world *w, uint32_t i, const struct em_prediction *p) {
  return w->keeps_all ? w->local_kind->add(w->local, i, p) : em_local_first_add(w->local, i, p);
}

static inline bool is_stopped(const struct em_world *w) {
  return w->stop && *w->stop;
}

struct candidates {
  const uint32_t *id;
  uint32_t count;
};

/* Asks memory for candidates, eight at a time, with what stands behind the last of them: a gain
 * of 1.02. `close`: they are read within this event. Always inline: see em_blocks_fetch. */
static inline __attribute__((always_inline)) void
fetch_bodies(const struct em_world *w, const struct candidates *c, bool close) {
  for (uint32_t k = 0; k < c->count; k += 8)
#pragma GCC unroll 8
    for (uint32_t h = 0; h < 8; h++) {
      const struct em_body *body = &w->body[c->id[k + h]];
      if (close)
        em_fetch_close(body);
      else
        em_fetch(body);
    }
}

/* Those of ball i. `place`: how many of another ball, and what is behind them, are to be kept. */
static inline struct candidates candidates_of(struct em_world *w, uint32_t i, uint32_t place) {
  if (w->lists) {
    const struct em_list *l = &w->lists->of[i].list;
    return (struct candidates){w->lists->pool + l->at, l->count};
  }
  struct candidates c;
  c.id = w->cells ? em_blocks_candidates(w, i, place, &c.count)
                  : w->partition_kind->candidates(w, i, &c.count);
  return c;
}

/* The same before a prediction is asked for. */
static inline struct candidates candidates_soon(struct em_world *w, uint32_t i, uint32_t place) {
  const struct candidates c = candidates_of(w, i, place);
  if (w->fetches_close) fetch_bodies(w, &c, true);
  return c;
}

/* Those of two balls that are predicted together. Always inline: see collide_pair. */
static inline __attribute__((always_inline)) void candidates_of_two(struct em_world *w, uint32_t i,
                                                                    uint32_t j,
                                                                    struct candidates *of_i,
                                                                    struct candidates *of_j) {
  *of_i = candidates_soon(w, i, 0);
  *of_j = candidates_soon(w, j, of_i->count + 8);
}

/* Does a prediction of ball i hold, or has its partner had a contact since? */
static inline bool holds(const struct em_world *w, uint32_t i, const struct em_prediction *p) {
  const bool ball = p->partner < EM_SURFACE;
  return !ball | (w->plan[ball ? p->partner : i].contact <= p->made);
}

/* Does ball i leave its place before it meets anything, where only the earliest is kept? */
static inline bool leaves_first(const struct em_world *w, uint32_t i) {
  return w->plan[i].leave <= w->plan[i].first.time;
}

/* --- periodic images -------------------------------------------------------------------------- */

static inline vd image_shift(vd d, double period, double per_period) {
  return period * vd_nearest(d * per_period);
}

/* --- bookkeeping ------------------------------------------------------------------------------ */

static inline struct em_vec centre(const struct em_body *b) {
  return (struct em_vec){b->x, b->y, b->z};
}

static inline struct em_vec velocity(const struct em_body *b) {
  return (struct em_vec){b->vx, b->vy, b->vz};
}

static inline double absolute(const struct em_world *w, double t) {
  return em_body_absolute(w, t);
}

static inline void mark(struct em_world *w, uint32_t i, uint32_t partner, uint32_t streak) {
  struct em_plan *plan = &w->plan[i];
  plan->contact = w->contacts;
  plan->last = partner;
  plan->streak = streak;
}

_Static_assert(EM_TALLY_PER_OCTAVE == 1 << 6,
               "an octave's bins are told by 6 bits of the fraction");

/* The bin of em_tally.vn, from the leading bits of the number itself. */
static inline uint32_t vn_bin(double vn) {
  int64_t bits;
  memcpy(&bits, &vn, sizeof bits);
  const int64_t bin = (bits >> 46) - ((int64_t)(EM_TALLY_LOWEST + 1023) << 6);
  return bin < 0 ? 0 : bin >= EM_TALLY_BINS ? EM_TALLY_BINS - 1 : (uint32_t)bin;
}

static inline void note(struct em_world *w, enum em_class cls, double m, double vn, double lost) {
  w->tally.collisions[cls]++;
  w->tally.lost[cls] += lost;
  w->tally.collision_energy[cls] += 0.5 * m * vn * vn;
  w->tally.vn[cls][vn_bin(vn)]++;
}

static inline void note_blade(struct em_world *w, uint32_t code, struct em_vec place,
                              struct em_vec impulse, double work) {
  const uint32_t k = code - EM_SURFACE - EM_WALLS;
  const struct em_blade *blade = &w->blade[k].blade;
  const struct em_vec arm = em_vec_sub(place, blade->centre);
  w->blade_tally[k].work += work;
  w->blade_tally[k].angular_impulse += em_vec_dot(em_vec_cross(arm, impulse), blade->axis);
  w->blade_tally[k].contacts++;
}

static inline void tell(const struct em_world *w, const struct em_contact *contact) {
  for (size_t k = 0; k < w->observers; k++)
    if (w->observer[k].contact) w->observer[k].contact(w->observer[k].self, contact);
}

static inline enum em_status no_memory(struct em_error *err) {
  return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the event lists");
}

/* --- order ------------------------------------------------------------------------------------ */

/* Is the event of ball i at t a contact that holds? Else it leaves its place, or is stale. */
static inline bool is_real(const struct em_world *w, uint32_t i, double t) {
  if (w->plan[i].leave <= t) return false;
  return holds(w, i, local_first(w, i));
}

/* Is the event of ball i that of its meeting with ball j? */
static inline bool meets(const struct em_world *w, uint32_t i, uint32_t j) {
  const struct em_prediction *p = local_first(w, i);
  return p && p->partner == j;
}

/* Are the events of both balls their meeting? Ball j may be to meet a third one at the same time,
 * which need not know of it: whoever predicts tells nobody. */
static inline bool meet(const struct em_world *w, uint32_t i, uint32_t j) {
  return meets(w, i, j) && meets(w, j, i);
}

#endif
