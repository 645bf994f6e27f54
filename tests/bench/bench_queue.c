/* What the global lists cost: the hold model (take the earliest ball, give it and a random partner
 * new events) in ns of CPU time per collision, for every kind and 10³ … 10⁶ balls. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "event/queue.h"

enum { WAITS = 1 << 16, HINTS = 3 };

static double seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* xorshift64*: the same numbers on every machine. */
static uint64_t draw(uint64_t *state) {
  *state ^= *state >> 12;
  *state ^= *state << 25;
  *state ^= *state >> 27;
  return *state * UINT64_C(2685821657736338717);
}

/* Waiting times of a gas, drawn beforehand: they are not what is measured. */
static double *make_waits(void) {
  double *wait = malloc(WAITS * sizeof *wait);
  uint64_t state = 5;
  if (!wait) exit(1);
  for (size_t k = 0; k < WAITS; k++)
    wait[k] = -log1p(-(double)(draw(&state) >> 11) * 0x1p-53);
  return wait;
}

/* The loop without a list; the sum keeps it from being optimised away. */
static double overhead(uint32_t count, uint64_t steps, const double *wait) {
  uint64_t state = 9;
  double sum = 0.0;
  const double begin = seconds();
  for (uint64_t k = 0; k < steps; k++) {
    const uint64_t bits = draw(&state);
    sum += wait[bits % WAITS] + wait[(bits >> 16) % WAITS] + (double)((bits >> 32) * count >> 32);
  }
  const double end = seconds();
  return sum > 0.0 ? (end - begin) / (double)steps : 0.0;
}

static double hold(struct em_queue *queue, const struct em_queue_kind *kind, uint32_t count,
                   uint64_t steps, const double *wait, uint64_t *state) {
  const double begin = seconds();
  for (uint64_t k = 0; k < steps; k++) {
    const uint64_t bits = draw(state);
    double now;
    uint32_t rival;
    const uint32_t ball = kind->first(queue, &now, &rival);
    kind->set(queue, ball, now + wait[bits % WAITS]);
    kind->set(queue, (uint32_t)((bits >> 32) * count >> 32), now + wait[(bits >> 16) % WAITS]);
  }
  return (seconds() - begin) / (double)steps;
}

static double measure(const struct em_queue_kind *kind, uint32_t count, double spacing,
                      const double *wait, size_t *bytes) {
  const uint64_t steps = 2000000;
  uint64_t state = 9;
  struct em_plan *plan = aligned_alloc(64, count * sizeof *plan);
  if (!plan) exit(1);
  memset(plan, 0, count * sizeof *plan);
  struct em_queue *queue = kind->make(count, plan, spacing);
  if (!queue) exit(1);
  for (uint32_t n = 0; n < count; n++)
    kind->set(queue, n, wait[draw(&state) % WAITS]);
  hold(queue, kind, count, 2 * (uint64_t)count, wait, &state);
  const double cost = hold(queue, kind, count, steps, wait, &state);
  *bytes = kind->bytes(queue);
  kind->free(queue);
  free(plan);
  return cost - overhead(count, steps, wait);
}

int main(void) {
  static const double hints[HINTS] = {1.0, 1e-3, 1e3};
  static const uint32_t counts[] = {1000, 3500, 10000, 100000, 1000000};
  double *wait = make_waits();
  printf("%-10s %8s %15s %15s %15s %11s\n", "list", "balls", "ns/collision", "hint / 1000",
         "hint * 1000", "bytes/ball");
  for (int k = 0; k < EM_LISTS_COUNT; k++) {
    const struct em_queue_kind *kind = em_queue_find((enum em_lists)k);
    for (size_t c = 0; c < sizeof counts / sizeof counts[0]; c++) {
      size_t bytes = 0;
      printf("%-10s %8u", kind->name, counts[c]);
      for (int h = 0; h < HINTS; h++)
        printf(" %15.1f", 1e9 * measure(kind, counts[c], hints[h] / counts[c], wait, &bytes));
      printf(" %11.1f\n", (double)bytes / counts[c]);
    }
  }
  free(wait);
  return 0;
}
