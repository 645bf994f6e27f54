/* The global list by a calendar: its turns, its width, and the rest of its interface. */
#include "event/calendar.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "event/body.h"

enum { LEAST_BINS = 8, SAMPLE = 256, AHEAD = 16 };
/* Events per bin: where memory is asked for ahead, not for too many at a time. */
static double target(uint32_t count) {
  return count < EM_FETCH_FROM ? 12.0 : 8.0;
}

static void set_current(struct em_queue *q, int64_t current) {
  q->due_end = (double)current + 1.0;
  q->ring_end = (double)current + (double)q->bins;
}

/* No ball stands anywhere. Bin 0 is of the ring, so that its number serves as none. */
static void empty(struct em_queue *q) {
  q->few = q->crowd = false;
  q->standing = 0;
  q->due_count = 0;
  q->later_count = 0;
  q->by_count = 0;
  for (uint32_t ball = 0; ball < q->count; ball++) {
    q->plan[ball].place = EM_CALENDAR_WAITS;
    q->plan[ball].later = 0;
  }
  for (uint32_t k = 0; k < q->all_bins; k++) {
    q->entries[k] = 0;
    q->aside[k] = k < q->bins || k + 1 == q->all_bins ? 0 : k + 1;
  }
  q->spare = q->bins;
}

/* Starts anew with the first bin at origin and everything filed afresh: there is room, as each ball
 * has one entry now. */
static void refile_all(struct em_queue *q, double origin, double width) {
  const double finest = 4.0 * DBL_EPSILON * fabs(origin) + 1e-290;
  q->width = fmin(fmax(width, finest), 1e290);
  q->origin = origin;
  q->scale = 1.0 / q->width;
  q->base = 0;
  q->loaded = 0;
  q->pressure = 0;
  q->slot = 0;
  set_current(q, 0);
  empty(q);
  for (uint32_t ball = 0; ball < q->count; ball++)
    (void)em_calendar_file(q, ball, em_calendar_bin(q, q->plan[ball].due));
}

/* ---- the width ---- */

static int compare(const void *a, const void *b) {
  const double x = *(const double *)a;
  const double y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Time between successive events, from how densely they lie ahead: for exponentially distributed
 * waiting times a quarter of the balls is due within 0.288 of the mean. 0: cannot say. */
static double spacing_ahead(const struct em_queue *q, double earliest) {
  double sample[SAMPLE];
  size_t taken = 0, looked = 0;
  const uint32_t stride = q->count / SAMPLE + 1;
  for (uint32_t ball = 0; ball < q->count; ball += stride) {
    looked++;
    if (q->plan[ball].due < INFINITY) sample[taken++] = q->plan[ball].due;
  }
  if (taken < 4) return 0.0;
  qsort(sample, taken, sizeof sample[0], compare);
  const double waiting = (double)q->count * (double)taken / (double)looked;
  return (sample[taken / 4] - earliest) / (0.288 * waiting);
}

static double earliest_time(const struct em_queue *q) {
  double earliest = INFINITY;
  for (uint32_t ball = 0; ball < q->count; ball++)
    earliest = fmin(earliest, q->plan[ball].due);
  return earliest;
}

void em_calendar_relieve(struct em_queue *q) {
  const double earliest = earliest_time(q);
  const double width = target(q->count) * spacing_ahead(q, earliest);
  q->pressure = 0;
  if (width > 0.0 && width < 0.5 * q->width) refile_all(q, earliest, width);
}

/* A turn is over: files again what waited in the overflow, or everything when the bins were too
 * full or too empty. False: there is nothing left at all. */
static bool next_turn(struct em_queue *q) {
  const int64_t current = q->base + q->bins;
  const double found = (double)q->loaded / (double)q->bins / target(q->count);
  const bool odd = found > 2.0 || (found < 0.5 && q->bins > LEAST_BINS);
  if (odd || q->loaded == 0 || current > INT64_C(1) << 50) {
    const double earliest = earliest_time(q);
    if (earliest == INFINITY) return false;
    double width = q->width / fmax(found, 1.0 / 16.0);
    if (q->loaded == 0) width = fmax(width, target(q->count) * spacing_ahead(q, earliest));
    refile_all(q, earliest, odd ? width : q->width);
    return true;
  }
  q->base = current;
  q->slot = 0;
  q->loaded = 0;
  set_current(q, current);
  const uint32_t waiting = q->later_count;
  q->later_count = 0;
  for (uint32_t k = 0; k < waiting; k++) {
    const uint32_t ball = q->later[k];
    if (k + AHEAD < waiting) em_fetch(&q->plan[q->later[k + AHEAD]]);
    q->plan[ball].later = 0;
    if (q->plan[ball].place != EM_CALENDAR_WAITS) continue;
    if (!em_calendar_file(q, ball, em_calendar_bin(q, q->plan[ball].due))) break;
  }
  return true;
}

bool em_calendar_make_room(struct em_queue *q, uint32_t bin) {
  const uint32_t aside = q->spare;
  if (!aside) {
    refile_all(q, earliest_time(q), q->width);
    return false;
  }
  q->spare = q->aside[aside];
  q->bin[aside] = q->bin[bin];
  q->entries[aside] = EM_CALENDAR_ENTRIES;
  q->aside[aside] = q->aside[bin];
  q->entries[bin] = 0;
  q->aside[bin] = aside;
  return true;
}

/* The balls of a bin become due, but those that have moved: which have cannot be foretold, so there
 * is no branch. A ball that was entered twice is due by then. */
static void load(struct em_queue *q, uint32_t bin) {
  uint32_t n = q->due_count;
  for (uint32_t k = 0; k < q->entries[bin]; k++) {
    const uint32_t ball = q->bin[bin].ball[k];
    struct em_plan *plan = &q->plan[ball];
    const bool in =
        (em_calendar_bin(q, plan->due) < q->due_end) & (plan->place == EM_CALENDAR_WAITS);
    q->due[n] = ball;
    q->due_time[n] = plan->due;
    plan->place = (plan->place & ~-(uint32_t)in) | (n & -(uint32_t)in);
    n += in;
  }
  q->loaded += n - q->due_count;
  q->due_count = n;
}

/* ---- the due ---- */

void em_calendar_close_up(struct em_queue *q) {
  q->due_count = 0;
  q->few = false;
  for (; q->standing; q->standing &= q->standing - 1) {
    const int k = __builtin_ctz(q->standing);
    em_calendar_put(q, q->due_count++, q->due[k], q->due_time[k]);
  }
}

bool em_calendar_thin_out(struct em_queue *q) {
  if (q->due_count > EM_CALENDAR_FEW) return false;
  q->few = true;
  q->crowd = false;
  q->standing = (1u << q->due_count) - 1u;
  return true;
}

/* Does a ball with that time come before the one at `place`? */
static bool comes_before(const struct em_queue *q, uint32_t ball, double time, uint32_t place) {
  return time < q->due_time[place] || (time == q->due_time[place] && ball < q->due[place]);
}

/* The ball takes `place`, or one farther from the top, where others come before it. */
static void sink(struct em_queue *q, uint32_t place, uint32_t ball, double time) {
  for (uint32_t down; (down = 2 * place + 1) < q->due_count; place = down) {
    const uint32_t side = down + 1;
    if (side < q->due_count && comes_before(q, q->due[side], q->due_time[side], down)) down = side;
    if (comes_before(q, ball, time, down)) break;
    em_calendar_put(q, place, q->due[down], q->due_time[down]);
  }
  em_calendar_put(q, place, ball, time);
}

void em_calendar_settle(struct em_queue *q, uint32_t place) {
  const uint32_t ball = q->due[place];
  const double time = q->due_time[place];
  for (uint32_t up; place > 0; place = up) {
    up = (place - 1) / 2;
    if (!comes_before(q, ball, time, up)) break;
    em_calendar_put(q, place, q->due[up], q->due_time[up]);
  }
  sink(q, place, ball, time);
}

void em_calendar_fill(struct em_queue *q, uint32_t place) {
  const uint32_t last = q->due_count;
  if (place == last) return;
  em_calendar_put(q, place, q->due[last], q->due_time[last]);
  em_calendar_settle(q, place);
}

static void crowd(struct em_queue *q) {
  q->crowd = true;
  for (uint32_t k = q->due_count / 2; k-- > 0;)
    sink(q, k, q->due[k], q->due_time[k]);
}

void em_calendar_join(struct em_queue *q, uint32_t ball, double time) {
  if (q->few) em_calendar_close_up(q);
  em_calendar_put(q, q->due_count++, ball, time);
  if (q->crowd)
    em_calendar_settle(q, q->due_count - 1);
  else if (q->due_count > EM_CALENDAR_LARGE)
    crowd(q);
}

/* The first of a crowd: those at its time hang together at the top of the heap. */
static uint32_t first_of_crowd(const struct em_queue *q, double *time, uint32_t *rival) {
  uint32_t other = 0, equal = 1;
  *time = q->due_time[0];
  for (uint32_t k = 1; k < 7 && k < q->due_count; k++)
    if (q->due_time[k] == *time) other = k, equal++;
  *rival = equal > 2 ? EM_QUEUE_SEVERAL : q->due[other];
  return q->due[0];
}

static size_t tied_in_crowd(const struct em_queue *q, uint32_t *ball) {
  size_t found = 1;
  ball[0] = q->due[0];
  for (size_t n = 0; n < found; n++) {
    const uint32_t down = 2 * q->plan[ball[n]].place + 1;
    for (uint32_t k = down; k < down + 2 && k < q->due_count; k++)
      if (q->due_time[k] == q->due_time[0]) ball[found++] = q->due[k];
  }
  return found;
}

/* ---- bins ---- */

bool em_calendar_advance(struct em_queue *q) {
  em_calendar_catch_up(q); /* may file all anew, so that some are due */
  if (em_calendar_is_over(q)) {
    q->few = q->crowd = false;
    q->due_count = 0;
  }
  while (q->due_count == 0) {
    uint32_t slot = q->slot + 1;
    while (slot < q->bins && q->entries[slot] == 0)
      slot++;
    if (slot == q->bins) {
      if (!next_turn(q)) return false;
      slot = q->slot;
    }
    q->slot = slot;
    set_current(q, q->base + slot);
    uint32_t k = slot, next;
    do {
      load(q, k);
      next = q->aside[k];
      q->entries[k] = 0;
      q->aside[k] = k < q->bins ? 0 : q->spare;
      if (k >= q->bins) q->spare = k;
      k = next;
    } while (next);
  }
  if (!em_calendar_thin_out(q) && q->due_count > EM_CALENDAR_LARGE) crowd(q);
  return true;
}

uint32_t em_calendar_peek(const struct em_queue *q, uint32_t ahead, uint32_t *ball, uint32_t most) {
  const uint32_t bin = q->slot + ahead;
  const bool due = ahead == 0;
  if (!due && bin >= q->bins) return 0;
  const uint32_t all = due ? q->due_count : q->entries[bin], n = all < most ? all : most;
  memcpy(ball, due ? q->due : q->bin[bin].ball, n * sizeof *ball);
  return n;
}

/* ---- the interface ---- */

static void clear(struct em_queue *q, double from) {
  for (uint32_t ball = 0; ball < q->count; ball++)
    q->plan[ball].due = INFINITY;
  refile_all(q, from, q->width);
}

static void free_queue(struct em_queue *q) {
  if (!q) return;
  free(q->bin);
  free(q->entries);
  free(q->aside);
  free(q->later);
  free(q->due);
  free(q->due_time);
  free(q);
}

static struct em_queue *make(uint32_t count, struct em_plan *plan, double spacing) {
  if (count > EM_BALLS_MOST) return NULL;
  struct em_queue *q = calloc(1, sizeof *q);
  if (!q) return NULL;
  q->count = count;
  q->plan = plan;
  q->large = count >= EM_FETCH_FROM;
  q->bins = count / 4 > LEAST_BINS ? count / 4 : LEAST_BINS;
  q->all_bins = q->bins + 2 * (count / EM_CALENDAR_ENTRIES) + LEAST_BINS;
  q->width = spacing > 0.0 && spacing < INFINITY ? target(count) * spacing : 1.0;
  q->bin = em_body_array(q->all_bins, sizeof *q->bin);
  q->entries = em_body_array(q->all_bins, sizeof *q->entries);
  q->aside = em_body_array(q->all_bins, sizeof *q->aside);
  q->later = em_body_array((size_t)count + 1, sizeof *q->later);
  q->due = em_body_array((size_t)count + EM_CALENDAR_FEW, sizeof *q->due);
  q->due_time = em_body_array((size_t)count + EM_CALENDAR_FEW, sizeof *q->due_time);
  if (!q->bin || !q->entries || !q->aside || !q->later || !q->due || !q->due_time) {
    free_queue(q);
    return NULL;
  }
  clear(q, 0.0);
  return q;
}

static void set(struct em_queue *q, uint32_t ball, double time) {
  em_calendar_set(q, ball, time);
}

static uint32_t first(struct em_queue *q, double *time, uint32_t *rival) {
  return em_calendar_first(q, time, rival);
}

uint32_t em_calendar_search(struct em_queue *q, double *time, uint32_t *rival) {
  if (q->due_count > EM_CALENDAR_LARGE && (q->pressure += q->due_count) > 32 * (uint64_t)q->count)
    em_calendar_relieve(q);
  if (q->crowd) return first_of_crowd(q, time, rival);
  double earliest = INFINITY;
  uint32_t least = EM_QUEUE_NOBODY, most = 0, equal = 0;
  for (uint32_t k = 0; k < q->due_count; k++)
    earliest = q->due_time[k] < earliest ? q->due_time[k] : earliest;
  for (uint32_t k = 0; k < q->due_count; k++) {
    if (q->due_time[k] != earliest) continue;
    const uint32_t ball = q->due[k];
    equal++;
    least = ball < least ? ball : least;
    most = ball > most ? ball : most;
  }
  *time = earliest;
  *rival = equal > 2 ? EM_QUEUE_SEVERAL : most;
  return least;
}

static size_t tied(struct em_queue *q, uint32_t *ball) {
  double time;
  uint32_t rival;
  if (first(q, &time, &rival) == EM_QUEUE_NOBODY) return 0;
  if (q->crowd) return tied_in_crowd(q, ball);
  if (q->few) em_calendar_close_up(q);
  size_t found = 0;
  for (uint32_t k = 0; k < q->due_count; k++)
    if (q->due_time[k] == time) ball[found++] = q->due[k];
  return found;
}

static size_t bytes(const struct em_queue *q) {
  return sizeof *q + ((size_t)q->count + EM_CALENDAR_FEW) * (sizeof *q->due + sizeof *q->due_time) +
         ((size_t)q->count + 1) * sizeof *q->later +
         (size_t)q->all_bins * (sizeof *q->bin + sizeof *q->entries + sizeof *q->aside);
}

static bool due_is_valid(const struct em_queue *q) {
  for (uint32_t place = 0; place < (q->few ? EM_CALENDAR_FEW : q->due_count); place++) {
    const uint32_t ball = q->due[place];
    if (q->few && !(q->standing >> place & 1)) continue;
    if (ball >= q->count || q->plan[ball].place != place || q->due_time[place] != q->plan[ball].due)
      return false;
    if (!(em_calendar_bin(q, q->plan[ball].due) < q->due_end)) return false;
    if (q->crowd && place > 0 && comes_before(q, ball, q->due_time[place], (place - 1) / 2))
      return false;
  }
  return q->few ? !q->crowd : q->standing == 0;
}

/* Does a ball stand where it waits? */
static bool waits(const struct em_queue *q, uint32_t ball, double at) {
  if (at < q->due_end) return false;
  for (uint32_t k = 0; k < q->by_count; k++)
    if (q->by[k] == ball) return true;
  const bool ahead = !(at < (double)q->base + q->bins); /* not in this turn */
  if (!(at < q->ring_end) || (ahead && q->plan[ball].later)) return q->plan[ball].later;
  for (uint32_t k = (uint32_t)(((int64_t)at - q->base) % q->bins), next;; k = next) {
    for (uint32_t n = 0; n < q->entries[k]; n++)
      if (q->bin[k].ball[n] == ball) return true;
    next = q->aside[k];
    if (!next) return false;
  }
}

static bool is_valid(const struct em_queue *q) {
  if (q->due_count > q->count || !due_is_valid(q)) return false;
  uint32_t due = 0, later = 0;
  for (uint32_t ball = 0; ball < q->count; ball++) {
    const struct em_plan *plan = &q->plan[ball];
    const bool is_due = plan->place != EM_CALENDAR_WAITS;
    due += is_due;
    later += plan->later;
    if (!is_due && !waits(q, ball, em_calendar_bin(q, plan->due))) return false;
  }
  const uint32_t all = q->few ? (uint32_t)__builtin_popcount(q->standing) : q->due_count;
  return due == all && later == q->later_count;
}

const struct em_queue_kind em_queue_calendar = {
    .name = "calendar",
    .make = make,
    .free = free_queue,
    .clear = clear,
    .set = set,
    .first = first,
    .tied = tied,
    .bytes = bytes,
    .is_valid = is_valid,
};
