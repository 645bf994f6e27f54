/* What all variants of the loop share: periodic images, bookkeeping. */
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

/* --- foresight -------------------------------------------------------------------------------- */

enum { FORESEEN = EM_BLOCKS_MANY }; /* balls of a bin */
_Static_assert((int)FORESEEN >= (int)EM_CALENDAR_LARGE, "its earliest ball is among them");

/* Asks memory for all that stands at the number of a ball. */
static inline void fetch_ball(const struct em_world *w, uint32_t i) {
  em_fetch(&w->body[i]);
  em_fetch(&w->plan[i]);
  if (!w->cells) w->partition_kind->fetch(w, i, false, false);
}

/* The balls whose bodies a prediction of ball i will read, or that of its crossing. */
static inline void fetch_candidates(struct em_world *w, uint32_t i, bool leaves) {
  struct candidates c;
  c.id = w->cells ? em_blocks_upcoming(w, i, leaves, &c.count)
                  : w->partition_kind->candidates(w, i, &c.count);
  if (w->cells || !leaves) {
    fetch_bodies(w, &c, false);
    return;
  }
  for (uint32_t k = 0; k < c.count; k++)
    w->partition_kind->fetch(w, c.id[k], false, false);
}

static inline void fetch_place(const struct em_world *w, uint32_t i, bool leaves) {
  if (w->cells)
    em_blocks_fetch(w, i, leaves);
  else
    w->partition_kind->fetch(w, i, true, leaves);
}

/* The calendar knows which balls come next: what stands at their numbers is asked for two bins
 * ahead; what that points to, and what stands at the numbers of those that they will meet, one bin
 * ahead; and the candidates of both when the bin begins. */
static inline void foresee(struct em_world *w) {
  uint32_t ball[FORESEEN], partner[FORESEEN], pairs = 0;
  em_calendar_fetch(w->queue, 4);
  uint32_t n = em_calendar_peek(w->queue, 2, ball, FORESEEN);
  for (uint32_t k = 0; k < n; k++)
    fetch_ball(w, ball[k]);
  n = em_calendar_peek(w->queue, 1, ball, FORESEEN);
  for (uint32_t k = 0; k < n; k++) {
    const struct em_plan *plan = &w->plan[ball[k]];
    if (!(em_calendar_bin(w->queue, plan->due) < w->queue->due_end + 1.0)) continue;
    const bool leaves = leaves_first(w, ball[k]);
    if (!leaves && plan->first.partner < EM_SURFACE) fetch_ball(w, plan->first.partner);
    fetch_place(w, ball[k], leaves);
  }
  n = em_calendar_peek(w->queue, 0, ball, FORESEEN);
  for (uint32_t k = 0; k < n; k++) {
    const struct em_prediction *p = &w->plan[ball[k]].first;
    const bool leaves = leaves_first(w, ball[k]);
    if (!leaves && p->partner < EM_SURFACE && holds(w, ball[k], p)) {
      partner[pairs++] = p->partner;
      fetch_place(w, p->partner, false);
    }
    fetch_candidates(w, ball[k], leaves);
  }
  for (uint32_t k = 0; k < pairs; k++)
    fetch_candidates(w, partner[k], false);
}

/* In systems of medium size it is enough to ask, when a bin begins, for what its n balls and their
 * partners read first, and for the plans of the next bin: a gain of 1.02. */
static inline __attribute__((always_inline)) void fetch_bin(const struct em_world *w,
                                                            const uint32_t *ball, uint32_t n) {
  if (!w->fetches_close) return;
  em_calendar_fetch(w->queue, 2);
  em_calendar_fetch_plans(w->queue, 1);
  for (uint32_t k = 0; k < n; k++) {
    const uint32_t i = ball[k], partner = w->plan[i].first.partner;
    const uint32_t j = partner < EM_SURFACE ? partner : i;
    em_fetch_close(&w->body[i]);
    em_fetch_close(&w->body[j]);
    em_fetch_close(&w->plan[j]);
  }
}

/* In systems of medium size: the lists of n balls and of their partners. Where they are is asked
 * for when their bin begins, they themselves (`beyond`) when it has been tidied up: a gain of 1.03
 * in a dense gas of 10⁴ balls. */
static inline void fetch_lists(const struct em_world *w, const uint32_t *ball, uint32_t n,
                               bool beyond) {
  if (!w->fetches_lists) return;
  for (uint32_t k = 0; k < n; k++) {
    const uint32_t i = ball[k], partner = w->plan[i].first.partner;
    w->partition_kind->fetch(w, i, beyond, false);
    if (partner < EM_SURFACE) w->partition_kind->fetch(w, partner, beyond, false);
  }
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

/* Lower bound of the gap (m) between a ball and a blade as it stood at turning.at, not too far from
 * the time t; a contact needs the ball within the bar's length, whatever its tip. */
static inline double turning_gap(struct em_turning *b, struct em_vec r, double radius, double t) {
  if (b->swing * fabs(t - b->at) > 0.25 * radius) {
    b->at = t;
    b->cos = cos(b->blade.angle + b->blade.omega * t);
    b->sin = sin(b->blade.angle + b->blade.omega * t);
  }
  const struct em_vec q = em_vec_sub(r, b->blade.centre);
  const double q1 = em_vec_dot(q, b->blade.e1), q3 = em_vec_dot(q, b->e3);
  const double axial = em_vec_dot(q, b->blade.axis);
  const double along = q1 * b->cos + q3 * b->sin, off = q3 * b->cos - q1 * b->sin;
  const double side = sqrt(off * off + axial * axial) - b->blade.radius;
  return (em_greater(fabs(along) - b->blade.reach, side) - radius) - 1e-9 * b->hull;
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

static inline enum em_status collapsed(const struct em_world *w, uint32_t i, uint32_t partner,
                                       double t, struct em_error *err) {
  return em_collapse_report(w, i, partner, t, err);
}

static inline enum em_status no_memory(struct em_error *err) {
  return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the event lists");
}

#endif
