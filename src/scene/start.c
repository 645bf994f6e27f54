/* Makes the state in which a scene begins: who is where, and how fast. */
#include "eventmill/start.h"

#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/start_place.h"

struct em_balls *em_start_new(size_t count) {
  struct em_balls *b = calloc(1, sizeof *b);
  if (!b) return NULL;
  size_t n = count > 0 ? count : 1;
  b->count = count;
  b->position = calloc(n, sizeof *b->position);
  b->velocity = calloc(n, sizeof *b->velocity);
  b->spin = calloc(n, sizeof *b->spin);
  b->radius = calloc(n, sizeof *b->radius);
  b->mass = calloc(n, sizeof *b->mass);
  b->species = calloc(n, sizeof *b->species);
  if (b->position && b->velocity && b->spin && b->radius && b->mass && b->species) return b;
  em_start_free(b);
  return NULL;
}

void em_start_free(struct em_balls *balls) {
  if (!balls) return;
  free(balls->position);
  free(balls->velocity);
  free(balls->spin);
  free(balls->radius);
  free(balls->mass);
  free(balls->species);
  free(balls);
}

double em_start_mass(const struct em_species *species) {
  const double d = species->diameter;
  return species->density * M_PI / 6.0 * d * d * d;
}

/* What is being made. */
struct maker {
  const struct em_scene *scene;
  const struct em_balls *previous;
  const volatile sig_atomic_t *stop;
  struct em_balls *balls;
  struct em_start_field field;
  struct em_start_group *group; /* by species; `picked` holds those of one kind of start */
  struct em_start_group *picked;
  gsl_rng *rng;
  struct em_error *err;
};

static bool is_random(enum em_start start) {
  return start == EM_START_UNIFORM || start == EM_START_HALF;
}

static void fill_kinds(struct maker *m) {
  size_t k = 0;
  for (size_t s = 0; s < m->scene->species_count; ++s) {
    const struct em_species *species = &m->scene->species[s];
    m->group[s] = (struct em_start_group){species, s, k};
    const double d = species->diameter, mass = em_start_mass(species);
    for (size_t end = k + species->count; k < end; ++k) {
      m->balls->radius[k] = 0.5 * d;
      m->balls->mass[k] = mass;
      m->balls->species[k] = (uint16_t)s;
    }
  }
}

/* ---- given positions */

static void copy_table(struct maker *m, const struct em_start_group *g) {
  const struct em_species *s = g->species;
  for (size_t k = 0; k < s->count; ++k) {
    m->balls->position[g->first + k] = s->position[k];
    m->balls->velocity[g->first + k] = s->velocity[k];
    if (s->spin) m->balls->spin[g->first + k] = s->spin[k];
  }
}

/* Takes the previous run's balls of the same species number, in their order. */
static enum em_status copy_run(struct maker *m, const struct em_start_group *g) {
  const struct em_balls *old = m->previous;
  size_t taken = 0;
  for (size_t k = 0; old && k < old->count && taken < g->species->count; ++k)
    if (old->species[k] == g->number) {
      m->balls->position[g->first + taken] = old->position[k];
      m->balls->velocity[g->first + taken] = old->velocity[k];
      m->balls->spin[g->first + taken] = old->spin[k];
      ++taken;
    }
  if (taken == g->species->count) return EM_OK;
  return em_error_set(m->err, EM_INPUT, m->scene->file, 0,
                      "balls.%zu: %s holds %zu balls of this species, expected %zu", g->number,
                      g->species->from[0] ? g->species->from : "the run", taken, g->species->count);
}

/* Balls whose places are given may touch; they overlap when rounding does not explain it. */
static enum em_status put_given(struct maker *m, const struct em_start_group *g) {
  for (size_t k = g->first; k < g->first + g->species->count; ++k) {
    struct em_vec *r = &m->balls->position[k];
    *r = em_start_field_wrap(&m->field, *r);
    if (!em_start_field_fits(&m->field, k, *r, -EM_START_CLEARANCE))
      return em_error_set(m->err, EM_INPUT, m->scene->file, 0,
                          "balls.%zu: ball %zu at (%.6g, %.6g, %.6g) overlaps a wall, a blade or "
                          "another ball, expected it to be free",
                          g->number, k - g->first, r->x, r->y, r->z);
    em_start_field_put(&m->field, k);
  }
  return EM_OK;
}

static enum em_status place_given(struct maker *m) {
  enum em_status status = EM_OK;
  for (size_t s = 0; s < m->scene->species_count && status == EM_OK; ++s) {
    const struct em_start_group *g = &m->group[s];
    if (g->species->start == EM_START_TABLE)
      copy_table(m, g);
    else if (g->species->start == EM_START_RUN)
      status = copy_run(m, g);
    else
      continue;
    if (status == EM_OK) status = put_given(m, g);
  }
  return status;
}

/* ---- lattices and random places */

static bool same_region(const struct em_species *a, const struct em_species *b) {
  if (!a->has_region || !b->has_region) return a->has_region == b->has_region;
  return memcmp(&a->low, &b->low, sizeof a->low) == 0 &&
         memcmp(&a->high, &b->high, sizeof a->high) == 0;
}

static bool is_on_lattice(const struct em_species *s) {
  return s->start == EM_START_LATTICE && s->count > 0;
}

/* One lattice for all species that share a region. */
static enum em_status place_lattices(struct maker *m) {
  size_t n = m->scene->species_count;
  for (size_t s = 0; s < n; ++s) {
    size_t count = 0;
    bool first = is_on_lattice(m->group[s].species);
    for (size_t t = 0; t < n && first; ++t) {
      const struct em_species *other = m->group[t].species;
      if (!is_on_lattice(other) || !same_region(m->group[s].species, other)) continue;
      if (t < s) first = false;
      m->picked[count++] = m->group[t];
    }
    if (!first) continue;
    enum em_status status = em_start_lattice_fill(&m->field, count, m->picked, m->rng, m->err);
    if (status != EM_OK) return status;
  }
  return EM_OK;
}

static enum em_status place_random(struct maker *m) {
  size_t count = 0;
  for (size_t s = 0; s < m->scene->species_count; ++s)
    if (is_random(m->group[s].species->start) && m->group[s].species->count > 0)
      m->picked[count++] = m->group[s];
  return em_start_place_random(&m->field, count, m->picked, m->rng, m->err);
}

/* ---- velocities */

static bool gets_speed(const struct maker *m, size_t k) {
  enum em_start start = m->scene->species[m->balls->species[k]].start;
  return start != EM_START_TABLE && start != EM_START_RUN;
}

/* Along periodic edges no wall ever takes up momentum: what chance gave the balls is removed, and
 * the speeds are scaled back to the energy that was asked for. */
static void remove_drift(struct maker *m) {
  struct em_balls *b = m->balls;
  struct em_vec momentum = {0, 0, 0};
  double mass = 0.0, before = 0.0, after = 0.0;
  size_t n = 0;
  for (size_t k = 0; k < b->count; ++k)
    if (gets_speed(m, k)) {
      momentum = em_vec_axpy(momentum, b->mass[k], b->velocity[k]);
      before += b->mass[k] * em_vec_norm2(b->velocity[k]);
      mass += b->mass[k];
      ++n;
    }
  if (n < 2 || !(before > 0.0)) return;
  if (!m->field.periodic[0]) momentum.x = 0.0;
  if (!m->field.periodic[1]) momentum.y = 0.0;
  if (!m->field.periodic[2]) momentum.z = 0.0;
  for (size_t k = 0; k < b->count; ++k)
    if (gets_speed(m, k)) {
      b->velocity[k] = em_vec_axpy(b->velocity[k], -1.0 / mass, momentum);
      after += b->mass[k] * em_vec_norm2(b->velocity[k]);
    }
  double scale = after > 1e-12 * before ? sqrt(before / after) : 1.0;
  for (size_t k = 0; k < b->count; ++k)
    if (gets_speed(m, k)) b->velocity[k] = em_vec_scale(scale, b->velocity[k]);
}

static void set_velocities(struct maker *m) {
  for (size_t k = 0; k < m->balls->count; ++k) {
    if (!gets_speed(m, k)) continue;
    struct em_vec d;
    gsl_ran_dir_3d(m->rng, &d.x, &d.y, &d.z);
    double speed = m->scene->species[m->balls->species[k]].speed;
    m->balls->velocity[k] = em_vec_scale(speed, d);
  }
  const bool *periodic = m->field.periodic;
  if (periodic[0] || periodic[1] || periodic[2]) remove_drift(m);
}

/* ---- the whole */

static enum em_status place_all(struct maker *m) {
  fill_kinds(m);
  enum em_status status = em_start_field_make(&m->field, m->scene, m->balls, m->err);
  m->field.stop = m->stop;
  if (status == EM_OK) status = place_given(m);
  if (status == EM_OK) status = place_lattices(m);
  if (status == EM_OK) status = place_random(m);
  if (status == EM_OK) set_velocities(m);
  em_start_field_free(&m->field);
  return status;
}

enum em_status em_start_make(struct em_balls **balls, const struct em_scene *scene,
                             const struct em_balls *previous, const volatile sig_atomic_t *stop,
                             struct em_error *err) {
  *balls = NULL;
  size_t n = scene->species_count;
  struct maker m = {.scene = scene,
                    .previous = previous,
                    .stop = stop,
                    .balls = em_start_new(em_scene_ball_count(scene)),
                    .group = calloc(n + 1, sizeof *m.group),
                    .picked = calloc(n + 1, sizeof *m.picked),
                    .rng = gsl_rng_alloc(gsl_rng_mt19937),
                    .err = err};
  enum em_status status = EM_OK;
  if (!m.balls || !m.group || !m.picked || !m.rng) {
    status = em_error_set(err, EM_MEMORY, NULL, 0, "no memory for %zu balls",
                          em_scene_ball_count(scene));
  } else {
    gsl_rng_set(m.rng, (unsigned long)scene->seed);
    status = place_all(&m);
  }
  if (m.rng) gsl_rng_free(m.rng);
  free(m.group);
  free(m.picked);
  if (status == EM_OK)
    *balls = m.balls;
  else
    em_start_free(m.balls);
  return status;
}
