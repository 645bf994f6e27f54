/* Fills a region evenly with a face-centred lattice, stretched to fit it. Sites are the points of a
 * grid of planes whose three indices have an even sum: neighbours are √(h_i² + h_j²) or 2 h_i
 * apart, h being the distances between planes. */
#include <gsl/gsl_randist.h>
#include <math.h>
#include <stdlib.h>

#include "scene/start_place.h"

struct lattice {
  struct em_vec low;
  double length[3]; /* m, room for centres */
  bool periodic[3];
  int planes[3];
  double h[3];  /* m */
  double sigma; /* m, least distance of neighbours */
};

/* Planes a distance of about h apart: a period takes an even number, walls one on either side. */
static void choose_planes(struct lattice *l, int k, int planes) {
  if (l->periodic[k]) {
    planes = planes < 2 ? 2 : planes + (planes & 1);
    l->h[k] = l->length[k] / planes;
  } else {
    planes = planes < 1 ? 1 : planes;
    l->h[k] = planes > 1 ? l->length[k] / (planes - 1) : 0.0;
  }
  l->planes[k] = planes;
}

static double least_distance(const struct lattice *l) {
  double least = INFINITY;
  for (int i = 0; i < 3; ++i) {
    int j = (i + 1) % 3;
    if (l->planes[i] > 1 && l->planes[j] > 1) least = fmin(least, hypot(l->h[i], l->h[j]));
    if (l->planes[i] > 2 || l->periodic[i]) least = fmin(least, 2.0 * l->h[i]);
  }
  return least;
}

static struct em_vec site(const struct lattice *l, int i, int j, int k) {
  const int at[3] = {i, j, k};
  double x[3];
  const double low[3] = {l->low.x, l->low.y, l->low.z};
  for (int d = 0; d < 3; ++d) {
    double first = l->periodic[d] ? 0.5 * l->h[d] : 0.0;
    x[d] = low[d] + (l->planes[d] > 1 ? first + at[d] * l->h[d] : 0.5 * l->length[d]);
  }
  return em_vec_make(x[0], x[1], x[2]);
}

/* Counts the sites that are free; keeps them if `sites` is given. */
static size_t collect(const struct lattice *l, const struct em_start_field *field, size_t largest,
                      struct em_vec *sites) {
  size_t n = 0;
  for (int k = 0; k < l->planes[2]; ++k)
    for (int j = 0; j < l->planes[1]; ++j)
      for (int i = (j + k) & 1; i < l->planes[0]; i += 2) {
        struct em_vec r = em_start_field_wrap(field, site(l, i, j, k));
        if (!em_start_field_fits(field, largest, r, EM_START_CLEARANCE)) continue;
        if (sites) sites[n] = r;
        ++n;
      }
  return n;
}

/* Of the eight ways to round the planes for a distance h, the one with the largest least distance
 * of neighbours among those that have `needed` sites or more; false if none is good. */
static bool try_distance(struct lattice *l, const struct em_start_field *field, size_t largest,
                         double h, size_t needed, size_t *found) {
  struct lattice best = *l;
  double widest = 0.0;
  for (int way = 0; way < 8; ++way) {
    struct lattice one = *l;
    for (int k = 0; k < 3; ++k) {
      double planes = floor(l->length[k] / h) + (l->periodic[k] ? 0 : 1) + ((way >> k) & 1);
      choose_planes(&one, k, planes > 1e5 ? 100000 : (int)planes);
    }
    double sites = 0.5 * one.planes[0] * (double)one.planes[1] * one.planes[2] + 1.0;
    double least = least_distance(&one);
    if (sites < (double)needed || least < l->sigma || least <= widest) continue;
    size_t n = collect(&one, field, largest, NULL);
    if (n < needed) continue;
    widest = least;
    *found = n;
    best = one;
  }
  *l = best;
  return widest > 0.0;
}

/* Deals `needed` of the sites, evenly chosen, to the groups in random order. */
static void deal(struct em_start_field *field, size_t count, const struct em_start_group *group,
                 struct em_vec *sites, size_t found, size_t needed, gsl_rng *rng) {
  for (size_t k = 0; k < needed; ++k)
    sites[k] = sites[(size_t)((double)k * ((double)found / (double)needed))];
  if (count > 1) gsl_ran_shuffle(rng, sites, needed, sizeof *sites);
  size_t next = 0;
  for (size_t g = 0; g < count; ++g)
    for (size_t k = 0; k < group[g].species->count; ++k) {
      field->balls->position[group[g].first + k] = sites[next++];
      em_start_field_put(field, group[g].first + k);
    }
}

enum em_status em_start_lattice_fill(struct em_start_field *field, size_t count,
                                     const struct em_start_group *group, gsl_rng *rng,
                                     struct em_error *err) {
  size_t needed = 0;
  const struct em_start_group *widest = &group[0];
  for (size_t g = 0; g < count; ++g) {
    needed += group[g].species->count;
    if (group[g].species->diameter > widest->species->diameter) widest = &group[g];
  }
  if (needed == 0) return EM_OK;
  struct em_vec low, high;
  em_start_place_box(field, widest->species, &low, &high);
  struct lattice l = {.sigma = widest->species->diameter * (1.0 + EM_START_CLEARANCE)};
  const double lows[3] = {low.x, low.y, low.z}, highs[3] = {high.x, high.y, high.z};
  const double inset = EM_START_CLEARANCE * widest->species->diameter;
  double from[3], volume = 1.0;
  for (int k = 0; k < 3; ++k) {
    l.periodic[k] = field->periodic[k] && !widest->species->has_region;
    from[k] = lows[k] + (l.periodic[k] ? 0.0 : inset);
    l.length[k] = fmax(highs[k] - lows[k] - (l.periodic[k] ? 0.0 : 2.0 * inset), 0.0);
    volume *= l.length[k] + l.sigma;
  }
  l.low = em_vec_make(from[0], from[1], from[2]);
  size_t found = 0;
  double h = 1.3 * cbrt(volume / (2.0 * (double)needed));
  bool good = false;
  for (; !good && h > 0.5 * l.sigma && !em_start_field_stops(field); h *= 0.98)
    good = try_distance(&l, field, widest->first, h, needed, &found);
  if (em_start_field_stops(field)) return em_start_field_stopped(err);
  struct em_vec *sites = good ? malloc(found * sizeof *sites) : NULL;
  if (!good)
    return em_error_set(err, EM_INPUT, field->scene->file, 0,
                        "balls: no lattice of %zu balls of %.4g m fits, expected fewer or smaller "
                        "balls or a larger region",
                        needed, widest->species->diameter);
  if (!sites) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory to place %zu balls", needed);
  collect(&l, field, widest->first, sites);
  deal(field, count, group, sites, found, needed, rng);
  free(sites);
  return EM_OK;
}
