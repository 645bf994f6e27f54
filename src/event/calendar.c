/* The global list by a calendar: its turns, its width, and the rest of its interface. */
#include "event/calendar.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "event/body.h"

enum { LEAST_BINS = 8, SAMPLE = 256 };
#define TARGET 4.0 /* events per bin: of 1 … 8 the fastest */

static void close_list(struct em_calendar_link *link, uint32_t n) {
  link[n] = (struct em_calendar_link){n, n};
}

static uint32_t overflow_head(const struct em_queue *q) {
  return q->count + q->bins;
}

static void set_current(struct em_queue *q, int64_t current) {
  q->due_end = (double)current + 1.0;
  q->ring_end = (double)current + (double)q->bins;
}

/* Starts anew with the first bin at origin and everything filed afresh. */
static void refile_all(struct em_queue *q, double origin, double width) {
  const double finest = 4.0 * DBL_EPSILON * fabs(origin) + 1e-290;
  q->width = fmin(fmax(width, finest), 1e290);
  q->origin = origin;
  q->scale = 1.0 / q->width;
  q->base = 0;
  q->loaded = 0;
  q->pressure = 0;
  q->slot = 0;
  while (q->due_count)
    q->due_time[--q->due_count] = INFINITY;
  set_current(q, 0);
  for (uint32_t slot = 0; slot <= q->bins; slot++)
    close_list(q->link, q->count + slot);
  for (uint32_t ball = 0; ball < q->count; ball++)
    em_calendar_file(q, ball, em_calendar_bin(q, q->time[ball]));
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
    if (q->time[ball] < INFINITY) sample[taken++] = q->time[ball];
  }
  if (taken < 4) return 0.0;
  qsort(sample, taken, sizeof sample[0], compare);
  const double waiting = (double)q->count * (double)taken / (double)looked;
  return (sample[taken / 4] - earliest) / (0.288 * waiting);
}

static double earliest_time(const struct em_queue *q) {
  double earliest = INFINITY;
  for (uint32_t ball = 0; ball < q->count; ball++)
    earliest = fmin(earliest, q->time[ball]);
  return earliest;
}

void em_calendar_relieve(struct em_queue *q) {
  const double earliest = earliest_time(q);
  const double width = TARGET * spacing_ahead(q, earliest);
  q->pressure = 0;
  if (width > 0.0 && width < 0.5 * q->width) refile_all(q, earliest, width);
}

/* A turn is over: files again what waited in the overflow, or everything when the bins were too
 * full or too empty. False: there is nothing left at all. */
static bool next_turn(struct em_queue *q) {
  const int64_t current = q->base + q->bins;
  const double found = (double)q->loaded / (double)q->bins / TARGET;
  const bool odd = found > 2.0 || (found < 0.5 && q->bins > LEAST_BINS);
  if (odd || q->loaded == 0 || current > INT64_C(1) << 50) {
    const double earliest = earliest_time(q);
    if (earliest == INFINITY) return false;
    double width = q->width / fmax(found, 1.0 / 16.0);
    if (q->loaded == 0) width = fmax(width, TARGET * spacing_ahead(q, earliest));
    refile_all(q, earliest, odd ? width : q->width);
    return true;
  }
  q->base = current;
  q->slot = 0;
  q->loaded = 0;
  set_current(q, current);
  const uint32_t head = overflow_head(q);
  for (uint32_t ball = q->link[head].next; ball != head;) {
    const uint32_t next = q->link[ball].next;
    const double bin = em_calendar_bin(q, q->time[ball]);
    if (bin < q->ring_end) {
      em_calendar_unlink(q->link, ball);
      em_calendar_file(q, ball, bin);
    }
    ball = next;
  }
  return true;
}

bool em_calendar_advance(struct em_queue *q) {
  while (q->due_count == 0) {
    uint32_t slot = q->slot + 1;
    while (slot < q->bins && q->link[q->count + slot].next == q->count + slot)
      slot++;
    if (slot == q->bins) {
      if (!next_turn(q)) return false;
      slot = q->slot;
    }
    q->slot = slot;
    set_current(q, q->base + slot);
    const uint32_t head = q->count + slot;
    for (uint32_t ball = q->link[head].next; ball != head;) {
      const uint32_t next = q->link[ball].next;
      em_calendar_add(q, ball, q->time[ball]);
      ball = next;
    }
    close_list(q->link, head);
  }
  return true;
}

uint32_t em_calendar_peek(const struct em_queue *q, uint32_t ahead, uint32_t *ball, uint32_t most) {
  if (ahead == 0) {
    const uint32_t n = q->due_count < most ? q->due_count : most;
    memcpy(ball, q->due, n * sizeof *ball);
    return n;
  }
  if (q->slot + ahead >= q->bins) return 0;
  const uint32_t head = q->count + q->slot + ahead;
  uint32_t n = 0;
  for (uint32_t i = q->link[head].next; i != head && n < most; i = q->link[i].next)
    ball[n++] = i;
  return n;
}

/* ---- the interface ---- */

static void clear(struct em_queue *q, double from) {
  for (uint32_t ball = 0; ball < q->count; ball++)
    q->time[ball] = INFINITY;
  refile_all(q, from, q->width);
}

static void free_queue(struct em_queue *q) {
  if (!q) return;
  free(q->time);
  free(q->link);
  free(q->due);
  free(q->due_time);
  free(q);
}

static struct em_queue *make(uint32_t count, double spacing) {
  if (count >= UINT32_MAX / 2) return NULL;
  struct em_queue *q = calloc(1, sizeof *q);
  if (!q) return NULL;
  q->count = count;
  q->bins = count / 2 > LEAST_BINS ? count / 2 : LEAST_BINS;
  q->width = spacing > 0.0 && spacing < INFINITY ? TARGET * spacing : 1.0;
  q->time = em_body_array((size_t)count + 1, sizeof *q->time);
  q->link = em_body_array((size_t)count + q->bins + 1, sizeof *q->link);
  q->due = em_body_array((size_t)count + 8, sizeof *q->due);
  q->due_time = em_body_array((size_t)count + 8, sizeof *q->due_time);
  if (!q->time || !q->link || !q->due || !q->due_time) {
    free_queue(q);
    return NULL;
  }
  for (size_t k = 0; k < (size_t)count + 8; k++)
    q->due_time[k] = INFINITY;
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

static size_t tied(struct em_queue *q, uint32_t *ball, size_t room) {
  double time;
  uint32_t rival;
  if (first(q, &time, &rival) == EM_QUEUE_NOBODY) return 0;
  size_t found = 0;
  for (uint32_t k = 0; k < q->due_count; k++) {
    if (q->due_time[k] != time) continue;
    if (found < room) ball[found] = q->due[k];
    found++;
  }
  return found;
}

static size_t bytes(const struct em_queue *q) {
  return sizeof *q +
         ((size_t)q->count + 1) * (sizeof *q->time + sizeof *q->due + sizeof *q->due_time) +
         ((size_t)q->count + q->bins + 1) * sizeof *q->link;
}

static bool due_is_valid(const struct em_queue *q) {
  for (uint32_t place = 0; place < q->due_count; place++) {
    const uint32_t ball = q->due[place];
    if (ball >= q->count || q->link[ball].previous != EM_CALENDAR_DUE ||
        q->link[ball].next != place || q->due_time[place] != q->time[ball])
      return false;
    if (!(em_calendar_bin(q, q->time[ball]) < q->due_end)) return false;
  }
  for (uint32_t place = q->due_count; place % 8 || place < 8; place++)
    if (q->due_time[place] != INFINITY) return false;
  return true;
}

/* Walks one list, adds its balls to *seen, and checks that each belongs there. */
static bool list_is_valid(const struct em_queue *q, uint32_t head, size_t *seen) {
  uint32_t previous = head;
  for (uint32_t ball = q->link[head].next; ball != head; ball = q->link[ball].next) {
    if (ball >= q->count || q->link[ball].previous != previous || ++*seen > q->count) return false;
    const double bin = em_calendar_bin(q, q->time[ball]);
    if (bin < q->due_end) return false;
    if (head != overflow_head(q)) {
      if (bin >= q->ring_end) return false;
      if (((int64_t)bin - q->base) % q->bins != head - q->count) return false;
    }
    previous = ball;
  }
  return q->link[head].previous == previous;
}

static bool is_valid(const struct em_queue *q) {
  size_t seen = q->due_count;
  if (seen > q->count || !due_is_valid(q)) return false;
  for (uint32_t slot = 0; slot <= q->bins; slot++)
    if (!list_is_valid(q, q->count + slot, &seen)) return false;
  return seen == q->count;
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
