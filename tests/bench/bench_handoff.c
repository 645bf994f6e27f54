/* What it costs to hand one piece of work to another core and to wait for its answer: the least
 * that two cores pay for each event on which they have to agree. Compare with what an event costs
 * (bench_engine). Usage: bench_handoff [ROUND_TRIPS] */
#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { LINE = 64 };

/* Question and answer, each on a cache line of its own. */
static struct {
  _Alignas(LINE) atomic_uint_fast64_t question;
  _Alignas(LINE) atomic_uint_fast64_t answer;
} shared;

static uint64_t trips = 1000000;

static void *answer_all(void *unused) {
  (void)unused;
  for (uint64_t k = 1; k <= trips; k++) {
    while (atomic_load_explicit(&shared.question, memory_order_acquire) != k)
      ;
    atomic_store_explicit(&shared.answer, k, memory_order_release);
  }
  return NULL;
}

int main(int argc, char **argv) {
  if (argc > 1) trips = strtoull(argv[1], NULL, 10);
  pthread_t other;
  if (pthread_create(&other, NULL, answer_all, NULL)) {
    fprintf(stderr, "bench_handoff: no second thread\n");
    return 1;
  }
  struct timespec start, end;
  clock_gettime(CLOCK_MONOTONIC, &start);
  for (uint64_t k = 1; k <= trips; k++) {
    atomic_store_explicit(&shared.question, k, memory_order_release);
    while (atomic_load_explicit(&shared.answer, memory_order_acquire) != k)
      ;
  }
  clock_gettime(CLOCK_MONOTONIC, &end);
  pthread_join(other, NULL);
  const double ns =
      1e9 * (double)(end.tv_sec - start.tv_sec) + (double)(end.tv_nsec - start.tv_nsec);
  printf("hand over and back: %.0f ns\n", ns / (double)trips);
  return 0;
}
