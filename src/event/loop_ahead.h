/* What all variants of the loop share: memory is asked ahead for what the next events will read. */
#ifndef EVENTMILL_LOOP_AHEAD_H
#define EVENTMILL_LOOP_AHEAD_H

#include "event/loop_parts.h"

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
  if (!w->fetches_close || !w->lists) return;
  for (uint32_t k = 0; k < n; k++) {
    const uint32_t i = ball[k], partner = w->plan[i].first.partner;
    em_neighbours_fetch(w->lists, i, beyond);
    em_neighbours_fetch(w->lists, partner < EM_SURFACE ? partner : i, beyond);
  }
}

#endif
