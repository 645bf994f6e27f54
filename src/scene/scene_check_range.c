/* Checks that what the engine makes of a scene's magnitudes are normal doubles, 2^-1022 … 2^1024:
 * of others it would miss contacts without a word, or wait for a time that is no number. */
#include <math.h>
#include <stdio.h>

#include "eventmill/start.h"
#include "scene/scene_check.h"

/* Lengths L, diameters d: volumes L³, d³. */
#define LENGTH_LEAST 0x1p-340
#define LENGTH_MOST  0x1p340
/* Masses m: m_i m_j of the reduced mass. */
#define MASS_LEAST 0x1p-511
#define MASS_MOST  0x1p511
/* Moments of inertia, of m d². */
#define MOMENT_LEAST 0x1p-960
#define MOMENT_MOST  0x1p1000
/* Squares of speeds v; of L v and d v, the products r·v of two balls; of momenta m v, for the
 * energy that a contact takes. Lower bounds leave the digits of differences, upper ones what is
 * faster than is typical; momenta have no room left for that beside masses. */
#define SQUARED_LEAST  0x1p-480
#define SQUARED_MOST   0x1p500
#define MOMENTUM_LEAST 0x1p-511
#define MOMENTUM_MOST  0x1p511
/* Energies m v², summed over balls and contacts. */
#define ENERGY_LEAST 0x1p-960
#define ENERGY_MOST  0x1p960

/* What balls reach that are driven, by tips of blades or by gravity, of the drive's own speed. */
static const double DRIVEN = 8.0;

/* A fall at this share of the balls' speeds bends no path by more than rounding does. */
static const double WEIGHTLESS = 0x1p-27;

struct extremes {
  double longest, thinnest, heaviest, lightest; /* m, kg */
  double fastest, slowest;                      /* m/s, that the scene may have */
};

static void check_length(struct em_scene_report *report, const char *path, double length) {
  if (!(length >= LENGTH_LEAST && length <= LENGTH_MOST))
    em_scene_report_path(report, path, "found %.4g m, expected %.3g to %.3g m", length,
                         LENGTH_LEAST, LENGTH_MOST);
}

static void check_chamber(struct em_scene_report *report, const struct em_chamber *c) {
  if (c->shape == EM_SHAPE_DRUM) {
    check_length(report, "chamber.diameter", c->diameter);
    check_length(report, "chamber.length", c->length);
  } else {
    const struct em_vec s = c->size;
    const double least = fmin(s.x, fmin(s.y, s.z)), most = fmax(s.x, fmax(s.y, s.z));
    check_length(report, "chamber.size", least < LENGTH_LEAST ? least : most);
  }
}

static void check_species(struct em_scene_report *report, const struct em_scene *scene, size_t k) {
  const double m = em_start_mass(&scene->species[k]);
  char path[64];
  em_scene_check_species_path(scene, k, "diameter", sizeof path, path);
  check_length(report, path, scene->species[k].diameter);
  em_scene_check_species_path(scene, k, "density", sizeof path, path);
  if (!(m >= MASS_LEAST && m <= MASS_MOST))
    em_scene_report_path(report, path,
                         "found %.4g kg/m³, balls of %.3g kg, expected balls of %.3g to %.3g kg",
                         scene->species[k].density, m, MASS_LEAST, MASS_MOST);
  const double moment = m * scene->species[k].diameter * scene->species[k].diameter;
  if (m >= MASS_LEAST && m <= MASS_MOST && !(moment >= MOMENT_LEAST && moment <= MOMENT_MOST))
    em_scene_report_path(report, path,
                         "found %.4g kg/m³, m d² = %.3g kg m², expected %.3g to %.3g kg m²",
                         scene->species[k].density, moment, MOMENT_LEAST, MOMENT_MOST);
}

static struct extremes extremes_of(const struct em_scene *scene) {
  struct em_vec low, high;
  em_scene_extent(scene, &low, &high);
  struct extremes e = {.longest = em_vec_norm(em_vec_sub(high, low)), .lightest = INFINITY};
  e.thinnest = e.longest;
  for (size_t k = 0; k < scene->species_count; k++) {
    const double m = em_start_mass(&scene->species[k]);
    e.thinnest = fmin(e.thinnest, scene->species[k].diameter);
    e.heaviest = fmax(e.heaviest, m);
    e.lightest = fmin(e.lightest, m);
  }
  e.fastest = SQUARED_MOST / fmax(1.0, e.longest);
  e.slowest = SQUARED_LEAST / fmin(1.0, e.thinnest);
  if (e.heaviest == 0.0) return e;
  e.fastest = fmin(e.fastest, fmin(MOMENTUM_MOST / e.heaviest, sqrt(ENERGY_MOST / e.heaviest)));
  e.slowest = fmax(e.slowest, fmax(MOMENTUM_LEAST / e.lightest, sqrt(ENERGY_LEAST / e.lightest)));
  return e;
}

static void check_speed(struct em_scene_report *report, const struct extremes *e, const char *path,
                        double speed) {
  if (!(speed <= e->fastest))
    em_scene_report_path(report, path,
                         "makes speeds of %.4g m/s, expected at most %.3g m/s with balls of %.3g "
                         "kg and %.3g m from end to end",
                         speed, e->fastest, e->heaviest, e->longest);
}

/* Of a table's rows, their spins included. */
static double fastest_row(const struct em_species *s) {
  double speed = 0.0;
  for (size_t k = 0; k < s->count; k++) {
    speed = fmax(speed, em_vec_norm(s->velocity[k]));
    if (s->spin) speed = fmax(speed, em_vec_norm(s->spin[k]) * s->diameter);
  }
  return speed;
}

static void check_balls(struct em_scene_report *report, const struct em_scene *scene,
                        const struct extremes *e) {
  for (size_t k = 0; k < scene->species_count; k++) {
    const struct em_species *s = &scene->species[k];
    const bool table = s->start == EM_START_TABLE;
    char path[64];
    em_scene_check_species_path(scene, k, table ? "table" : "speed", sizeof path, path);
    check_speed(report, e, path, table ? fastest_row(s) : s->speed);
  }
  const double typical = em_scene_typical_speed(scene);
  if (!(typical >= e->slowest))
    em_scene_report_path(report, "balls",
                         "found speeds of %.4g m/s, expected at least %.3g m/s with balls of %.3g "
                         "kg and %.3g m",
                         typical, e->slowest, e->lightest, e->thinnest);
}

static void check_turn(struct em_scene_report *report, const struct extremes *e, const char *path,
                       double omega, double reach) {
  if (!(omega <= SQUARED_MOST))
    em_scene_report_path(report, path, "found %.4g rad/s, expected at most %.3g rad/s", omega,
                         SQUARED_MOST);
  else
    check_speed(report, e, path, DRIVEN * omega * reach);
}

static void check_rotor(struct em_scene_report *report, const struct em_scene *scene, size_t k,
                        const struct extremes *e) {
  const struct em_rotor *rotor = &scene->rotor[k];
  double omega = 0.0, reach = 0.0;
  for (size_t b = 0; b < rotor->blade_count; b++) {
    omega = fmax(omega, fabs(rotor->blade[b].omega));
    reach = fmax(reach, hypot(rotor->blade[b].reach, rotor->blade[b].radius));
  }
  char path[64] = "rotor.rpm";
  if (scene->rotor_count > 1) snprintf(path, sizeof path, "rotor.%zu.rpm", k);
  check_turn(report, e, path, omega, reach);
}

/* The drum's quartic knows g²: weaker gravity shall be none beside how the balls fly. */
static void check_gravity(struct em_scene_report *report, const struct em_scene *scene,
                          const struct extremes *e) {
  const struct em_vec v = scene->gravity;
  const double g = fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z)));
  const double fall = sqrt(2.0 * g) * sqrt(e->longest);
  const bool counts = fall > WEIGHTLESS * em_scene_typical_speed(scene);
  if (!(g <= SQUARED_MOST) || (g < SQUARED_LEAST && counts))
    em_scene_report_path(report, "gravity", "found %.4g m/s², expected 0, or %.3g to %.3g m/s²", g,
                         SQUARED_LEAST, SQUARED_MOST);
  else
    check_speed(report, e, "gravity", DRIVEN * fall);
}

static void check_drives(struct em_scene_report *report, const struct em_scene *scene,
                         const struct extremes *e) {
  check_turn(report, e, "chamber.rpm", fabs(scene->chamber.rpm) * (M_PI / 30.0), e->longest);
  for (size_t k = 0; k < scene->rotor_count; k++)
    check_rotor(report, scene, k, e);
  check_gravity(report, scene, e);
}

bool em_scene_check_range(struct em_scene_report *report, const struct em_scene *scene) {
  const size_t before = report->errors;
  check_chamber(report, &scene->chamber);
  for (size_t k = 0; k < scene->species_count; k++)
    check_species(report, scene, k);
  if (!(scene->duration <= SQUARED_MOST))
    em_scene_report_path(report, "duration", "found %.4g s, expected at most %.3g s",
                         scene->duration, SQUARED_MOST);
  if (report->errors > before) return false;
  const struct extremes e = extremes_of(scene);
  check_balls(report, scene, &e);
  check_drives(report, scene, &e);
  return report->errors == before;
}
