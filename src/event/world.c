/* A world: made from a scene, run from event to event, asked for its state. */
#include "eventmill/world.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "event/body.h"
#include "event/collapse.h"
#include "event/partition.h"

/* --- making ----------------------------------------------------------------------------------- */

static unsigned flags_of(unsigned effects) {
  unsigned flags = 0;
  if (effects & EM_EFFECT_GRAVITY) flags |= EM_LOOP_GRAVITY;
  if (effects & EM_EFFECT_SPIN) flags |= EM_LOOP_SPIN;
  if (effects & EM_EFFECT_ROTOR) flags |= EM_LOOP_ROTOR;
  if (effects & EM_EFFECT_PERIODIC) flags |= EM_LOOP_PERIODIC;
  if (effects & (EM_EFFECT_TC | EM_EFFECT_ELASTIC | EM_EFFECT_JAM | EM_EFFECT_RAMPS |
                 EM_EFFECT_TURNING | EM_EFFECT_FACETS))
    flags |= EM_LOOP_EXTRA;
  return flags;
}

static void set_chamber(struct em_world *w) {
  const struct em_chamber *c = &w->scene->chamber;
  em_scene_bounds(w->scene, &w->low, &w->high);
  w->drum = c->shape == EM_SHAPE_DRUM;
  w->rho = 0.5 * c->diameter;
  w->drum_omega = c->rpm * M_PI / 30.0;
  w->facets = w->drum ? (uint32_t)c->facets : 0;
  const struct em_vec extent = em_vec_sub(w->high, w->low);
  const double edge[3] = {extent.x, extent.y, extent.z};
  double period[3] = {0.0, 0.0, 0.0};
  for (int k = 0; k < 3; k++) {
    const bool open = !w->drum && c->periodic[k];
    const bool plane = !open && (!w->drum || k == 1);
    if (open) period[k] = edge[k];
    w->wall[2 * k] = w->wall[2 * k + 1] = plane;
    w->walls = w->walls || plane;
  }
  w->wall[EM_WALL_DRUM] = w->drum;
  w->period = em_vec_make(period[0], period[1], period[2]);
  w->per_period =
      em_vec_make(period[0] > 0.0 ? 1.0 / period[0] : 0.0, period[1] > 0.0 ? 1.0 / period[1] : 0.0,
                  period[2] > 0.0 ? 1.0 / period[2] : 0.0);
}

static bool set_facets(struct em_world *w) {
  if (w->facets == 0) return true;
  w->facet = em_body_array(w->facets, sizeof *w->facet);
  for (uint32_t k = 0; w->facet && k < w->facets; k++) {
    const double angle = 2.0 * M_PI * k / w->facets;
    w->facet[k] = em_vec_make(-sin(angle), 0.0, -cos(angle));
  }
  return w->facet;
}

/* How contact times are found; what goes beyond the fastest way is compiled with the remedies. */
static unsigned set_roots(struct em_world *w) {
  const struct em_engine *e = &w->scene->engine;
  w->special_roots = em_surface_roots_special(&e->roots);
  w->special_drum = w->special_roots || w->facets > 0;
  w->exact_pairs = e->roots.polish != EM_POLISH_NONE;
  /* Balls that are taken to fly straight miss their path by a fortieth of the shortcut. */
  w->content = (4.0 * e->roots.tolerance + 0.1 * e->roots.shortcut) * w->largest;
  w->vectors = e->simd && !w->exact_pairs;
  return w->special_drum ? EM_LOOP_EXTRA : 0;
}

static void set_blade(struct em_turning *t, const struct em_blade *b) {
  t->blade = *b;
  t->hull = hypot(b->reach, b->radius);
  t->swing = fabs(b->omega) * t->hull;
  t->e3 = em_vec_cross(b->axis, b->e1);
  t->cos = cos(b->angle);
  t->sin = sin(b->angle);
}

static bool set_blades(struct em_world *w) {
  w->blade_count = (uint32_t)em_scene_blade_count(w->scene);
  const uint32_t few = w->blade_count < EM_NEAR_MANY ? w->blade_count : EM_NEAR_MANY;
  w->few_blades = EM_NEAR_BLADE(few) - 1;
  w->blade = em_body_array(w->blade_count, sizeof *w->blade);
  w->blade_tally = em_body_array(w->blade_count, sizeof *w->blade_tally);
  if (!w->blade || !w->blade_tally) return false;
  uint32_t k = 0;
  for (size_t r = 0; r < w->scene->rotor_count; r++)
    for (size_t b = 0; b < w->scene->rotor[r].blade_count; b++)
      set_blade(&w->blade[k++], &w->scene->rotor[r].blade[b]);
  return true;
}

/* Epochs of about 64 diameters' flight keep the rounding of times below 1e-14 diameters. */
static void set_times(struct em_world *w) {
  const double speed = em_scene_typical_speed(w->scene);
  const double d = w->count ? 2.0 * w->smallest : em_vec_norm(em_vec_sub(w->high, w->low));
  w->epoch_length = exp2(nearbyint(log2(64.0 * d / speed)));
  w->late = 0x1p-40 * w->epoch_length;
  w->within = w->scene->remedy.jam_within;
}

static bool take_arrays(struct em_world *w, bool spin, bool mixed) {
  w->body = em_body_array(w->count, sizeof *w->body);
  w->plan = em_body_array(w->count, sizeof *w->plan);
  if (spin) w->spin = em_body_array(w->count, sizeof *w->spin);
  if (mixed) w->mass = em_body_array(w->count, sizeof *w->mass);
  return w->body && w->plan && (w->spin || !spin) && (w->mass || !mixed);
}

static void set_balls(struct em_world *w, const struct em_balls *balls) {
  w->smallest = INFINITY;
  for (uint32_t i = 0; i < w->count; i++) {
    const struct em_vec x = balls->position[i], v = balls->velocity[i];
    w->body[i] = (struct em_body){x.x, x.y, x.z, v.x, v.y, v.z, 0.0, balls->radius[i]};
    w->plan[i].last = EM_NOBODY;
    w->largest = fmax(w->largest, balls->radius[i]);
    w->smallest = fmin(w->smallest, balls->radius[i]);
    if (w->spin) w->spin[i] = balls->spin[i];
    if (w->mass) w->mass[i] = balls->mass[i];
  }
  if (w->count) w->mass0 = balls->mass[0];
}

/* How many doubles the loop works on at a time. */
static unsigned lanes_of(const struct em_engine *engine) {
#ifdef EM_HAVE_AVX2
  const bool wide = engine->lanes == 0 || engine->lanes == 8;
  if (!engine->simd) return 1;
  if (wide && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl"))
    return 8;
  if (__builtin_cpu_supports("avx2")) return 4;
#endif
  (void)engine;
  return 1;
}

/* Everything that is worked out from the scene's species must be true of the balls. */
static enum em_status check_balls(const struct em_scene *scene, const struct em_balls *balls,
                                  struct em_error *err) {
  if (balls->count != em_scene_ball_count(scene))
    return em_error_set(err, EM_INPUT, scene->file, 0, "%zu balls, expected the scene's %zu",
                        balls->count, em_scene_ball_count(scene));
  size_t i = 0;
  for (size_t k = 0; k < scene->species_count; k++) {
    const struct em_species *s = &scene->species[k];
    const double r = 0.5 * s->diameter, m = em_start_mass(s);
    for (const size_t end = i + s->count; i < end; i++)
      if (balls->radius[i] != r || balls->mass[i] != m)
        return em_error_set(err, EM_INPUT, scene->file, 0,
                            "ball %zu has a radius of %.6g m and a mass of %.6g kg, expected "
                            "%.6g m and %.6g kg, as the species \"%s\" has",
                            i, balls->radius[i], balls->mass[i], r, m, s->name);
  }
  return EM_OK;
}

/* A world with its balls, but without lists. */
static enum em_status begin(struct em_world **world, const struct em_scene *scene,
                            const struct em_balls *balls, struct em_error *err) {
  const unsigned effects = em_scene_effects(scene);
  if (balls->count > EM_BALLS_MOST)
    return em_error_set(err, EM_INPUT, scene->file, 0, "balls: %zu are too many; at most %d",
                        balls->count, EM_BALLS_MOST);
  const enum em_status status = check_balls(scene, balls, err);
  if (status) return status;
  struct em_world *w = calloc(1, sizeof *w);
  if (!w) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the world");
  w->scene = scene;
  w->count = (uint32_t)balls->count;
  w->gravity = scene->gravity;
  w->fall = em_vec_norm(scene->gravity);
  set_chamber(w);
  if (!take_arrays(w, effects & EM_EFFECT_SPIN, effects & EM_EFFECT_MIXED) || !set_blades(w) ||
      !set_facets(w)) {
    em_world_free(w);
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for %zu balls", balls->count);
  }
  set_balls(w, balls);
  set_times(w);
  w->loop = em_loop_find(flags_of(effects) | set_roots(w), lanes_of(&scene->engine));
  assert(w->loop); /* a scene has no rotor in a periodic box */
  *world = w;
  return EM_OK;
}

/* Makes all lists from the state of the balls. */
static enum em_status set_lists(struct em_world *w, struct em_error *err) {
  const struct em_scene *scene = w->scene;
  const double spacing =
      2.0 * w->smallest / em_scene_typical_speed(scene) / fmax(1.0, (double)w->count);
  w->queue_kind = em_queue_find(scene->engine.lists);
  w->local_kind = em_local_find(scene->engine.lists);
  w->partition_kind = em_partition_find(w);
  w->cells = w->partition_kind == &em_partition_cells;
  w->calendar = w->queue_kind == &em_queue_calendar;
  w->keeps_all = w->local_kind->keeps_all;
  w->joins = w->vectors && !w->keeps_all && w->partition_kind->lasting;
  w->fetches_close = w->count >= EM_FETCH_CLOSE_FROM && w->count < EM_FETCH_FROM;
  w->queue = w->queue_kind->make(w->count, w->plan, spacing);
  w->local = w->local_kind->make(w->count, w->plan);
  if (!w->queue || !w->local)
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the event lists");
  return w->partition_kind->make(w, err);
}

static enum em_status predict_all(struct em_world *w, struct em_error *err) {
  if (w->loop->predict_all(w)) {
    assert(em_world_valid_lists(w));
    return EM_OK;
  }
  return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the event lists");
}

enum em_status em_world_new(struct em_world **world, const struct em_scene *scene,
                            const struct em_balls *balls, struct em_error *err) {
  struct em_world *w = NULL;
  enum em_status status = begin(&w, scene, balls, err);
  if (status) return status;
  status = set_lists(w, err);
  if (!status && !em_world_valid_balls(w, 1e-6 * w->smallest, err)) status = EM_INPUT;
  if (!status) status = predict_all(w, err);
  if (status) {
    em_world_free(w);
    return status;
  }
  *world = w;
  return EM_OK;
}

enum em_status em_world_resume(struct em_world **world, const struct em_scene *scene,
                               const struct em_snapshot *snapshot, struct em_error *err) {
  struct em_world *w = NULL;
  struct em_balls *balls = NULL;
  enum em_status status = em_world_snapshot_balls(scene, snapshot, &balls, err);
  if (status) return status;
  status = begin(&w, scene, balls, err);
  em_start_free(balls);
  if (status) return status;
  em_world_snapshot_restore(w, snapshot);
  status = em_world_valid_restart(w, err) ? set_lists(w, err) : EM_INPUT;
  if (!status) status = predict_all(w, err);
  if (status) {
    em_world_free(w);
    return status;
  }
  *world = w;
  return EM_OK;
}

void em_world_free(struct em_world *w) {
  if (!w) return;
  if (w->queue) w->queue_kind->free(w->queue);
  if (w->local) w->local_kind->free(w->local);
  if (w->places) w->partition_kind->free(w->places);
  free(w->body);
  free(w->plan);
  em_ties_free(&w->ties);
  free(w->spin);
  free(w->mass);
  free(w->blade);
  free(w->facet);
  free(w->blade_tally);
  free(w->observer);
  free(w);
}

enum em_status em_world_observe(struct em_world *w, const struct em_observer *observer) {
  struct em_observer *more = realloc(w->observer, (w->observers + 1) * sizeof *more);
  if (!more) return EM_MEMORY;
  w->observer = more;
  w->observer[w->observers++] = *observer;
  return EM_OK;
}

/* --- running ---------------------------------------------------------------------------------- */

static double local_time(const struct em_world *w, double time) {
  return (time - w->origin) - (double)w->epoch * w->epoch_length;
}

/* Works off events before `limit` (s within the epoch), at most *left collisions; before the
 * numbers of contacts run out, they begin anew. */
static enum em_status run_before(struct em_world *w, double limit, uint64_t *left,
                                 const volatile sig_atomic_t *stop, struct em_error *err) {
  for (;;) {
    const uint64_t room = UINT32_MAX - w->contacts;
    uint64_t some = *left < room ? *left : room;
    *left -= some;
    enum em_status status = w->loop->run(w, limit, &some, stop, err);
    *left += some;
    if (status || some > 0 || *left == 0) return status;
    status = predict_all(w, err);
    if (status) return status;
  }
}

/* Does no ball move, nor will it? */
static bool is_idle(const struct em_world *w) {
  double time;
  uint32_t rival;
  return w->queue_kind->first(w->queue, &time, &rival) == EM_QUEUE_NOBODY;
}

enum em_status em_world_run_collisions(struct em_world *w, double until, uint64_t count,
                                       const volatile sig_atomic_t *stop, struct em_error *err) {
  uint64_t left = count;
  if (isnan(until))
    return em_error_set(err, EM_INPUT, NULL, 0, "the time to run to is not a number");
  while (left > 0) {
    if (stop && *stop) return em_error_set(err, EM_STOPPED, NULL, 0, "stopped on request");
    const double limit = local_time(w, until);
    const bool shift = limit >= w->epoch_length;
    const enum em_status status = run_before(w, shift ? w->epoch_length : limit, &left, stop, err);
    if (status) return status;
    if (until == INFINITY && is_idle(w)) break;
    if (left > 0) w->clock = fmax(w->clock, shift ? w->epoch_length : limit);
    if (!shift || left == 0) break;
    if (!em_body_next_epoch(w))
      return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the event lists");
    assert(em_world_valid_lists(w));
  }
  return EM_OK;
}

enum em_status em_world_run(struct em_world *w, double until, const volatile sig_atomic_t *stop,
                            struct em_error *err) {
  return em_world_run_collisions(w, until, UINT64_MAX, stop, err);
}

/* --- asking ----------------------------------------------------------------------------------- */

double em_world_time(const struct em_world *w) {
  return em_body_absolute(w, w->clock);
}

size_t em_world_count(const struct em_world *w) {
  return w->count;
}

size_t em_world_blade_count(const struct em_world *w) {
  return w->blade_count;
}

uint64_t em_world_collisions(const struct em_world *w) {
  uint64_t sum = 0;
  for (int k = 0; k < EM_CLASS_COUNT; k++)
    sum += w->tally.collisions[k];
  return sum;
}

const struct em_tally *em_world_tally(const struct em_world *w) {
  return &w->tally;
}

const struct em_blade_tally *em_world_blade_tally(const struct em_world *w, size_t blade) {
  return &w->blade_tally[blade];
}

void em_world_state(const struct em_world *w, double time, struct em_balls *balls) {
  const double t = local_time(w, time);
  size_t i = 0;
  for (size_t s = 0; s < w->scene->species_count; s++)
    for (size_t k = 0; k < w->scene->species[s].count && i < w->count; k++)
      balls->species[i++] = (uint16_t)s;
  for (i = 0; i < w->count; i++) {
    balls->position[i] = em_body_wrap(w, em_body_at(w, (uint32_t)i, t));
    balls->velocity[i] = em_body_velocity(w, (uint32_t)i, t);
    balls->spin[i] = w->spin ? w->spin[i] : em_vec_make(0.0, 0.0, 0.0);
    balls->radius[i] = w->body[i].radius;
    balls->mass[i] = w->mass ? w->mass[i] : w->mass0;
  }
}

/* A sum of many terms, and what rounding has taken from it (Neumaier): a million equal terms do not
 * add up otherwise. */
struct total {
  double sum, rest;
};

static void add(struct total *t, double x) {
  const double sum = t->sum + x;
  t->rest += fabs(t->sum) >= fabs(x) ? (t->sum - sum) + x : (x - sum) + t->sum;
  t->sum = sum;
}

struct em_energy em_world_energy(const struct em_world *w, const struct em_balls *balls) {
  struct total kinetic = {0.0, 0.0}, spin = kinetic, potential = kinetic;
  for (size_t i = 0; i < balls->count; i++) {
    const double m = balls->mass[i], r = balls->radius[i];
    add(&kinetic, 0.5 * m * em_vec_norm2(balls->velocity[i]));
    add(&spin, 0.5 * (0.4 * m * r * r) * em_vec_norm2(balls->spin[i]));
    add(&potential, -m * em_vec_dot(w->gravity, balls->position[i]));
  }
  return (struct em_energy){kinetic.sum + kinetic.rest, spin.sum + spin.rest,
                            potential.sum + potential.rest};
}

double em_world_bin_edge(size_t k) {
  const int octave = (int)(k / EM_TALLY_PER_OCTAVE);
  const double part = (double)(k % EM_TALLY_PER_OCTAVE) / EM_TALLY_PER_OCTAVE;
  return ldexp(1.0 + part, octave + EM_TALLY_LOWEST);
}

const char *em_world_variant(const struct em_world *w) {
  return w->loop->name;
}

double em_world_bytes_per_ball(const struct em_world *w) {
  size_t each = sizeof *w->body + sizeof *w->plan;
  if (w->spin) each += sizeof *w->spin;
  if (w->mass) each += sizeof *w->mass;
  if (w->ties.tie) each += sizeof *w->ties.ball + sizeof *w->ties.tie;
  const size_t lists = w->queue_kind->bytes(w->queue) + w->local_kind->bytes(w->local) +
                       w->partition_kind->bytes(w->places);
  return w->count ? (double)each + (double)lists / w->count : 0.0;
}

double em_world_bytes_of_events(const struct em_world *w) {
  const size_t lists = w->queue_kind->bytes(w->queue) + w->local_kind->bytes(w->local);
  return w->count ? (double)sizeof *w->plan + (double)lists / w->count : 0.0;
}
