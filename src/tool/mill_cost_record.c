/* What recording costs: whole runs that write a file, against one that writes only its end. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#include "eventmill/recorder.h"
#include "tool/mill_cost.h"

/* s of computing by this process: a file may have a thread of its own. */
static double clock_now(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A scene that records nothing but what the variant (NULL: none) asks for. */
static enum em_status read_scene(const struct em_cost *cost, const struct em_cost_variant *variant,
                                 double time, struct em_scene **scene, struct em_error *err) {
  char duration[64];
  const char *word[6 + EM_COST_WORDS] = {"record.frames=0.0",     "record.observables=0.0",
                                         "record.histograms=0.0", "record.collisions=false",
                                         "record.checkpoint=1e9", duration};
  size_t n = 6;
  for (size_t k = 0; variant && k < variant->words; k++)
    word[n++] = variant->word[k];
  snprintf(duration, sizeof duration, "duration=%.17g", time);
  return em_mill_cost_scene_with(cost, n, word, scene, err);
}

/* An empty file, where TMPDIR says. Errors: EM_FILE. */
static enum em_status make_file(char *path, size_t size, struct em_error *err) {
  const char *folder = getenv("TMPDIR");
  const int n = snprintf(path, size, "%s/mill-cost-XXXXXX", folder && *folder ? folder : "/tmp");
  const int file = n < (int)size ? mkstemp(path) : -1;
  if (file < 0) return em_error_set(err, EM_FILE, path, 0, "cannot be created");
  close(file);
  return EM_OK;
}

static enum em_status run(const struct em_cost *cost, const struct em_cost_variant *variant,
                          double time, double *spent, struct em_error *err) {
  char path[EM_SCENE_PATH];
  enum em_status status = make_file(path, sizeof path, err);
  if (status) return status;
  struct em_scene *scene = NULL;
  status = read_scene(cost, variant, time, &scene, err);
  const struct em_recorder_options options = {.path = path, .force = true, .stop = cost->stop};
  const double from = clock_now();
  if (!status) status = em_recorder_run(scene, &options, NULL, NULL, err);
  *spent = clock_now() - from;
  em_scene_free(scene);
  remove(path);
  return status;
}

enum em_status em_mill_cost_record(const struct em_cost *cost, struct em_cost_result *result,
                                   struct em_error *err) {
  enum { BARE_START, BARE_RUN, FULL_START, FULL_RUN, KINDS };
  double least[KINDS] = {INFINITY, INFINITY, INFINITY, INFINITY}, low = INFINITY, high = 0.0;
  for (int r = 0; r < EM_COST_WHOLE_RUNS * cost->rounds; r++) {
    double spent[KINDS];
    for (int n = 0; n < KINDS; n++) {
      const int k = r % 2 ? KINDS - 1 - n : n; /* forth and back: a drift of the machine cancels */
      const enum em_status status = run(cost, k >= FULL_START ? &result->variant : NULL,
                                        k % 2 ? cost->time : 0.0, &spent[k], err);
      if (status) return status;
      least[k] = fmin(least[k], spent[k]);
      em_mill_cost_tell(cost, "whole runs");
    }
    const double ratio =
        (spent[FULL_RUN] - spent[FULL_START]) / (spent[BARE_RUN] - spent[BARE_START]);
    low = fmin(low, ratio);
    high = fmax(high, ratio);
  }
  result->time = (least[FULL_RUN] - least[FULL_START]) / (least[BARE_RUN] - least[BARE_START]);
  result->time_low = fmin(low, result->time);
  result->time_high = fmax(high, result->time);
  if (least[BARE_RUN] - least[BARE_START] < EM_COST_LEAST_RUN)
    result->time = result->time_low = result->time_high = NAN;
  return EM_OK;
}
