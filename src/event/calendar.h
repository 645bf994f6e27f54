/* The global list as a bounded-increasing queue (G. Paul, J. Comput. Phys. 221 (2007) 615).
 *
 * Time is cut into bins. A turn of `bins` bins, from the current one on, has a list each; what lies
 * further ahead waits in one more list, the overflow, that is looked through once per turn; balls
 * without an event wait there, too. Lists are linked both ways, so a ball is filed and taken out
 * in O(1). The few balls of the current bin stand side by side in no order, and the earliest is
 * looked up by vectors: its way through a heap cannot be foretold, and wrong guesses cost more.
 *
 * The order of events is that of (time, ball), whatever the width of a bin. The width adapts
 * itself: when a turn was too full or too empty, when nothing was found in it, and when the bin
 * stays large. */
#ifndef EVENTMILL_EVENT_CALENDAR_H
#define EVENTMILL_EVENT_CALENDAR_H

#include <assert.h>
#include <math.h>
#include <stdbool.h>

#include "event/queue.h"
#include "event/vectors.h"

enum { EM_CALENDAR_LARGE = 32 };
#define EM_CALENDAR_DUE UINT32_MAX

struct em_calendar_link {
  uint32_t next;     /* for a ball that is due: its place among these */
  uint32_t previous; /* EM_CALENDAR_DUE for a ball that is due */
};

struct em_queue {
  double origin, scale; /* a time is in bin floor((time - origin) * scale) */
  double due_end;       /* what lies in bins below this one is due: current + 1 */
  double ring_end;      /* bins from this one on are in the overflow: current + bins */
  double *time;         /* of each ball */
  struct em_calendar_link
      *link;        /* of each ball, of the head of each bin, of that of the overflow */
  uint32_t *due;    /* balls of the current bin and before */
  double *due_time; /* INFINITY up to a multiple of eight */
  uint32_t due_count;
  uint32_t count, bins;
  uint32_t slot;     /* of the current bin in the ring: current - base */
  uint64_t pressure; /* balls looked through since the last check in large bins */
  int64_t base;      /* bin at which the turn began */
  uint64_t loaded;   /* balls that became due in this turn */
  double width;      /* s */
};

/* Goes on to the next bin that holds a ball; false: the list is empty. */
bool em_calendar_advance(struct em_queue *q);
/* The bin was large for long: are the bins too wide? */
void em_calendar_relieve(struct em_queue *q);
/* The first of the balls that are due, by (time, ball), where there are many. */
uint32_t em_calendar_search(struct em_queue *q, double *time, uint32_t *rival);

/* The balls of the bin that comes `ahead` bins after the current one, up to `most` of them, as far
 * as it lies in this turn; returns how many. */
uint32_t em_calendar_peek(const struct em_queue *q, uint32_t ahead, uint32_t *ball, uint32_t most);

static inline void em_calendar_unlink(struct em_calendar_link *link, uint32_t ball) {
  const struct em_calendar_link old = link[ball];
  link[old.previous].next = old.next;
  link[old.next].previous = old.previous;
}

static inline void em_calendar_link(struct em_calendar_link *link, uint32_t ball, uint32_t head) {
  const uint32_t next = link[head].next;
  link[ball] = (struct em_calendar_link){.next = next, .previous = head};
  link[next].previous = ball;
  link[head].next = ball;
}

static inline void em_calendar_put(struct em_queue *q, uint32_t place, uint32_t ball, double time) {
  q->due[place] = ball;
  q->due_time[place] = time;
  q->link[ball] = (struct em_calendar_link){.next = place, .previous = EM_CALENDAR_DUE};
}

static inline void em_calendar_add(struct em_queue *q, uint32_t ball, double time) {
  q->loaded++;
  em_calendar_put(q, q->due_count++, ball, time);
}

static inline void em_calendar_remove(struct em_queue *q, uint32_t place) {
  const uint32_t last = --q->due_count;
  em_calendar_put(q, place, q->due[last], q->due_time[last]);
  q->due_time[last] = INFINITY;
}

static inline double em_calendar_bin(const struct em_queue *q, double time) {
  return (time - q->origin) * q->scale;
}

/* Files a ball that is nowhere and whose time is in bin `bin`. */
static inline void em_calendar_file(struct em_queue *q, uint32_t ball, double bin) {
  if (bin < q->due_end) {
    em_calendar_add(q, ball, q->time[ball]);
    return;
  }
  uint32_t head = q->bins;
  if (bin < q->ring_end) {
    const uint32_t slot = (uint32_t)((int64_t)bin - q->base);
    head = slot - (slot >= q->bins ? q->bins : 0);
  }
  em_calendar_link(q->link, ball, q->count + head);
}

/* See queue.h. */
static inline void em_calendar_set(struct em_queue *q, uint32_t ball, double time) {
  const double bin = em_calendar_bin(q, time);
  assert(ball < q->count && !isnan(time));
  q->time[ball] = time;
  if (q->link[ball].previous == EM_CALENDAR_DUE) {
    const uint32_t place = q->link[ball].next;
    if (bin < q->due_end) {
      q->due_time[place] = time;
      return;
    }
    em_calendar_remove(q, place);
  } else {
    em_calendar_unlink(q->link, ball);
  }
  em_calendar_file(q, ball, bin);
}

/* See queue.h. */
static inline uint32_t em_calendar_first(struct em_queue *q, double *time, uint32_t *rival) {
  if (q->due_count == 0 && !em_calendar_advance(q)) return EM_QUEUE_NOBODY;
  if (q->due_count > 8) return em_calendar_search(q, time, rival);
  const v4d a = *(const v4d *)q->due_time, b = *(const v4d *)(q->due_time + 4);
  const v4d all = v4d_least_of(v4d_least(a, b));
  const unsigned here = v4l_bits(a == all) | v4l_bits(b == all) << 4;
  if (here & (here - 1) & ((here & (here - 1)) - 1)) return em_calendar_search(q, time, rival);
  const uint32_t i = q->due[__builtin_ctz(here)], j = q->due[31 - __builtin_clz(here)];
  *time = all[0];
  *rival = i < j ? j : i;
  return i < j ? i : j;
}

#endif
