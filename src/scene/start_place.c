/* Places balls at random: by inverse transform in the drum, rejecting what overlaps. */
#include "scene/start_place.h"

#include <gsl/gsl_randist.h>
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

void em_start_place_box(const struct em_start_field *field, const struct em_species *species,
                        struct em_vec *low, struct em_vec *high) {
  double r = 0.5 * species->diameter;
  struct em_vec inset = em_vec_make(field->periodic[0] ? 0.0 : r, field->periodic[1] ? 0.0 : r,
                                    field->periodic[2] ? 0.0 : r);
  *low = em_vec_add(field->low, inset);
  *high = em_vec_sub(field->high, inset);
  if (species->start == EM_START_HALF)
    high->z = fmin(high->z, 0.5 * (field->low.z + field->high.z));
  if (!species->has_region) return;
  *low = em_vec_make(fmax(low->x, species->low.x), fmax(low->y, species->low.y),
                     fmax(low->z, species->low.z));
  *high = em_vec_make(fmin(high->x, species->high.x), fmin(high->y, species->high.y),
                      fmin(high->z, species->high.z));
}

static double between(double low, double high, gsl_rng *rng) {
  return low + gsl_rng_uniform(rng) * (high - low);
}

/* Uniform in the drum (13-2, corrected): distance from the axis ((D − d)/2) √u. */
static struct em_vec point_in_drum(const struct em_start_field *field,
                                   const struct em_species *species, gsl_rng *rng) {
  double rho = 0.5 * (field->scene->chamber.diameter - species->diameter);
  double r = rho * sqrt(gsl_rng_uniform(rng)), phi = 2.0 * M_PI * gsl_rng_uniform(rng);
  double y = between(0.5 * species->diameter, field->high.y - 0.5 * species->diameter, rng);
  double z = r * cos(phi);
  return em_vec_make(r * sin(phi), y, species->start == EM_START_HALF ? -fabs(z) : z);
}

struct em_vec em_start_place_point(const struct em_start_field *field,
                                   const struct em_species *species, gsl_rng *rng) {
  if (field->drum && !species->has_region) return point_in_drum(field, species, rng);
  struct em_vec low, high;
  em_start_place_box(field, species, &low, &high);
  double x = between(low.x, high.x, rng), y = between(low.y, high.y, rng);
  return em_vec_make(x, y, between(low.z, high.z, rng));
}

/* Larger balls first: they find room hardest. */
static int by_size(const void *a, const void *b) {
  const struct em_start_group *p = a, *q = b;
  double d = q->species->diameter - p->species->diameter;
  if (d != 0.0) return d > 0.0 ? 1 : -1;
  return p->number < q->number ? -1 : p->number > q->number;
}

enum { TRIES_PER_BALL = 1000 };

/* Tries that all balls may take together. Few balls may try long, as the reference's do; for many
 * it is faster to push them apart. */
static size_t tries_allowed(size_t balls) {
  const size_t few = 2000000, each = 2;
  return balls * each > few ? balls * each : few;
}

/* Inserts one group's balls until one finds no room; `tries` is what is left. */
static size_t insert(struct em_start_field *field, const struct em_start_group *group, gsl_rng *rng,
                     size_t *tries) {
  const struct em_species *s = group->species;
  size_t placed = 0;
  for (; placed < s->count && !em_start_field_stops(field); ++placed) {
    size_t k = group->first + placed;
    bool found = false;
    for (int t = 0; t<TRIES_PER_BALL && * tries> 0 && !found; ++t, --*tries) {
      struct em_vec r = em_start_place_point(field, s, rng);
      found = em_start_field_fits(field, k, r, EM_START_CLEARANCE);
      if (found) field->balls->position[k] = r;
    }
    if (!found) break;
    em_start_field_put(field, k);
  }
  return placed;
}

/* Strews the balls of a group from `placed` on at random, with overlaps. */
static void strew(struct em_start_field *field, const struct em_start_group *group, size_t placed,
                  gsl_rng *rng) {
  for (; placed < group->species->count && !em_start_field_stops(field); ++placed) {
    size_t k = group->first + placed;
    struct em_vec r = em_start_place_point(field, group->species, rng);
    for (int t = 0; t < TRIES_PER_BALL; ++t) {
      double radius = field->balls->radius[k];
      if (em_start_field_wall_gap(field, r, radius) >= 0.0 &&
          em_start_field_blade_gap(field, r, radius, NULL) >= 0.0)
        break;
      r = em_start_place_point(field, group->species, rng);
    }
    field->balls->position[k] = r;
    em_start_field_put(field, k);
  }
}

static enum em_status no_room(const struct em_start_field *field, size_t count,
                              const struct em_start_group *group, size_t placed,
                              struct em_error *err) {
  size_t total = 0;
  double volume = 0.0;
  for (size_t g = 0; g < count; ++g) {
    const struct em_species *s = group[g].species;
    total += s->count;
    volume += (double)s->count * M_PI / 6.0 * pow(s->diameter, 3);
  }
  double share = volume / em_scene_volume(field->scene);
  return em_error_set(
      err, EM_INPUT, field->scene->file, 0,
      "balls: only %zu of %zu found room at random, and pushing them apart did not "
      "end; they would fill %.3g of the chamber, expected fewer or smaller balls, a "
      "larger region, or start = \"lattice\"",
      placed, total, share);
}

/* Numbers the balls of a group along the cells of the field, so that neighbours lie close in
 * memory; they are all alike. */
static void sort_places(struct em_start_field *field, const struct em_start_group *group) {
  struct em_vec *r = field->balls->position + group->first;
  size_t n = group->species->count;
  if (n == 0) return;
  double *key = malloc(n * sizeof *key);
  struct em_vec *sorted = malloc(n * sizeof *sorted);
  size_t *order = malloc(n * sizeof *order);
  if (key && sorted && order) {
    for (size_t k = 0; k < n; ++k)
      key[k] = (double)em_start_field_cell(field, r[k]);
    gsl_sort_index(order, key, 1, n);
    for (size_t k = 0; k < n; ++k)
      sorted[k] = r[order[k]];
    memcpy(r, sorted, n * sizeof *r);
  }
  free(key);
  free(sorted);
  free(order);
}

enum em_status em_start_place_random(struct em_start_field *field, size_t count,
                                     struct em_start_group *group, gsl_rng *rng,
                                     struct em_error *err) {
  size_t total = 0, placed = 0;
  if (count == 0) return EM_OK;
  qsort(group, count, sizeof *group, by_size);
  for (size_t g = 0; g < count; ++g)
    total += group[g].species->count;
  size_t tries = tries_allowed(total);
  bool *loose = NULL;
  for (size_t g = 0; g < count; ++g) {
    size_t n = loose ? 0 : insert(field, &group[g], rng, &tries);
    placed += n;
    if (n == group[g].species->count) continue;
    if (!loose) loose = calloc(field->balls->count, sizeof *loose);
    if (!loose) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory to place %zu balls", total);
    strew(field, &group[g], n, rng);
  }
  if (em_start_field_stops(field)) {
    free(loose);
    return em_start_field_stopped(err);
  }
  if (!loose) return EM_OK;
  for (size_t g = 0; g < count; ++g) {
    for (size_t k = 0; k < group[g].species->count; ++k)
      loose[group[g].first + k] = true;
    sort_places(field, &group[g]);
  }
  bool apart = em_start_relax_push(field, loose, rng);
  free(loose);
  if (em_start_field_stops(field)) return em_start_field_stopped(err);
  return apart ? EM_OK : no_room(field, count, group, placed, err);
}
