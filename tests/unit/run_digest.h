/* What tests of run files share: a small mill, and one number that stands for all that a run file
 * tells (what is told about the machine and the engine's own work left out). */
#ifndef EVENTMILL_TEST_RUN_DIGEST_H
#define EVENTMILL_TEST_RUN_DIGEST_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "eventmill/recorder.h"
#include "eventmill/run_file.h"
#include "eventmill/world.h"

#define SMALL_MILL                                                                          \
  "title = \"small mill\"; duration = 0.06; seed = 3; gravity = [0.0, 0.0, -9.81];\n"       \
  "chamber = { shape = \"drum\"; diameter = 0.06; length = 0.05; };\n"                      \
  "rotor = { rpm = 2000.0; radius = 0.003; reach = 0.02; blades = ( { y = 0.017; },\n"      \
  "  { y = 0.034; angle_deg = 90.0; } ); };\n"                                              \
  "balls = { count = 150; diameter = 0.004; density = 7850.0; speed = 2.0; };\n"            \
  "record = { frames = 200.0; observables = 500.0; histograms = 80.0; collisions = true;\n" \
  "  checkpoint = 1e-9; };\n"

static inline struct em_scene *digest_scene(const char *text, size_t count,
                                            const char *const *overrides) {
  struct em_scene *scene = NULL;
  struct em_error err = {0};
  if (em_scene_parse(&scene, text, "test.cfg", count, overrides, &err)) {
    fprintf(stderr, "%s\n", err.text);
    abort();
  }
  return scene;
}

static inline uint64_t digest_add(uint64_t digest, const void *data, size_t size) {
  const unsigned char *byte = data;
  for (size_t i = 0; i < size; i++)
    digest = (digest ^ byte[i]) * UINT64_C(1099511628211);
  return digest;
}

static inline enum em_status digest_frames(const struct em_run_file *file, uint64_t *d,
                                           struct em_error *err) {
  struct em_balls *b = NULL;
  enum em_status status = em_run_file_balls(file, &b, err);
  if (status) return status;
  const size_t n = b->count;
  *d = digest_add(*d, b->mass, n * sizeof *b->mass);
  *d = digest_add(*d, b->radius, n * sizeof *b->radius);
  *d = digest_add(*d, b->species, n * sizeof *b->species);
  for (size_t k = 0; k < em_run_file_frame_count(file) && !status; k++) {
    const double time = em_run_file_frame_time(file, k);
    status = em_run_file_frame(file, k, b, err);
    *d = digest_add(*d, &time, sizeof time);
    *d = digest_add(*d, b->position, n * sizeof *b->position);
    *d = digest_add(*d, b->velocity, n * sizeof *b->velocity);
    *d = digest_add(*d, b->spin, n * sizeof *b->spin);
  }
  em_start_free(b);
  return status;
}

static inline enum em_status digest_series(const struct em_run_file *file, uint64_t *d,
                                           struct em_error *err) {
  static const char *const names[] = {
      "kinetic_energy", "spin_energy",           "potential_energy", "median_speed", "mean_speed",
      "collisions",     "dissipated_energy",     "collision_energy", "blade_work",   "blade_torque",
      "blade_contacts", "blade_angular_impulse", "jam_contacts",     "resting_share"};
  enum em_status status = EM_OK;
  for (size_t i = 0; i < sizeof names / sizeof *names && !status; i++) {
    struct em_series *s = NULL;
    if (!em_run_file_has(file, names[i])) continue;
    status = em_run_file_series(file, names[i], &s, err);
    if (status) break;
    *d = digest_add(*d, s->time, s->count * sizeof *s->time);
    *d = digest_add(*d, s->value, s->count * s->width * sizeof *s->value);
    em_run_file_series_free(s);
  }
  return status;
}

static inline enum em_status digest_blocks(const struct em_run_file *file, uint64_t *d,
                                           struct em_error *err) {
  const size_t size = EM_CLASS_COUNT * em_run_file_bins(file) * sizeof(uint64_t);
  uint64_t *counts = malloc(size);
  enum em_status status = EM_OK;
  *d = digest_add(*d, em_run_file_edges(file), (em_run_file_bins(file) + 1) * sizeof(double));
  for (size_t k = 0; k < em_run_file_block_count(file) && !status; k++) {
    const double span[2] = {em_run_file_block_start(file, k), em_run_file_block_end(file, k)};
    status = em_run_file_block(file, k, counts, err);
    *d = digest_add(*d, span, sizeof span);
    *d = digest_add(*d, counts, size);
  }
  free(counts);
  return status;
}

static inline enum em_status digest_rows(const struct em_run_file *file, uint64_t *d,
                                         struct em_error *err) {
  struct em_rows *r = em_run_file_rows_new(EM_COLUMN_ALL);
  enum em_status status = EM_OK;
  for (uint64_t first = 0; !status; first += r->count) {
    status = em_run_file_rows(file, first, r, err);
    if (status || r->count == 0) break;
    *d = digest_add(*d, r->time, r->count * sizeof *r->time);
    *d = digest_add(*d, r->cls, r->count * sizeof *r->cls);
    *d = digest_add(*d, r->ball, r->count * sizeof *r->ball);
    *d = digest_add(*d, r->partner, r->count * sizeof *r->partner);
    *d = digest_add(*d, r->place, r->count * sizeof *r->place);
    *d = digest_add(*d, r->normal, r->count * sizeof *r->normal);
    *d = digest_add(*d, r->vn, r->count * sizeof *r->vn);
    *d = digest_add(*d, r->vt, r->count * sizeof *r->vt);
    *d = digest_add(*d, r->lost, r->count * sizeof *r->lost);
  }
  em_run_file_rows_free(r);
  return status;
}

static inline enum em_status digest_checkpoint(const struct em_run_file *file, uint64_t *d,
                                               struct em_error *err) {
  struct em_snapshot *s = NULL;
  const enum em_status status = em_run_file_checkpoint(file, &s, err);
  if (status) return status;
  const size_t n = s->count;
  *d = digest_add(*d, s->position, n * sizeof *s->position);
  *d = digest_add(*d, s->velocity, n * sizeof *s->velocity);
  if (s->spin) *d = digest_add(*d, s->spin, n * sizeof *s->spin);
  *d = digest_add(*d, s->time, n * sizeof *s->time);
  *d = digest_add(*d, s->last, n * sizeof *s->last);
  *d = digest_add(*d, s->streak, n * sizeof *s->streak);
  *d = digest_add(*d, s->blade_angle, s->blade_count * sizeof *s->blade_angle);
  *d = digest_add(*d, s->blade, s->blade_count * sizeof *s->blade);
  *d = digest_add(*d, &s->epoch, sizeof s->epoch);
  *d = digest_add(*d, &s->clock, sizeof s->clock);
  *d = digest_add(*d, s->tally.collisions, sizeof s->tally.collisions);
  *d = digest_add(*d, s->tally.lost, sizeof s->tally.lost);
  *d = digest_add(*d, s->tally.vn, sizeof s->tally.vn);
  em_world_snapshot_free(s);
  return EM_OK;
}

/* Reads everything. *digest tells two files apart that differ in anything. */
static inline enum em_status digest_run(const char *path, uint64_t *digest, struct em_error *err) {
  struct em_run_file *file = NULL;
  uint64_t d = UINT64_C(14695981039346656037);
  enum em_status status = em_run_file_open(&file, path, err);
  if (status) return status;
  const struct em_run_state *state = em_run_file_state(file);
  d = digest_add(d, em_run_file_scene_text(file), strlen(em_run_file_scene_text(file)));
  d = digest_add(d, &state->end, sizeof state->end);
  d = digest_add(d, state->message, strlen(state->message));
  d = digest_add(d, &state->time, sizeof state->time);
  d = digest_add(d, &state->collisions, sizeof state->collisions);
  d = digest_add(d, &state->energy_start, sizeof state->energy_start);
  status = digest_frames(file, &d, err);
  if (!status) status = digest_series(file, &d, err);
  if (!status) status = digest_blocks(file, &d, err);
  if (!status) status = digest_rows(file, &d, err);
  if (!status) status = digest_checkpoint(file, &d, err);
  em_run_file_close(file);
  *digest = d;
  return status;
}

/* A folder of its own for the test's files; its name is returned. */
static inline const char *digest_folder(void) {
  static char folder[] = "/tmp/eventmill-test-XXXXXX";
  static int made;
  if (!made && !mkdtemp(folder)) abort();
  made = 1;
  return folder;
}

/* A file in it; four names hold at a time. */
static inline const char *digest_path(const char *name) {
  static char path[4][256];
  static int next;
  char *to = path[next++ % 4];
  snprintf(to, sizeof path[0], "%s/%s", digest_folder(), name);
  return to;
}

static inline void digest_folder_remove(void) {
  char command[128];
  snprintf(command, sizeof command, "rm -rf %s", digest_folder());
  if (system(command) != 0) abort();
}

#endif
