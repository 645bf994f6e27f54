/* Worlds for tests, and what is asked of them again and again. */
#include "support/trial.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { OVERRIDES = 64, TEXT = 8192 };

static void must(enum em_status status, const struct em_error *err) {
  if (status) fail_msg("%s: %s", em_error_text(status), err->text);
}

static void read_scene(struct trial *t, const char *scene, char *words) {
  const char *override[OVERRIDES];
  size_t count = 0;
  char *rest = words;
  for (char *word; (word = strsep(&rest, " ")) && count < OVERRIDES;)
    if (*word) override[count++] = word;
  const size_t length = strlen(scene);
  memset(t, 0, sizeof *t);
  if (length > 4 && strcmp(scene + length - 4, ".cfg") == 0)
    must(em_scene_read(&t->scene, scene, count, override, &t->err), &t->err);
  else
    must(em_scene_parse(&t->scene, scene, "trial", count, override, &t->err), &t->err);
}

#define READ(t, scene, format)                    \
  do {                                            \
    char words[TEXT];                             \
    va_list list;                                 \
    va_start(list, format);                       \
    vsnprintf(words, sizeof words, format, list); \
    va_end(list);                                 \
    read_scene(t, scene, words);                  \
  } while (0)

void trial_scene(struct trial *t, const char *scene, const char *format, ...) {
  READ(t, scene, format);
}

void trial_balls(struct trial *t) {
  must(em_start_make(&t->balls, t->scene, NULL, NULL, &t->err), &t->err);
}

void trial_world(struct trial *t) {
  must(em_world_new(&t->world, t->scene, t->balls, &t->err), &t->err);
}

void trial_open(struct trial *t, const char *scene, const char *format, ...) {
  READ(t, scene, format);
  trial_balls(t);
  trial_world(t);
}

void trial_free(struct trial *t) {
  em_world_free(t->world);
  em_start_free(t->balls);
  em_scene_free(t->scene);
  memset(t, 0, sizeof *t);
}

void trial_run(struct trial *t, double until) {
  must(em_world_run(t->world, until, NULL, &t->err), &t->err);
}

void trial_collide(struct trial *t, uint64_t count) {
  must(em_world_run_collisions(t->world, INFINITY, count, NULL, &t->err), &t->err);
}

void trial_valid(struct trial *t, double tolerance) {
  if (!em_world_is_valid(t->world, tolerance, &t->err))
    fail_msg("at %.17g s: %s", em_world_time(t->world), t->err.text);
}

void trial_state(struct trial *t) {
  em_world_state(t->world, em_world_time(t->world), t->balls);
}

double trial_energy(struct trial *t) {
  trial_state(t);
  const struct em_balls *b = t->balls;
  long double sum = 0.0L, rest = 0.0L; /* a million equal terms do not add up even in 64 bits */
  for (size_t i = 0; i < b->count; i++) {
    const double inertia = 0.4 * b->radius[i] * b->radius[i];
    const double spin = inertia * em_vec_norm2(b->spin[i]);
    const double fall = em_vec_dot(t->scene->gravity, b->position[i]);
    const long double energy =
        (long double)b->mass[i] * (0.5 * (em_vec_norm2(b->velocity[i]) + spin) - fall);
    const long double next = sum + (energy - rest);
    rest = (next - sum) - (energy - rest);
    sum = next;
  }
  const struct em_energy e = em_world_energy(t->world, b);
  const double whole = e.kinetic + e.spin + fabs(e.potential);
  assert_true(fabsl(sum - e.kinetic - e.spin - e.potential) <= 1e-15L * whole);
  return (double)sum;
}

double trial_books(struct trial *t, double energy0) {
  const struct em_tally *tally = em_world_tally(t->world);
  double lost = 0.0, work = tally->drum_work;
  for (int k = 0; k < EM_CLASS_COUNT; k++)
    lost += tally->lost[k];
  for (size_t k = 0; k < em_world_blade_count(t->world); k++)
    work += em_world_blade_tally(t->world, k)->work;
  const double energy = trial_energy(t);
  return (energy + lost - work - energy0) / (fabs(energy0) + fabs(lost) + fabs(work));
}

/* --- trails ----------------------------------------------------------------------------------- */

static uint64_t mix(uint64_t hash, const void *data, size_t size) {
  uint64_t word = 0;
  memcpy(&word, data, size);
  hash = (hash ^ word) * 0x9E3779B97F4A7C15u;
  return hash ^ (hash >> 29);
}

static uint64_t mix_vec(uint64_t hash, const struct em_vec *v) {
  return mix(mix(mix(hash, &v->x, 8), &v->y, 8), &v->z, 8);
}

static void follow(void *self, const struct em_contact *c) {
  struct trail *trail = self;
  uint64_t h = mix(trail->hash, &c->time, 8);
  h = mix(h, &c->cls, sizeof c->cls);
  h = mix(mix(h, &c->ball, 4), &c->partner, 4);
  h = mix_vec(mix_vec(h, &c->place), &c->normal);
  trail->hash = mix(mix(mix(mix(h, &c->vn, 8), &c->vt, 8), &c->lost, 8), &c->work, 8);
  trail->count++;
  trail->last = c->time;
}

void trail_watch(struct trail *trail, struct em_world *world) {
  const struct em_observer observer = {trail, follow};
  *trail = (struct trail){1, 0, 0.0};
  assert_int_equal(em_world_observe(world, &observer), EM_OK);
}

/* Predictions are remade at a restart: what counts them is left out. */
uint64_t trail_of_state(const struct em_world *world) {
  struct em_snapshot *s;
  struct em_error err;
  must(em_world_snapshot(world, &s, &err), &err);
  uint64_t h = mix(mix(1, &s->epoch, 8), &s->clock, 8);
  for (uint32_t i = 0; i < s->count; i++) {
    h = mix_vec(mix_vec(h, &s->position[i]), &s->velocity[i]);
    h = mix(mix(mix(h, &s->time[i], 8), &s->last[i], 4), &s->streak[i], 4);
    if (s->spin) h = mix_vec(h, &s->spin[i]);
  }
  for (uint32_t k = 0; k < s->blade_count; k++) {
    h = mix(mix(h, &s->blade_angle[k], 8), &s->blade[k].work, 8);
    h = mix(mix(h, &s->blade[k].angular_impulse, 8), &s->blade[k].contacts, 8);
  }
  for (int k = 0; k < EM_CLASS_COUNT; k++) {
    h = mix(mix(h, &s->tally.collisions[k], 8), &s->tally.lost[k], 8);
    h = mix(h, &s->tally.collision_energy[k], 8);
    for (int b = 0; b < EM_TALLY_BINS; b++)
      h = mix(h, &s->tally.vn[k][b], 8);
  }
  h = mix(mix(mix(h, &s->tally.tc, 8), &s->tally.elastic, 8), &s->tally.jam, 8);
  em_world_snapshot_free(s);
  return h;
}

/* --- dice ------------------------------------------------------------------------------------- */

uint64_t dice_bits(uint64_t *seed) {
  uint64_t z = (*seed += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

double dice(uint64_t *seed) {
  return (double)(dice_bits(seed) >> 11) * 0x1p-53;
}

double dice_in(uint64_t *seed, double low, double high) {
  return low + (high - low) * dice(seed);
}

double dice_power(uint64_t *seed, double low, double high) {
  return low * pow(high / low, dice(seed));
}

struct em_vec dice_direction(uint64_t *seed) {
  const double z = dice_in(seed, -1.0, 1.0), phi = dice_in(seed, 0.0, 2.0 * M_PI);
  const double s = sqrt(1.0 - z * z);
  return em_vec_make(s * cos(phi), s * sin(phi), z);
}

uint64_t hard_tries(double few, double many) {
  const char *factor = getenv("EVENTMILL_TRIES");
  return (uint64_t)fmax(few, many * (factor ? atof(factor) : 1.0));
}

void hard_choose(void) {
  const char *name = getenv("EVENTMILL_CASE");
  if (name) cmocka_set_test_filter(name);
}

void hard_row(const char *name, const char *hard, double tries, const char *checked,
              const char *worst, ...) {
  char text[256];
  va_list list;
  va_start(list, worst);
  vsnprintf(text, sizeof text, worst, list);
  va_end(list);
  printf("| %s | %s | %.0f | %s | %s |\n", name, hard, tries, checked, text);
  fflush(stdout);
}
