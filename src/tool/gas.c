/* Samples what an ideal gas promises from a run. */
#include "tool/gas.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "record/summary.h"
#include "tool/trace.h"

/* Ball-ball collisions per ball: until the start is forgotten, between two samples of the same
 * balls, and within one window of collisions. */
static const double SETTLE = 30.0, APART = 12.0, WITHIN = 0.2;

/* Decay times of the longest density wave between two frames whose waves are taken. */
static const double WAVES = 2.0;

/* Layers that walls impose on the balls near them have faded so many diameters away. */
static const double LAYERS = 3.0;

/* A law of many balls is that of N up to 1/N. Of N² values, even the sharpest test sees that as no
 * more than √1.6 of what chance does (docs/statistics.md): so many of N² are taken at most. */
static const double MOST_SHARE = 0.1;

enum { MOST_VALUES = 1000000 };

#define KEY(code, key, words, law, tie)   key,
#define WORDS(code, key, words, law, tie) words,
#define LAW(code, key, words, law, tie)   EM_DISTRIBUTION_##law,
#define TIE(code, key, words, law, tie)   tie,
static const char *const keys[] = {EM_GAS_LIST(KEY)};
static const char *const all_words[] = {EM_GAS_LIST(WORDS)};
static const enum em_distribution laws[] = {EM_GAS_LIST(LAW)};
static const enum em_gas_tie ties[] = {EM_GAS_LIST(TIE)};

const char *em_gas_key(enum em_gas_quantity q) {
  return keys[q];
}

const char *em_gas_words(enum em_gas_quantity q) {
  return all_words[q];
}

enum em_distribution em_gas_law(enum em_gas_quantity q) {
  return laws[q];
}

enum em_gas_tie em_gas_tie(enum em_gas_quantity q) {
  return ties[q];
}

void em_gas_free(struct em_gas *gas) {
  if (!gas) return;
  for (int q = 0; q < EM_GAS_COUNT; q++)
    free(gas->x[q]);
  free(gas);
}

/* ---------------------------------------------------------------- what a scene promises */

/* Without walls across coordinate d, nothing takes momentum along it. */
static bool is_loop(const struct em_scene *scene, int d) {
  const struct em_chamber *c = &scene->chamber;
  return c->shape == EM_SHAPE_BOX && c->periodic[d];
}

static bool is_closed_loop(const struct em_scene *scene) {
  return is_loop(scene, 0) && is_loop(scene, 1) && is_loop(scene, 2);
}

static bool is_elastic(const struct em_contact_law *law) {
  if (law->normal.law != EM_LAW_CONSTANT || law->normal.p[0] != 1.0) return false;
  if (law->rule == EM_RULE_SMOOTH) return true;
  if (law->rule == EM_RULE_FRICTION) return law->friction == 0.0;
  return law->tangential == 1.0;
}

const char *em_gas_no_velocities(const struct em_scene *scene) {
  const struct em_chamber *c = &scene->chamber;
  for (size_t r = 0; r < scene->rotor_count; r++)
    for (size_t k = 0; k < scene->rotor[r].blade_count; k++)
      if (scene->rotor[r].blade[k].omega != 0.0) return "a rotor drives the balls";
  if (em_summary_falls_for_ever(scene) && !is_closed_loop(scene))
    return "gravity pulls the balls across a periodic boundary";
  if (c->ramp_half > 0.0) return "faked ramps do not reflect like walls";
  for (int cls = 0; cls < EM_CLASS_COUNT; cls++) {
    if (cls == EM_CLASS_BLADE && em_scene_blade_count(scene) == 0) continue;
    if (!is_elastic(&scene->contact[cls])) return "contacts are not elastic and smooth";
  }
  return "";
}

const char *em_gas_no_places(const struct em_scene *scene) {
  const char *no_velocities = em_gas_no_velocities(scene);
  if (*no_velocities) return no_velocities;
  if (em_vec_norm(scene->gravity) > 0.0) return "gravity";
  if (em_scene_blade_count(scene) > 0) return "blades take up space";
  if (scene->chamber.facets > 0) return "the drum has facets, the laws are of a round one";
  return "";
}

static bool spins(const struct em_scene *scene) {
  for (size_t k = 0; k < scene->species_count; k++)
    for (size_t i = 0; scene->species[k].spin && i < scene->species[k].count; i++)
      if (em_vec_norm2(scene->species[k].spin[i]) > 0.0) return true;
  return false;
}

const char *em_gas_no_relative(const struct em_scene *scene) {
  const char *no_velocities = em_gas_no_velocities(scene);
  if (*no_velocities) return no_velocities;
  return spins(scene) ? "the balls spin, which is part of v_t" : "";
}

const char *em_gas_no_points(const struct em_scene *scene) {
  const char *no_velocities = em_gas_no_velocities(scene);
  if (*no_velocities) return no_velocities;
  return em_scene_blade_count(scene) > 0 ? "balls lie in layers around blades" : "";
}

bool em_gas_has(const struct em_scene *scene, enum em_gas_quantity q) {
  const struct em_chamber *c = &scene->chamber;
  const bool box = c->shape == EM_SHAPE_BOX;
  switch (q) {
  case EM_GAS_VN_DRUM:
    return !box || !c->periodic[0] || !c->periodic[2];
  case EM_GAS_VN_END:
    return !box || !c->periodic[1];
  case EM_GAS_DRUM_ANGLE:
  case EM_GAS_DRUM_AXIAL:
    return !box;
  default:
    return true;
  }
}

/* ---------------------------------------------------------------- how often balls collide */

/* Ball-ball collisions per ball at any time, by the observables. */
struct pace {
  struct em_trace trace;
  double per_ball; /* 2/N */
};

static double pace_at(const struct pace *pace, double t) {
  const struct em_trace *c = &pace->trace;
  size_t low = 0, high = c->count - 1;
  if (t <= c->time[0]) return pace->per_ball * c->value[EM_CLASS_BALL];
  if (t >= c->time[high]) return pace->per_ball * c->value[high * c->width + EM_CLASS_BALL];
  while (high - low > 1) {
    const size_t middle = (low + high) / 2;
    if (c->time[middle] <= t)
      low = middle;
    else
      high = middle;
  }
  const double a = c->value[low * c->width + EM_CLASS_BALL];
  const double b = c->value[high * c->width + EM_CLASS_BALL];
  return pace->per_ball * (a + (b - a) * (t - c->time[low]) / (c->time[high] - c->time[low]));
}

static enum em_status read_pace(struct pace *pace, const struct em_run_file *run,
                                struct em_error *err) {
  const struct em_window all = {.from = 0.0, .to = em_run_file_state(run)->time};
  if (em_run_file_ball_count(run) == 0)
    return em_error_set(err, EM_INPUT, em_run_file_path(run), 0, "the run has no balls to verify");
  const enum em_status status = em_trace_read(&pace->trace, run, "collisions", &all, err);
  pace->per_ball = 2.0 / (double)em_run_file_ball_count(run);
  if (status != EM_OK) return status;
  if (pace->trace.count >= 2 && pace->trace.width == EM_CLASS_COUNT) return EM_OK;
  return em_error_set(err, EM_INPUT, em_run_file_path(run), 0,
                      "the observables, which tell how often balls collide, are missing");
}

/* Collisions per ball from one sample of `values` to the next, so that gas->most reach over all of
 * the window. */
static double spacing(const struct em_gas *gas, const struct pace *pace, double from, double to,
                      double values) {
  return fmax(APART, (pace_at(pace, to) - pace_at(pace, from)) * values / (double)gas->most);
}

/* The time at which the start is forgotten; infinite when it never is. */
static double settled(const struct pace *pace) {
  for (size_t k = 0; k < pace->trace.count; k++)
    if (pace_at(pace, pace->trace.time[k]) >= SETTLE) return pace->trace.time[k];
  return INFINITY;
}

/* ---------------------------------------------------------------- energy */

static enum em_status read_energy(struct em_gas *gas, const struct em_run_file *run,
                                  const struct em_scene *scene, struct em_error *err) {
  const struct em_run_state *state = em_run_file_state(run);
  const struct em_window all = {.from = 0.0, .to = state->time};
  struct em_trace kinetic, potential, spin;
  enum em_status status = em_trace_read(&kinetic, run, "kinetic_energy", &all, err);
  if (status != EM_OK) return status;
  status = em_trace_read(&potential, run, "potential_energy", &all, err);
  if (status == EM_OK) status = em_trace_read(&spin, run, "spin_energy", &all, err);
  if (status == EM_OK && kinetic.count > 0 && !em_summary_falls_for_ever(scene)) {
    double gap = 0.0, scale = 0.0;
    for (size_t k = 0; k < kinetic.count; k++) {
      double moving = kinetic.value[k], rise = 0.0;
      if (spin.count == kinetic.count) moving += spin.value[k];
      if (potential.count == kinetic.count) rise = potential.value[k] - state->potential_start;
      gap = fmax(gap, fabs(moving + rise - state->kinetic_start));
      scale = fmax(scale, em_summary_energy_scale(state->kinetic_start, moving, rise, 0.0, 0.0));
    }
    gas->energy_drift = scale > 0.0 ? gap / scale : 0.0;
  }
  em_trace_free(&kinetic);
  em_trace_free(&potential);
  em_trace_free(&spin);
  return status;
}

/* ---------------------------------------------------------------- frames */

static bool reserve(struct em_gas *gas, enum em_gas_quantity q) {
  gas->x[q] = malloc((gas->most + 1) * sizeof *gas->x[q]);
  return gas->x[q] != NULL;
}

static void put(struct em_gas *gas, enum em_gas_quantity q, double x) {
  if (gas->n[q] < gas->most && isfinite(x)) gas->x[q][gas->n[q]++] = x;
}

static double mass_of(const struct em_balls *balls) {
  double mass = 0.0;
  for (size_t i = 0; i < balls->count; i++)
    mass += balls->mass[i];
  return mass;
}

/* Velocity of the centre of mass along the coordinates in which it stays; 0 in the others. */
static struct em_vec drift_of(const struct em_balls *balls, const struct em_scene *scene) {
  struct em_vec p = {0.0, 0.0, 0.0};
  const double mass = mass_of(balls);
  for (size_t i = 0; i < balls->count; i++)
    p = em_vec_axpy(p, balls->mass[i] / mass, balls->velocity[i]);
  if (!is_loop(scene, 0)) p.x = 0.0;
  if (!is_loop(scene, 1)) p.y = 0.0;
  if (!is_loop(scene, 2)) p.z = 0.0;
  return p;
}

static double spin_energy(const struct em_balls *balls) {
  double energy = 0.0;
  for (size_t i = 0; i < balls->count; i++) {
    const double r = balls->radius[i];
    energy += 0.2 * balls->mass[i] * r * r * em_vec_norm2(balls->spin[i]);
  }
  return energy;
}

/* By the energy at the start. What spins have of it stays theirs, what the centre of mass has is no
 * heat, and where it stays, N balls have the freedom of N − 1. balls: any frame. */
static void take_temperature(struct em_gas *gas, const struct em_balls *balls,
                             const struct em_scene *scene, double energy) {
  const struct em_vec drift = drift_of(balls, scene);
  double freedom = 3.0 * (double)balls->count;
  for (int d = 0; d < 3; d++)
    if (is_loop(scene, d)) freedom -= 1.0;
  const double kinetic = energy - spin_energy(balls);
  gas->kt = (2.0 * kinetic - mass_of(balls) * em_vec_dot(drift, drift)) / freedom;
}

/* Velocities in units of √(J/m): the temperature is divided out when it is known. Without the
 * centre of mass, a component of one ball scatters with kT/m (1 − m/M). */
static void take_velocities(struct em_gas *gas, const struct em_balls *balls,
                            const struct em_scene *scene) {
  const struct em_vec drift = drift_of(balls, scene);
  const double all = mass_of(balls);
  for (size_t i = 0; i < balls->count; i++) {
    const double m = balls->mass[i], free = sqrt(m), tied = sqrt(m / (1.0 - m / all));
    struct em_vec v = em_vec_sub(balls->velocity[i], drift);
    v.x *= is_loop(scene, 0) ? tied : free;
    v.y *= is_loop(scene, 1) ? tied : free;
    v.z *= is_loop(scene, 2) ? tied : free;
    put(gas, EM_GAS_SPEED, em_vec_norm(v));
    put(gas, EM_GAS_VX, v.x);
    put(gas, EM_GAS_VY, v.y);
    put(gas, EM_GAS_VZ, v.z);
  }
}

/* The waves of one ball along coordinate w; returns how many there are. */
static int waves_of(const struct em_scene *scene, struct em_vec r, int w, double *wave) {
  const struct em_chamber *c = &scene->chamber;
  struct em_vec low, high;
  em_scene_bounds(scene, &low, &high);
  const double u[3] = {(r.x - low.x) / (high.x - low.x), (r.y - low.y) / (high.y - low.y),
                       (r.z - low.z) / (high.z - low.z)};
  const bool box = c->shape == EM_SHAPE_BOX, loop = box ? c->periodic[w] : w == 0;
  if (!box && w == 2) return 0;
  if (!loop) {
    wave[0] = cos(M_PI * u[w]);
    wave[1] = cos(3.0 * M_PI * u[w]);
    return 2;
  }
  const double phase = box ? 2.0 * M_PI * u[w] : atan2(r.z, r.x);
  wave[0] = cos(phase);
  wave[1] = sin(phase);
  wave[2] = cos(2.0 * phase);
  wave[3] = sin(2.0 * phase);
  return 4;
}

static double stiffness(const struct em_balls *balls, const struct em_scene *scene) {
  double volume = 0.0;
  for (size_t i = 0; i < balls->count; i++)
    volume += 4.0 / 3.0 * M_PI * balls->radius[i] * balls->radius[i] * balls->radius[i];
  const double phi = volume / em_scene_volume(scene), p = 1.0 + 2.0 * phi;
  return pow(1.0 - phi, 4.0) / (p * p + phi * phi * phi * (phi - 4.0));
}

static void take_waves(struct em_gas *gas, const struct em_balls *balls,
                       const struct em_scene *scene) {
  const double s0 = stiffness(balls, scene);
  for (int w = 0; w < 3; w++) {
    double sum[EM_GAS_MODES] = {0.0}, square[EM_GAS_MODES] = {0.0}, wave[EM_GAS_MODES];
    int modes = 0;
    for (size_t i = 0; i < balls->count; i++) {
      modes = waves_of(scene, balls->position[i], w, wave);
      for (int m = 0; m < modes; m++) {
        sum[m] += wave[m];
        square[m] += wave[m] * wave[m];
      }
    }
    for (int m = 0; m < modes; m++)
      gas->waves[w].chi2 += sum[m] * sum[m] / (square[m] * s0);
    gas->waves[w].freedom += (size_t)modes;
  }
  gas->wave_frames++;
}

static void name_waves(struct em_gas *gas, const struct em_chamber *c) {
  static const char *const box_key[] = {"position_x", "position_y", "position_z"};
  static const char *const box_words[] = {"positions, x", "positions, y", "positions, z"};
  const bool box = c->shape == EM_SHAPE_BOX;
  for (int w = 0; w < (box ? 3 : 2); w++) {
    gas->waves[w].key = box ? box_key[w] : w == 0 ? "position_angle" : "position_axial";
    gas->waves[w].words = box      ? box_words[w]
                          : w == 0 ? "positions, angle"
                                   : "positions, along the axis";
  }
}

/* Density evens out by diffusion: a wave of number k decays with D k², D about 1.2 λ v̄ with the
 * mean free path λ = v̄/ν. In collisions per ball, WAVES decay times of the longest wave. */
static double wave_spacing(const struct pace *pace, const struct em_scene *scene, double kt,
                           double mass) {
  const struct em_trace *c = &pace->trace;
  struct em_vec low, high;
  em_scene_bounds(scene, &low, &high);
  const double length = fmax(high.x - low.x, fmax(high.y - low.y, high.z - low.z));
  const double time = c->time[c->count - 1] - c->time[0];
  const double rate = (pace_at(pace, INFINITY) - pace_at(pace, -INFINITY)) / time;
  const double path = sqrt(8.0 * kt / (M_PI * mass)) / rate, k = M_PI / length;
  return fmax(APART, WAVES / (1.2 * path * path * k * k));
}

static enum em_status from_frames(struct em_gas *gas, const struct em_run_file *run,
                                  const struct pace *pace, double from, double to,
                                  struct em_error *err) {
  const struct em_scene *scene = em_run_file_scene(run);
  const size_t frames = em_run_file_frame_count(run);
  const double apart = spacing(gas, pace, from, to, (double)em_run_file_ball_count(run));
  for (int q = EM_GAS_SPEED; q <= EM_GAS_VZ; q++)
    if (!reserve(gas, (enum em_gas_quantity)q))
      return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  name_waves(gas, &scene->chamber);
  struct em_balls *balls = NULL;
  enum em_status status = em_run_file_balls(run, &balls, err);
  gas->alike = true;
  for (size_t i = 1; status == EM_OK && i < balls->count; i++)
    gas->alike =
        gas->alike && balls->mass[i] == balls->mass[0] && balls->radius[i] == balls->radius[0];
  if (status == EM_OK && frames > 0) status = em_run_file_frame(run, 0, balls, err);
  if (status == EM_OK) take_temperature(gas, balls, scene, em_run_file_state(run)->kinetic_start);
  double before = -INFINITY, wave_before = 0.0; /* the start is a frame to stay away from */
  if (status == EM_OK) gas->wave_spacing = wave_spacing(pace, scene, gas->kt, balls->mass[0]);
  for (size_t k = 0; status == EM_OK && k < frames; k++) {
    const double t = em_run_file_frame_time(run, k);
    if (t < from || t > to) continue;
    status = em_run_file_frame(run, k, balls, err);
    if (status != EM_OK) break;
    if (gas->alike && pace_at(pace, t) - wave_before >= gas->wave_spacing) {
      take_waves(gas, balls, scene);
      wave_before = pace_at(pace, t);
    }
    if (pace_at(pace, t) - before < apart || gas->n[EM_GAS_SPEED] + balls->count > gas->most)
      continue;
    before = pace_at(pace, t);
    take_velocities(gas, balls, scene);
    gas->frames++;
  }
  if (status == EM_OK && gas->frames == 0)
    status = em_error_set(err, EM_INPUT, em_run_file_path(run), 0, "no frame between %g s and %g s",
                          from, to);
  gas->mass = status == EM_OK ? balls->mass[0] : NAN;
  for (size_t i = 1; status == EM_OK && i < balls->count; i++)
    if (balls->mass[i] != balls->mass[0]) gas->mass = NAN;
  em_start_free(balls);
  return status;
}

/* Subtracts the values' mean and divides them by their own σ. */
static void centre_and_scale(double *x, size_t n) {
  double mean = 0.0, square = 0.0;
  for (size_t i = 0; i < n; i++)
    mean += x[i] / (double)n;
  for (size_t i = 0; i < n; i++)
    square += (x[i] - mean) * (x[i] - mean);
  const double own = sqrt(square / (double)n);
  for (size_t i = 0; i < n; i++)
    x[i] = (x[i] - mean) / own;
}

/* Turns velocities into units of √(kT/m), and components into units of their own σ. */
static void scale_velocities(struct em_gas *gas, const struct em_scene *scene) {
  const size_t n = gas->n[EM_GAS_SPEED];
  double sum = 0.0;
  for (int d = 0; d < 3; d++) {
    gas->square[d] = 0.0;
    for (size_t i = 0; i < n; i++)
      gas->square[d] += gas->x[EM_GAS_VX + d][i] * gas->x[EM_GAS_VX + d][i];
    sum += gas->square[d];
  }
  gas->kt_frames = sum / (3.0 * (double)n);
  if (em_vec_norm(scene->gravity) > 0.0) gas->kt = gas->kt_frames;
  const double unit = sqrt(gas->kt);
  for (size_t i = 0; i < n; i++)
    gas->x[EM_GAS_SPEED][i] /= unit;
  for (int d = 0; d < 3; d++) {
    centre_and_scale(gas->x[EM_GAS_VX + d], n);
    gas->square[d] /= gas->kt;
  }
  gas->sigma = sqrt(gas->kt / gas->mass);
}

/* ---------------------------------------------------------------- collisions */

struct sampler {
  struct em_gas *gas;
  const struct em_scene *scene;
  const struct em_balls *balls;
  double margin; /* m, from walls */
};

static bool is_deep(const struct sampler *s, const float place[3]) {
  const struct em_chamber *c = &s->scene->chamber;
  const double p[3] = {(double)place[0], (double)place[1], (double)place[2]};
  if (c->shape == EM_SHAPE_DRUM)
    return hypot(p[0], p[2]) < 0.5 * c->diameter - s->margin && p[1] > s->margin &&
           p[1] < c->length - s->margin;
  const double size[3] = {c->size.x, c->size.y, c->size.z};
  for (int d = 0; d < 3; d++)
    if (!c->periodic[d] && (p[d] < s->margin || p[d] > size[d] - s->margin)) return false;
  return true;
}

static void take_pair(struct sampler *s, const struct em_rows *rows, size_t k) {
  if (rows->partner[k] >= s->balls->count) return;
  const double a = s->balls->mass[rows->ball[k]], b = s->balls->mass[rows->partner[k]];
  const double unit = sqrt(s->gas->kt * (a + b) / (a * b));
  const double vn = (double)rows->vn[k], g = hypot(vn, (double)rows->vt[k]);
  put(s->gas, EM_GAS_VN, vn / unit);
  put(s->gas, EM_GAS_RELATIVE, g / unit);
  if (g > 0.0) put(s->gas, EM_GAS_IMPACT, (double)rows->vt[k] / g);
  if (!is_deep(s, rows->place[k])) return;
  for (int d = 0; d < 3; d++)
    put(s->gas, (enum em_gas_quantity)(EM_GAS_NORMAL_X + d),
        0.5 * (1.0 + (double)rows->normal[k][d]));
}

static void take_wall(struct sampler *s, const struct em_rows *rows, size_t k) {
  const double unit = sqrt(s->gas->kt / s->balls->mass[rows->ball[k]]);
  const bool drum = rows->cls[k] == EM_CLASS_DRUM;
  put(s->gas, drum ? EM_GAS_VN_DRUM : EM_GAS_VN_END, (double)rows->vn[k] / unit);
  const struct em_chamber *c = &s->scene->chamber;
  if (!drum || c->shape != EM_SHAPE_DRUM) return;
  const double angle = atan2((double)rows->place[k][2], (double)rows->place[k][0]);
  put(s->gas, EM_GAS_DRUM_ANGLE, 0.5 + angle / (2.0 * M_PI));
  const double depth = (double)rows->place[k][1] - s->margin, deep = c->length - 2.0 * s->margin;
  const double y = depth / deep;
  if (deep > 0.0 && y >= 0.0 && y <= 1.0) put(s->gas, EM_GAS_DRUM_AXIAL, y);
}

/* The windows lie where the count of collisions per ball, less that at the begin, modulo `apart`,
 * is below WITHIN. */
static enum em_status from_rows(struct sampler *s, const struct em_run_file *run,
                                const struct pace *pace, double from, double to,
                                struct em_error *err) {
  const unsigned columns = EM_COLUMN_ALL & ~(unsigned)EM_COLUMN_LOST;
  struct em_rows *rows = em_run_file_rows_new(columns);
  if (!rows) return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  for (int q = EM_GAS_RELATIVE; q < EM_GAS_COUNT; q++)
    if (!reserve(s->gas, (enum em_gas_quantity)q)) {
      em_run_file_rows_free(rows);
      return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
    }
  enum em_status status = EM_OK;
  const double begin = pace_at(pace, from);
  const double pairs = 0.5 * WITHIN * (double)s->balls->count; /* of a window */
  const double apart = spacing(s->gas, pace, from, to, pairs);
  double window = -1.0;
  for (uint64_t first = 0; status == EM_OK; first += rows->count) {
    status = em_run_file_rows(run, first, rows, err);
    if (status != EM_OK || rows->count == 0 || rows->time[0] > to) break;
    for (size_t k = 0; k < rows->count; k++) {
      const double t = rows->time[k];
      if (t < from || t > to || rows->ball[k] >= s->balls->count) continue;
      const double turns = (pace_at(pace, t) - begin) / apart;
      if ((turns - floor(turns)) * apart >= WITHIN) continue;
      s->gas->windows += floor(turns) > window;
      window = floor(turns);
      if (rows->cls[k] == EM_CLASS_BALL) take_pair(s, rows, k);
      if (rows->cls[k] == EM_CLASS_DRUM || rows->cls[k] == EM_CLASS_END) take_wall(s, rows, k);
    }
  }
  em_run_file_rows_free(rows);
  return status;
}

/* ---------------------------------------------------------------- all together */

static double largest_diameter(const struct em_scene *scene) {
  double d = 0.0;
  for (size_t k = 0; k < scene->species_count; k++)
    d = fmax(d, scene->species[k].diameter);
  return d;
}

/* Those of whole frames, of one at least. */
static size_t most_values(double balls) {
  return (size_t)(balls * fmax(1.0, floor(fmin(MOST_SHARE * balls, MOST_VALUES / balls))));
}

static enum em_status sample(struct em_gas *gas, const struct em_run_file *run,
                             const struct pace *pace, double from, double to,
                             struct em_error *err) {
  const struct em_scene *scene = em_run_file_scene(run);
  const double end = em_run_file_state(run)->time;
  if (isnan(to) || to > end) to = end;
  const bool given = !isnan(from);
  if (!given) from = settled(pace);
  if (!(from < to) && given)
    return em_error_set(err, EM_INPUT, em_run_file_path(run), 0, "nothing between %g s and %g s",
                        from, to);
  if (!(from < to))
    return em_error_set(err, EM_INPUT, em_run_file_path(run), 0,
                        "too short to verify: the start is forgotten after %g ball-ball collisions "
                        "per ball, until %g s there are %.3g",
                        SETTLE, to, pace_at(pace, to));
  gas->collisions = pace_at(pace, to);
  gas->most = most_values((double)em_run_file_ball_count(run));
  enum em_status status = read_energy(gas, run, scene, err);
  if (status == EM_OK) status = from_frames(gas, run, pace, from, to, err);
  if (status != EM_OK) return status;
  scale_velocities(gas, scene);
  if (!em_run_file_has_rows(run)) return EM_OK;
  struct em_balls *balls = NULL;
  status = em_run_file_balls(run, &balls, err);
  struct sampler sampler = {gas, scene, balls, LAYERS * largest_diameter(scene)};
  if (status == EM_OK) status = from_rows(&sampler, run, pace, from, to, err);
  em_start_free(balls);
  return status;
}

enum em_status em_gas_new(struct em_gas **out, const struct em_run_file *run, double from,
                          double to, struct em_error *err) {
  *out = NULL;
  struct em_gas *gas = calloc(1, sizeof *gas);
  struct pace pace = {.per_ball = 0.0};
  if (!gas) return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  gas->energy_drift = NAN;
  enum em_status status = read_pace(&pace, run, err);
  if (status == EM_OK) status = sample(gas, run, &pace, from, to, err);
  em_trace_free(&pace.trace);
  if (status == EM_OK)
    *out = gas;
  else
    em_gas_free(gas);
  return status;
}
