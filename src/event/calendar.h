/* The global list as a bounded-increasing queue (G. Paul, J. Comput. Phys. 221 (2007) 615).
 *
 * Time is cut into bins. A turn of `bins` bins, from the current one on, keeps the numbers of its
 * balls side by side, a cache line per bin; what lies further ahead waits in one more list that is
 * looked through once per turn. A ball whose event has moved is entered anew and nowhere taken out:
 * entries that do not hold any more fall out when their bin begins. So an event costs one line of
 * its bin, and no neighbour's.
 *
 * The balls of the current bin are due, in one of three forms. A few, as nearly always, stand in
 * no order, and the earliest is looked up by vectors, as its way through a heap cannot be foretold,
 * and wrong guesses cost more. They are taken out by clearing a bit, for what has just been written
 * in parts could not yet be read as a vector: a gain of 1.02. Some more stand side by side, without
 * gaps, and are looked through one by one. A crowd, whose events may be at one and the same time,
 * so that no narrower bin would part them, is a heap.
 *
 * In a large system the line of a bin is far away. What is written waits for it, and so does
 * whatever is written behind it and then read; therefore balls are put by, memory is asked for
 * their bins, and they are filed when the current bin is over: a gain of 1.1 at 10⁵ balls, of 1.3
 * at 10⁶.
 *
 * The order of events is that of (time, ball), whatever the width of a bin. The width adapts
 * itself: when a turn was too full or too empty, when nothing was found in it, and when the bin
 * stays large. */
#ifndef EVENTMILL_EVENT_CALENDAR_H
#define EVENTMILL_EVENT_CALENDAR_H

#include <assert.h>
#include <math.h>
#include <stdbool.h>

#include "event/fetch.h"
#include "event/lanes.h"
#include "event/queue.h"

enum {
  EM_CALENDAR_FEW = 16,    /* due balls that are looked through by vectors */
  EM_CALENDAR_LARGE = 32,  /* and one by one; more are a crowd, until they are few */
  EM_CALENDAR_BY = 48,     /* balls that are put by */
  EM_CALENDAR_ENTRIES = 16 /* of a bin, before they are put aside */
};
#define EM_CALENDAR_WAITS UINT32_MAX /* plan.place of a ball that is not due */

/* One cache line, which is written to and not waited for: how many there are is kept apart. */
struct em_calendar_bin {
  uint32_t ball[EM_CALENDAR_ENTRIES];
} __attribute__((aligned(64)));

struct em_queue {
  double origin, scale;        /* a time is in bin floor((time - origin) * scale) */
  double due_end;              /* what lies in bins below this one is due: current + 1 */
  double ring_end;             /* what lies in bins from this one on is later: current + bins */
  struct em_plan *plan;        /* of each ball: due; place, among the due; later: it stands there */
  struct em_calendar_bin *bin; /* the ring, and behind it those that were put aside */
  uint8_t *entries;            /* of each bin */
  uint32_t *aside;             /* of each bin: a full one that belongs there, too; 0: none */
  uint32_t *later;             /* balls beyond the ring, or that were */
  uint32_t *due;               /* balls of the current bin and before */
  double *due_time;
  uint32_t due_count, later_count;
  bool few, crowd;   /* the form of the due: see above; neither: some */
  unsigned standing; /* few: the bits of the places that are taken */
  uint32_t count, bins, all_bins;
  uint32_t spare;    /* the first free bin behind the ring, linked by `aside`; 0: none */
  uint32_t slot;     /* of the current bin in the ring: current - base */
  uint64_t pressure; /* balls looked through since the last check in large bins */
  int64_t base;      /* bin at which the turn began */
  uint64_t loaded;   /* balls that became due in this turn */
  double width;      /* s */
  bool large;        /* balls are put by before they are filed */
  uint32_t by[EM_CALENDAR_BY], by_count;
};

/* Goes on to the next bin that holds a ball; false: the list is empty. */
bool em_calendar_advance(struct em_queue *q);
/* The bin was large for long: are the bins too wide? */
void em_calendar_relieve(struct em_queue *q);
/* From places with bits set to places side by side. */
void em_calendar_close_up(struct em_queue *q);
/* And back, where few are due; false: there are too many. */
bool em_calendar_thin_out(struct em_queue *q);
/* Adds a ball where no place for a few is left. */
void em_calendar_join(struct em_queue *q, uint32_t ball, double time);
/* In a crowd: what has been put at a place takes the one that its time asks for. */
__attribute__((cold)) void em_calendar_settle(struct em_queue *q, uint32_t place);
/* In a crowd: the last one takes a place that has become free. */
__attribute__((cold)) void em_calendar_fill(struct em_queue *q, uint32_t place);
/* The first of the balls that are due, by (time, ball), where they are not few. */
uint32_t em_calendar_search(struct em_queue *q, double *time, uint32_t *rival);
/* A bin is full: puts its entries aside, or, where no room is left, files all balls anew; false:
 * that was done. */
bool em_calendar_make_room(struct em_queue *q, uint32_t bin);

/* The balls of the bin that comes `ahead` bins after the current one, up to `most` of them, as far
 * as it lies in this turn; some may not be there any more, unless it is the current one and has
 * just begun: then the earliest is among them, if `most` is EM_CALENDAR_LARGE at least. Returns how
 * many. */
uint32_t em_calendar_peek(const struct em_queue *q, uint32_t ahead, uint32_t *ball, uint32_t most);

/* That bin, or the current one where it lies beyond this turn. */
static inline const struct em_calendar_bin *em_calendar_ahead(const struct em_queue *q,
                                                              uint32_t ahead) {
  return &q->bin[q->slot + ahead < q->bins ? q->slot + ahead : q->slot];
}

/* Asks memory for it. */
static inline __attribute__((always_inline)) void em_calendar_fetch(const struct em_queue *q,
                                                                    uint32_t ahead) {
  em_fetch(em_calendar_ahead(q, ahead));
}

/* Asks for the plans of its balls, or of those that were there before; without counting them. */
static inline __attribute__((always_inline)) void em_calendar_fetch_plans(const struct em_queue *q,
                                                                          uint32_t ahead) {
  const struct em_calendar_bin *bin = em_calendar_ahead(q, ahead);
#pragma GCC unroll 16
  for (int k = 0; k < EM_CALENDAR_ENTRIES; k++)
    em_fetch_close(&q->plan[bin->ball[k]]);
}

static inline void em_calendar_put(struct em_queue *q, uint32_t place, uint32_t ball, double time) {
  q->due[place] = ball;
  q->due_time[place] = time;
  q->plan[ball].place = place;
}

static inline void em_calendar_add(struct em_queue *q, uint32_t ball, double time) {
  const uint32_t place = (uint32_t)__builtin_ctz(~q->standing);
  q->loaded++;
  if (q->few & (place < EM_CALENDAR_FEW)) {
    q->standing |= 1u << place;
    em_calendar_put(q, place, ball, time);
    return;
  }
  em_calendar_join(q, ball, time);
}

static inline void em_calendar_remove(struct em_queue *q, uint32_t place) {
  q->plan[q->due[place]].place = EM_CALENDAR_WAITS;
  if (__builtin_expect(q->few, 1)) {
    q->standing &= ~(1u << place);
    return;
  }
  const uint32_t last = --q->due_count;
  if (q->crowd)
    em_calendar_fill(q, place);
  else if (place < last)
    em_calendar_put(q, place, q->due[last], q->due_time[last]);
}

static inline double em_calendar_bin(const struct em_queue *q, double time) {
  return (time - q->origin) * q->scale;
}

/* Where in the ring a bin ahead of the current one stands. */
static inline uint32_t em_calendar_slot(const struct em_queue *q, double at) {
  const uint32_t slot = (uint32_t)((int64_t)at - q->base);
  return slot - (slot >= q->bins ? q->bins : 0);
}

/* Files a ball that is not due and whose time is in bin `at`; false: all have been filed anew. */
static inline bool em_calendar_file(struct em_queue *q, uint32_t ball, double at) {
  struct em_plan *plan = &q->plan[ball];
  if (at < q->due_end) {
    em_calendar_add(q, ball, plan->due);
    return true;
  }
  if (!(at < q->ring_end)) {
    q->later[q->later_count] = ball;
    q->later_count += !plan->later;
    plan->later = 1;
    return true;
  }
  const uint32_t bin = em_calendar_slot(q, at);
  if (q->entries[bin] == EM_CALENDAR_ENTRIES && !em_calendar_make_room(q, bin)) return false;
  q->bin[bin].ball[q->entries[bin]++] = ball;
  return true;
}

/* Files the balls that were put by. */
static inline void em_calendar_catch_up(struct em_queue *q) {
  const uint32_t n = q->by_count;
  q->by_count = 0;
  for (uint32_t k = 0; k < n; k++) {
    const struct em_plan *plan = &q->plan[q->by[k]];
    if (plan->place != EM_CALENDAR_WAITS) continue;
    if (!em_calendar_file(q, q->by[k], em_calendar_bin(q, plan->due))) return;
  }
}

/* Puts a ball by that is not due, and asks memory for its bin. */
static inline void em_calendar_put_by(struct em_queue *q, uint32_t ball, double at) {
  if (at < q->ring_end) {
    const uint32_t bin = em_calendar_slot(q, at);
    em_fetch(&q->bin[bin]);
    em_fetch(&q->entries[bin]);
  }
  q->by[q->by_count++] = ball;
  if (q->by_count == EM_CALENDAR_BY) em_calendar_catch_up(q);
}

/* See queue.h. */
static inline void em_calendar_set(struct em_queue *q, uint32_t ball, double time) {
  struct em_plan *plan = &q->plan[ball];
  const double at = em_calendar_bin(q, time);
  assert(ball < q->count && !isnan(time));
  plan->due = time;
  if (plan->place != EM_CALENDAR_WAITS) {
    if (at < q->due_end) {
      q->due_time[plan->place] = time;
      if (q->crowd) em_calendar_settle(q, plan->place);
      return;
    }
    em_calendar_remove(q, plan->place);
  }
  if (q->large && !(at < q->due_end))
    em_calendar_put_by(q, ball, at);
  else
    (void)em_calendar_file(q, ball, at);
}

/* Is nobody due? */
static inline bool em_calendar_is_over(const struct em_queue *q) {
  return q->few ? q->standing == 0 : q->due_count == 0;
}

/* See queue.h. */
static inline uint32_t em_calendar_first(struct em_queue *q, double *time, uint32_t *rival) {
  if (em_calendar_is_over(q) && !em_calendar_advance(q)) return EM_QUEUE_NOBODY;
  if (!q->few && !em_calendar_thin_out(q)) return em_calendar_search(q, time, rival);
  vd at[EM_CALENDAR_FEW / LANES], all = vd_all(INFINITY);
  for (int k = 0; k < EM_CALENDAR_FEW / LANES; k++) {
    const vm in = vm_of(q->standing >> k * LANES);
    at[k] = vd_choose(in, *(const vd *)(q->due_time + k * LANES), vd_all(INFINITY));
    all = vd_choose(vd_below(at[k], all), at[k], all);
  }
  *time = vd_least_of(all);
  unsigned here = 0;
  for (int k = 0; k < EM_CALENDAR_FEW / LANES; k++)
    here |= vm_bits(vd_equal(at[k], vd_all(*time))) << k * LANES;
  here &= q->standing;
  if (here & (here - 1) & ((here & (here - 1)) - 1)) {
    em_calendar_close_up(q);
    return em_calendar_search(q, time, rival);
  }
  const uint32_t i = q->due[__builtin_ctz(here)], j = q->due[31 - __builtin_clz(here)];
  *rival = i < j ? j : i;
  return i < j ? i : j;
}

#endif
