/* Checks what no single entry can show: that the blades can turn and that the balls fit. */
#include "scene/scene_check.h"

#include <math.h>
#include <stdio.h>

#include "scene/scene_gap.h"

/* The densest packing of equal balls: π/√18. */
static const double DENSEST = 0.74048048969306;

/* The least periodic edge, in diameters of the largest ball. Of the partner met last, what is
 * within √1.001 diameters is the contact that has just been made (`pair` in event/loop_pairs.h);
 * its next image is as far away as an edge less a diameter, far enough from 1 + √1.001 = 2.0005
 * diameters on. The rest leaves balls places, 0.006 diameters wide, in which they meet nearest
 * images only (em_span_room). */
static const double PERIOD_LEAST = 2.05;

static const char axis_name[] = "xyz";

static double largest_diameter(const struct em_scene *scene) {
  double d = 0.0;
  for (size_t k = 0; k < scene->species_count; ++k)
    d = fmax(d, scene->species[k].diameter);
  return d;
}

/* ---- blades */

/* "blade 2 of rotor 0", by the path that the scene has for it. */
static void blade_path(const struct em_scene *scene, size_t rotor, size_t blade, size_t size,
                       char *path) {
  if (scene->rotor_count > 1)
    snprintf(path, size, "rotor.%zu.blades.%zu", rotor, blade);
  else
    snprintf(path, size, "rotor.blades.%zu", blade);
}

static void check_wall_gap(struct em_scene_report *report, const char *path, const char *wall,
                           double gap, double d) {
  if (gap <= 0.0)
    em_scene_report_path(report, path,
                         "touches the %s (reaches %.4g m beyond it), expected a gap "
                         "of at least one ball diameter (%.4g m)",
                         wall, -gap, d);
  else if (gap < d * (1.0 - 1e-9))
    em_scene_report_path(report, path,
                         "leaves a gap of %.4g m to the %s, expected at least one "
                         "ball diameter (%.4g m)",
                         gap, wall, d);
}

static void check_walls(struct em_scene_report *report, const struct em_scene *scene,
                        const struct em_blade *blade, double d, const char *path) {
  struct em_scene_body body = em_scene_gap_body(blade);
  bool drum = scene->chamber.shape == EM_SHAPE_DRUM;
  if (drum) check_wall_gap(report, path, "drum wall", em_scene_gap_drum(&body, scene), d);
  for (int k = 0; k < 3; ++k)
    for (int side = 0; side < 2; ++side) {
      char wall[64];
      bool end = k == 1;
      if ((drum && !end) || (!drum && scene->chamber.periodic[k])) continue;
      snprintf(wall, sizeof wall, "%s at the %s end of %c", end ? "end wall" : "wall",
               side ? "upper" : "lower", axis_name[k]);
      check_wall_gap(report, path, wall, em_scene_gap_plane(&body, scene, k, side), d);
    }
}

static void check_pair(struct em_scene_report *report, const struct em_scene *scene, size_t ra,
                       size_t ba, size_t rb, size_t bb) {
  const struct em_blade *a = &scene->rotor[ra].blade[ba], *b = &scene->rotor[rb].blade[bb];
  if (em_scene_gap_blades(a, b) > 0.0) return;
  char path[64], other[64];
  blade_path(scene, ra, ba, sizeof path, path);
  blade_path(scene, rb, bb, sizeof other, other);
  em_scene_report_path(report, path, "touches %s, expected blades that never touch each other",
                       other);
}

static void check_periodic(struct em_scene_report *report, const struct em_scene *scene) {
  const bool *p = scene->chamber.periodic;
  if (em_scene_blade_count(scene) > 0 && (p[0] || p[1] || p[2]))
    em_scene_report_path(report, "chamber.periodic",
                         "a rotor does not turn in a periodic box, expected false, or no blades");
}

static void check_blades(struct em_scene_report *report, const struct em_scene *scene, double d) {
  for (size_t r = 0; r < scene->rotor_count; ++r)
    for (size_t b = 0; b < scene->rotor[r].blade_count; ++b) {
      char path[64];
      blade_path(scene, r, b, sizeof path, path);
      check_walls(report, scene, &scene->rotor[r].blade[b], d, path);
      for (size_t r2 = 0; r2 <= r; ++r2)
        for (size_t b2 = 0; b2 < (r2 < r ? scene->rotor[r2].blade_count : b); ++b2)
          check_pair(report, scene, r, b, r2, b2);
    }
}

/* ---- balls */

void em_scene_check_species_path(const struct em_scene *scene, size_t k, const char *entry,
                                 size_t size, char *path) {
  if (scene->species_count > 1)
    snprintf(path, size, "balls.%zu.%s", k, entry);
  else
    snprintf(path, size, "balls.%s", entry);
}

/* Each ball goes into the chamber between its walls. */
static void check_diameter(struct em_scene_report *report, const struct em_scene *scene, size_t k) {
  const struct em_chamber *c = &scene->chamber;
  double d = scene->species[k].diameter;
  bool drum = c->shape == EM_SHAPE_DRUM;
  double side[3] = {drum ? c->diameter : c->size.x, drum ? c->length : c->size.y,
                    drum ? c->diameter : c->size.z};
  char path[64];
  em_scene_check_species_path(scene, k, "diameter", sizeof path, path);
  for (int i = drum ? 1 : 0; i < 3; ++i) {
    if ((!drum && c->periodic[i]) || d < side[i]) continue;
    em_scene_report_path(report, path,
                         "%.4g m does not fit into the chamber's extent of %.4g m along %c, "
                         "expected less",
                         d, side[i], axis_name[i]);
    return;
  }
}

/* Across a periodic boundary a ball meets each other ball once. */
static void check_period(struct em_scene_report *report, const struct em_scene *scene) {
  const struct em_chamber *c = &scene->chamber;
  const double side[3] = {c->size.x, c->size.y, c->size.z};
  double d = largest_diameter(scene);
  for (int i = 0; i < 3; ++i) {
    if (c->shape != EM_SHAPE_BOX || !c->periodic[i] || side[i] >= PERIOD_LEAST * d * (1.0 - 1e-9))
      continue;
    em_scene_report_path(report, "chamber.size",
                         "the periodic edge of %.4g m along %c is too short for balls of %.4g m, "
                         "expected at least %g diameters (%.4g m)",
                         side[i], axis_name[i], d, PERIOD_LEAST, PERIOD_LEAST * d);
    return;
  }
}

/* Volume (m³) of the part of the bounding box that balls of a region can fill. */
static double region_volume(const struct em_scene *scene, const struct em_species *s) {
  struct em_vec low, high;
  double v = 1.0, r = 0.5 * s->diameter;
  em_scene_bounds(scene, &low, &high);
  for (int k = 0; k < 3; ++k) {
    double a = fmax(em_vec_component(low, k), em_vec_component(s->low, k) - r);
    double b = fmin(em_vec_component(high, k), em_vec_component(s->high, k) + r);
    v *= fmax(b - a, 0.0);
  }
  return v;
}

static double ball_volume(const struct em_species *s) {
  return (double)s->count * (M_PI / 6.0) * s->diameter * s->diameter * s->diameter;
}

static void check_packing(struct em_scene_report *report, const struct em_scene *scene) {
  double blades = 0.0, balls = 0.0;
  for (size_t r = 0; r < scene->rotor_count; ++r)
    for (size_t b = 0; b < scene->rotor[r].blade_count; ++b) {
      const struct em_blade *blade = &scene->rotor[r].blade[b];
      blades += 2.0 * M_PI * blade->radius * blade->radius * blade->reach;
    }
  for (size_t k = 0; k < scene->species_count; ++k) {
    const struct em_species *s = &scene->species[k];
    balls += ball_volume(s);
    double share = s->has_region ? ball_volume(s) / region_volume(scene, s) : 0.0;
    char path[64];
    em_scene_check_species_path(scene, k, "region", sizeof path, path);
    if (share > DENSEST)
      em_scene_report_path(report, path, "%zu balls would fill %.3g of it, expected at most %.2f",
                           s->count, share, DENSEST);
  }
  double free = em_scene_volume(scene) - blades;
  if (balls > DENSEST * free)
    em_scene_report_path(report, "balls",
                         "%zu balls would fill %.3g of the chamber, expected at "
                         "most %.2f",
                         em_scene_ball_count(scene), balls / free, DENSEST);
}

/* Does the box of centres meet what centres can reach in the drum's cross-section? */
static bool meets_drum(const struct em_species *s, double rho) {
  double x = fmax(s->low.x, fmin(0.0, s->high.x)), z = fmax(s->low.z, fmin(0.0, s->high.z));
  return x * x + z * z <= rho * rho;
}

static void check_region(struct em_scene_report *report, const struct em_scene *scene, size_t k) {
  const struct em_species *s = &scene->species[k];
  if (!s->has_region) return;
  struct em_vec low, high;
  char path[64];
  em_scene_check_species_path(scene, k, "region", sizeof path, path);
  em_scene_bounds(scene, &low, &high);
  bool inside = true;
  for (int i = 0; i < 3; ++i) {
    double r = 0.5 * s->diameter;
    if (scene->chamber.shape == EM_SHAPE_BOX && scene->chamber.periodic[i]) r = 0.0;
    double a = em_vec_component(s->low, i), b = em_vec_component(s->high, i);
    if (a > b) {
      em_scene_report_path(report, path, "low is above high along %c, expected low below high",
                           axis_name[i]);
      return;
    }
    inside = inside && b >= em_vec_component(low, i) + r && a <= em_vec_component(high, i) - r;
  }
  if (scene->chamber.shape == EM_SHAPE_DRUM)
    inside = inside && meets_drum(s, 0.5 * (scene->chamber.diameter - s->diameter));
  if (!inside)
    em_scene_report_path(report, path,
                         "lies outside the chamber, expected room for balls of "
                         "%.4g m in it",
                         s->diameter);
}

static void check_facets(struct em_scene_report *report, const struct em_chamber *c) {
  if (c->facets == 0) return;
  if (c->facets < 3)
    em_scene_report_path(report, "chamber.facets", "found %d, expected 0 or at least 3", c->facets);
  if (c->rpm != 0.0 || c->ramp_half != 0.0)
    em_scene_report_path(report, "chamber.facets",
                         "a drum with facets neither turns nor has ramps, expected one of these "
                         "alone");
}

void em_scene_check_all(struct em_scene_report *report, const struct em_scene *scene) {
  size_t before = report->errors;
  if (!em_scene_check_range(report, scene)) return;
  check_facets(report, &scene->chamber);
  check_periodic(report, scene);
  for (size_t k = 0; k < scene->species_count; ++k)
    check_diameter(report, scene, k);
  check_period(report, scene);
  /* Balls that are far too large would find fault with every blade. */
  check_blades(report, scene, report->errors == before ? largest_diameter(scene) : 0.0);
  for (size_t k = 0; k < scene->species_count; ++k)
    check_region(report, scene, k);
  if (report->errors == before) check_packing(report, scene);
}
