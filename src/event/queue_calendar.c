/* The global list as a bounded-increasing queue (G. Paul, J. Comput. Phys. 221 (2007) 615).
 *
 * Time is cut into bins. A turn of `bins` bins, from the current one on, has a list each; what lies
 * further ahead waits in one more list, the overflow, that is looked through once per turn; balls
 * without an event wait there, too. Lists are linked both ways, so a ball is filed and taken out
 * in O(1). Only the few balls of the current bin are ordered, in a binary heap.
 *
 * The order of events is that of (time, ball), whatever the width of a bin. The width adapts
 * itself: when a turn was too full or too empty, when nothing was found in it, and when the heap
 * stays large. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "event/body.h"
#include "event/queue.h"

enum { LEAST_BINS = 8, LARGE_HEAP = 32, SAMPLE = 256 };
#define IN_HEAP UINT32_MAX
#define TARGET  4.0 /* events per bin: of 1 … 8 the fastest */

struct link {
  uint32_t next;     /* for a ball in the heap: its place there */
  uint32_t previous; /* IN_HEAP for a ball in the heap */
};

struct em_queue {
  double origin, scale; /* a time is in bin floor((time - origin) * scale) */
  double heap_end;      /* bins below this one are in the heap: current + 1 */
  double ring_end;      /* bins from this one on are in the overflow: current + bins */
  double *time;         /* of each ball */
  struct link *link;    /* of each ball, of the head of each bin, of the head of the overflow */
  uint32_t *heap;       /* balls of the current bin and before */
  uint32_t heap_size;
  uint32_t count, bins;
  uint32_t slot;     /* of the current bin in the ring: current - base */
  uint32_t pressure; /* calls since the last check that found a large heap */
  int64_t base;      /* bin at which the turn began */
  uint64_t loaded;   /* balls that came into the heap in this turn */
  double width;      /* s */
};

/* ---- the heap ---- */

static bool is_before(const struct em_queue *q, uint32_t a, uint32_t b) {
  const double time = q->time[a], other = q->time[b];
  return time < other || (time == other && a < b);
}

static void put(struct em_queue *q, uint32_t place, uint32_t ball) {
  q->heap[place] = ball;
  q->link[ball].next = place;
}

static void sift_up(struct em_queue *q, uint32_t place, uint32_t ball) {
  while (place > 0) {
    const uint32_t parent = (place - 1) / 2;
    if (!is_before(q, ball, q->heap[parent])) break;
    put(q, place, q->heap[parent]);
    place = parent;
  }
  put(q, place, ball);
}

static void sift_down(struct em_queue *q, uint32_t place, uint32_t ball) {
  for (;;) {
    uint32_t child = 2 * place + 1;
    if (child >= q->heap_size) break;
    if (child + 1 < q->heap_size && is_before(q, q->heap[child + 1], q->heap[child])) child++;
    if (!is_before(q, q->heap[child], ball)) break;
    put(q, place, q->heap[child]);
    place = child;
  }
  put(q, place, ball);
}

/* Puts a ball at a place where the heap may be wrong in either direction. */
static void settle(struct em_queue *q, uint32_t place, uint32_t ball) {
  if (place > 0 && is_before(q, ball, q->heap[(place - 1) / 2]))
    sift_up(q, place, ball);
  else
    sift_down(q, place, ball);
}

static void heap_remove(struct em_queue *q, uint32_t place) {
  const uint32_t last = q->heap[--q->heap_size];
  if (place != q->heap_size) settle(q, place, last);
}

static void heap_add(struct em_queue *q, uint32_t ball) {
  q->loaded++;
  q->link[ball].previous = IN_HEAP;
  sift_up(q, q->heap_size++, ball);
}

/* ---- the lists ---- */

static void unlink_ball(struct link *link, uint32_t ball) {
  const struct link old = link[ball];
  link[old.previous].next = old.next;
  link[old.next].previous = old.previous;
}

static void link_ball(struct link *link, uint32_t ball, uint32_t head) {
  const uint32_t next = link[head].next;
  link[ball] = (struct link){.next = next, .previous = head};
  link[next].previous = ball;
  link[head].next = ball;
}

static void close_list(struct link *link, uint32_t n) {
  link[n] = (struct link){n, n};
}

static uint32_t overflow_head(const struct em_queue *q) {
  return q->count + q->bins;
}

/* Files a ball that is nowhere and whose time is in bin `bin`. */
static void file_ball(struct em_queue *q, uint32_t ball, double bin) {
  if (bin < q->heap_end) {
    heap_add(q, ball);
  } else if (bin < q->ring_end) {
    uint32_t slot = (uint32_t)((int64_t)bin - q->base);
    if (slot >= q->bins) slot -= q->bins;
    link_ball(q->link, ball, q->count + slot);
  } else {
    link_ball(q->link, ball, overflow_head(q));
  }
}

static double bin_of(const struct em_queue *q, double time) {
  return (time - q->origin) * q->scale;
}

static void set_current(struct em_queue *q, int64_t current) {
  q->heap_end = (double)current + 1.0;
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
  q->slot = q->heap_size = q->pressure = 0;
  set_current(q, 0);
  for (uint32_t slot = 0; slot <= q->bins; slot++)
    close_list(q->link, q->count + slot);
  for (uint32_t ball = 0; ball < q->count; ball++)
    file_ball(q, ball, bin_of(q, q->time[ball]));
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

/* The heap was large for long: are the bins too wide? */
static void relieve_heap(struct em_queue *q) {
  const double earliest = q->time[q->heap[0]];
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
    const double bin = bin_of(q, q->time[ball]);
    if (bin < q->ring_end) {
      unlink_ball(q->link, ball);
      file_ball(q, ball, bin);
    }
    ball = next;
  }
  return true;
}

/* Goes on to the next bin that holds a ball; false: the list is empty. */
static bool advance(struct em_queue *q) {
  while (q->heap_size == 0) {
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
      heap_add(q, ball);
      ball = next;
    }
    close_list(q->link, head);
  }
  return true;
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
  free(q->heap);
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
  q->heap = em_body_array((size_t)count + 1, sizeof *q->heap);
  if (!q->time || !q->link || !q->heap) {
    free_queue(q);
    return NULL;
  }
  clear(q, 0.0);
  return q;
}

static void set(struct em_queue *q, uint32_t ball, double time) {
  const double bin = bin_of(q, time);
  assert(ball < q->count && !isnan(time));
  q->time[ball] = time;
  if (q->link[ball].previous == IN_HEAP) {
    const uint32_t place = q->link[ball].next;
    if (bin < q->heap_end) {
      settle(q, place, ball);
      return;
    }
    heap_remove(q, place);
  } else {
    unlink_ball(q->link, ball);
  }
  file_ball(q, ball, bin);
}

static uint32_t first(struct em_queue *q, double *time, bool *alone) {
  if (q->heap_size == 0 && !advance(q)) return EM_QUEUE_NOBODY;
  if (q->heap_size > LARGE_HEAP && ++q->pressure > q->count) relieve_heap(q);
  const uint32_t ball = q->heap[0];
  const double t = q->time[ball];
  *time = t;
  *alone = (q->heap_size < 2 || q->time[q->heap[1]] != t) &&
           (q->heap_size < 3 || q->time[q->heap[2]] != t);
  return ball;
}

struct tie {
  const struct em_queue *queue;
  double time;
  uint32_t *ball;
  size_t room, found;
};

/* Balls below a place of the heap that is not tied are not tied either. */
static void collect(struct tie *tie, uint32_t place) {
  const struct em_queue *q = tie->queue;
  if (place >= q->heap_size || q->time[q->heap[place]] != tie->time) return;
  if (tie->found < tie->room) tie->ball[tie->found] = q->heap[place];
  tie->found++;
  collect(tie, 2 * place + 1);
  collect(tie, 2 * place + 2);
}

static size_t tied(struct em_queue *q, uint32_t *ball, size_t room) {
  double time;
  bool alone;
  if (first(q, &time, &alone) == EM_QUEUE_NOBODY) return 0;
  struct tie tie = {q, time, ball, room, 0};
  collect(&tie, 0);
  return tie.found;
}

static size_t bytes(const struct em_queue *q) {
  return sizeof *q + ((size_t)q->count + 1) * (sizeof *q->time + sizeof *q->heap) +
         ((size_t)q->count + q->bins + 1) * sizeof *q->link;
}

static bool heap_is_valid(const struct em_queue *q) {
  for (uint32_t place = 0; place < q->heap_size; place++) {
    const uint32_t ball = q->heap[place];
    if (ball >= q->count || q->link[ball].previous != IN_HEAP || q->link[ball].next != place)
      return false;
    if (!(bin_of(q, q->time[ball]) < q->heap_end)) return false;
    if (place > 0 && is_before(q, ball, q->heap[(place - 1) / 2])) return false;
  }
  return true;
}

/* Walks one list, adds its balls to *seen, and checks that each belongs there. */
static bool list_is_valid(const struct em_queue *q, uint32_t head, size_t *seen) {
  uint32_t previous = head;
  for (uint32_t ball = q->link[head].next; ball != head; ball = q->link[ball].next) {
    if (ball >= q->count || q->link[ball].previous != previous || ++*seen > q->count) return false;
    const double bin = bin_of(q, q->time[ball]);
    if (bin < q->heap_end) return false;
    if (head != overflow_head(q)) {
      if (bin >= q->ring_end) return false;
      if (((int64_t)bin - q->base) % q->bins != head - q->count) return false;
    }
    previous = ball;
  }
  return q->link[head].previous == previous;
}

static bool is_valid(const struct em_queue *q) {
  size_t seen = q->heap_size;
  if (seen > q->count || !heap_is_valid(q)) return false;
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
