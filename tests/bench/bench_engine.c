/* Collisions per second of the engine, and what it does for each: the reference mill at 1700 rpm,
 * and gases of 10³ … 10⁶ balls. Without a case all:
 * bench_engine [CASE [COLLISIONS [KEY=VALUE ...]]] */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <gsl/gsl_randist.h>

#include "eventmill/world.h"

static const char mill[] = "geometries/simoloyer-2l.cfg";

static const char gas[] =
    "duration = 1e9; gravity = \"none\";"
    "chamber = { shape = \"box\"; size = [%.9f, %.9f, %.9f]; periodic = %s; };"
    "balls = { count = %zu; diameter = 1.0; density = 1.909859317; speed = 1.0; start = \"%s\"; };"
    "contact = { rule = \"smooth\"; normal = 1.0; };";

struct item {
  const char *name;
  size_t count; /* 0: the mill */
  double phi;   /* packing fraction */
  bool periodic;
  const char *overrides; /* separated by spaces */
  double warm, measured; /* collisions per ball */
};

/* The mill is measured over 0.2 s from its steady state on. */
static const struct item items[] = {
    {"mill", 0, 0.0, false, "rotor.rpm=1700 contact.rule=reichardt2005 contact.tangential=0.9", 0.3,
     0.2},
    {"mill, rough", 0, 0.0, false, "rotor.rpm=1700", 0.3, 0.2},
    {"mill, smooth", 0, 0.0, false, "rotor.rpm=1700 contact.rule=smooth", 0.3, 0.2},
    {"gas 1e3 0.1", 1000, 0.1, true, "", 200, 600},
    {"gas 1e3 0.3", 1000, 0.3, true, "", 200, 600},
    {"gas 1e3 0.5", 1000, 0.5, true, "", 200, 600},
    {"gas 4e3 0.3", 4000, 0.3, true, "", 100, 200},
    {"gas 4e3 0.3 gravity", 4000, 0.3, false, "gravity=[0,0,-0.05]", 100, 200},
    {"gas 4e3 0.3 spin", 4000, 0.3, true, "contact.rule=rough contact.tangential=-1", 100, 200},
    {"gas 1e4 0.1", 10000, 0.1, true, "", 40, 80},
    {"gas 1e4 0.3", 10000, 0.3, true, "", 40, 80},
    {"gas 1e4 0.5", 10000, 0.5, true, "", 40, 80},
    {"gas 1e5 0.1", 100000, 0.1, true, "", 10, 10},
    {"gas 1e5 0.3", 100000, 0.3, true, "", 10, 10},
    {"gas 1e5 0.5", 100000, 0.5, true, "", 10, 10},
    {"gas 1e6 0.1", 1000000, 0.1, true, "", 4, 3},
    {"gas 1e6 0.3", 1000000, 0.3, true, "", 4, 3},
    {"gas 1e6 0.5", 1000000, 0.5, true, "", 4, 3},
};

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void quit(const struct em_error *err) {
  fprintf(stderr, "%s\n", err->text);
  exit(1);
}

static struct em_scene *scene_of(const struct item *item, size_t extra, char **more) {
  struct em_scene *scene;
  struct em_error err = {0};
  char *words = strdup(item->overrides), *save = NULL;
  const char *override[16];
  size_t n = 0;
  for (char *w = strtok_r(words, " ", &save); w && n < 8; w = strtok_r(NULL, " ", &save))
    override[n++] = w;
  for (size_t k = 0; k < extra && n < 16; k++)
    override[n++] = more[k];
  enum em_status status;
  if (item->count == 0) {
    status = em_scene_read(&scene, mill, n, override, &err);
  } else {
    char text[1024];
    const double edge = cbrt((double)item->count * M_PI / 6.0 / item->phi);
    const bool lattice = item->count > 100000 && item->phi > 0.4;
    snprintf(text, sizeof text, gas, edge, edge, edge, item->periodic ? "true" : "false",
             item->count, lattice ? "lattice" : "uniform");
    status = em_scene_parse(&scene, text, item->name, n, override, &err);
  }
  if (status) quit(&err);
  free(words);
  return scene;
}

/* A function of its own, so that a profiler can be told to look at nothing else. */
__attribute__((noinline)) static enum em_status
measured(struct em_world *w, double until, uint64_t collisions, struct em_error *err) {
  return em_world_run_collisions(w, until, collisions, NULL, err);
}

static void print_head(void) {
  printf("%-20s %9s %8s %9s %6s %6s %6s %6s %6s  %s\n", "case", "coll./s", "ns/coll.", "cand./pr.",
         "pred.", "stale", "moves", "blades", "bytes", "variant");
  printf("%-20s %9s %8s %9s %27s %6s %6s\n", "", "", "", "", "per collision", "", "/ball");
}

/* Balls of one kind in random order, as they stand after a long run: they start in that of a
 * lattice, which memory is faster with. */
static void shuffle(struct em_balls *balls) {
  gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
  if (!random) exit(1);
  gsl_ran_shuffle(random, balls->position, balls->count, sizeof *balls->position);
  gsl_rng_free(random);
}

static void bench(const struct item *item, double limit, size_t extra, char **more) {
  struct em_scene *scene = scene_of(item, extra, more);
  struct em_balls *balls;
  struct em_world *w;
  struct em_error err = {0};
  if (em_start_make(&balls, scene, NULL, NULL, &err)) quit(&err);
  if (item->count) shuffle(balls);
  if (em_world_new(&w, scene, balls, &err)) quit(&err);
  const double half = 0.5 * (double)item->count;
  const bool timed = item->count == 0;
  if (em_world_run_collisions(w, timed ? item->warm : INFINITY,
                              timed ? UINT64_MAX : (uint64_t)(item->warm * half), NULL, &err))
    quit(&err);
  struct em_tally *before = malloc(sizeof *before);
  if (!before) exit(1);
  *before = *em_world_tally(w);
  const uint64_t from = em_world_collisions(w);
  const uint64_t most = limit > 0.0 ? (uint64_t)limit
                        : timed     ? UINT64_MAX
                                    : (uint64_t)(item->measured * half);
  const double start = now();
  if (measured(w, timed ? item->warm + item->measured : INFINITY, most, &err)) quit(&err);
  const double time = now() - start, n = (double)(em_world_collisions(w) - from);
  const struct em_tally *t = em_world_tally(w);
  const double predictions = (double)(t->predictions - before->predictions);
  printf("%-20s %9.0f %8.0f %9.2f %6.3f %6.3f %6.3f %6.3f %6.0f  %s\n", item->name, n / time,
         1e9 * time / n, (double)(t->candidates - before->candidates) / predictions,
         predictions / n, (double)(t->stale - before->stale) / n,
         (double)(t->transfers - before->transfers) / n,
         (double)(t->blade_searches - before->blade_searches) / n, em_world_bytes_per_ball(w),
         em_world_variant(w));
  fflush(stdout);
  free(before);
  em_world_free(w);
  em_start_free(balls);
  em_scene_free(scene);
}

int main(int argc, char **argv) {
  const char *chosen = argc > 1 ? argv[1] : NULL;
  const double limit = argc > 2 ? atof(argv[2]) : 0.0;
  bool found = false;
  print_head();
  for (size_t k = 0; k < sizeof items / sizeof *items; k++) {
    const struct item *item = &items[k];
    if (chosen && strcmp(chosen, item->name) != 0) continue;
    found = true;
    bench(item, limit, argc > 3 ? (size_t)(argc - 3) : 0, argv + 3);
  }
  if (found) return 0;
  fprintf(stderr, "bench_engine: no case '%s'\n", chosen);
  return 2;
}
