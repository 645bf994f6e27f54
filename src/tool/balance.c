/* The energy balance of a run. */
#include "tool/balance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "record/summary.h"

static enum em_status read_all(struct em_balance *b, const struct em_run_file *run,
                               const struct em_window *window, struct em_error *err) {
  const struct {
    const char *name;
    struct em_trace *trace;
  } list[] = {{"blade_work", &b->work},         {"blade_angular_impulse", &b->impulse},
              {"drum_work", &b->drum},          {"dissipated_energy", &b->lost},
              {"collision_energy", &b->impact}, {"kinetic_energy", &b->kinetic},
              {"spin_energy", &b->spin},        {"potential_energy", &b->potential}};
  for (size_t k = 0; k < sizeof list / sizeof *list; k++) {
    const enum em_status status = em_trace_read(list[k].trace, run, list[k].name, window, err);
    if (status != EM_OK) return status;
  }
  return EM_OK;
}

static bool read_speeds(struct em_balance *b, const struct em_scene *scene) {
  b->omega = calloc(em_scene_blade_count(scene) + 1, sizeof *b->omega);
  if (!b->omega) return false;
  for (size_t r = 0; r < scene->rotor_count; r++)
    for (size_t k = 0; k < scene->rotor[r].blade_count; k++)
      b->omega[b->blades++] = scene->rotor[r].blade[k].omega;
  return true;
}

/* Below this share of an energy, a loss or growth of it is rounding. */
static const double ROUNDING = 1e-12;

/* Classes whose contacts lose nothing but by rounding lose nothing. */
static void drop_rounding(struct em_balance *b) {
  const struct em_trace *lost = &b->lost, *impact = &b->impact;
  if (impact->width != lost->width || impact->count != lost->count) return;
  const size_t w = lost->width, end = (lost->count - 1) * w;
  for (size_t c = 0; c < w; c++) {
    const double loss = lost->value[end + c] - lost->value[c];
    if (fabs(loss) > ROUNDING * (impact->value[end + c] - impact->value[c])) continue;
    for (size_t k = 0; k < lost->count; k++)
      lost->value[k * w + c] = lost->value[c];
  }
}

enum em_status em_balance_new(struct em_balance *balance, const struct em_run_file *run,
                              const struct em_window *window, struct em_error *err) {
  memset(balance, 0, sizeof *balance);
  enum em_status status = read_all(balance, run, window, err);
  if (status == EM_OK && !read_speeds(balance, em_run_file_scene(run)))
    status = em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  const struct em_trace *lost = &balance->lost, *kinetic = &balance->kinetic;
  if (status == EM_OK && (lost->count < 2 || kinetic->count != lost->count))
    status = em_error_set(err, EM_INPUT, em_run_file_path(run), 0,
                          "fewer than two samples of the observables between %g s and %g s",
                          window->from, window->to);
  balance->falls = em_summary_falls_for_ever(em_run_file_scene(run));
  if (status == EM_OK) drop_rounding(balance);
  if (status == EM_OK) balance->time = lost->time[lost->count - 1] - lost->time[0];
  if (status != EM_OK) em_balance_free(balance);
  return status;
}

void em_balance_free(struct em_balance *b) {
  struct em_trace *const list[] = {&b->work,   &b->impulse, &b->drum, &b->lost,
                                   &b->impact, &b->kinetic, &b->spin, &b->potential};
  for (size_t k = 0; k < sizeof list / sizeof *list; k++)
    em_trace_free(list[k]);
  free(b->omega);
  memset(b, 0, sizeof *b);
}

/* A trace's sum at sample k; 0 when the run has no such observable. */
static double sum_at(const struct em_trace *trace, size_t k) {
  return k < trace->count ? em_trace_sum(trace, k, 0, trace->width) : 0.0;
}

static double growth(const struct em_trace *trace, size_t from, size_t to) {
  return sum_at(trace, to) - sum_at(trace, from);
}

static double step(const struct em_balance *b, size_t from, size_t to) {
  return b->lost.time[to] - b->lost.time[from];
}

static double by_torque(const struct em_balance *b, size_t from, size_t to) {
  double power = 0.0;
  if (b->impulse.count <= to) return 0.0;
  for (size_t k = 0; k < b->blades && k < b->impulse.width; k++) {
    const double *value = b->impulse.value;
    const size_t w = b->impulse.width;
    power += b->omega[k] * (value[to * w + k] - value[from * w + k]) / step(b, from, to);
  }
  return power;
}

static double stored(const struct em_balance *b, size_t from, size_t to) {
  if (b->falls) return NAN;
  return (growth(&b->kinetic, from, to) + growth(&b->spin, from, to) +
          growth(&b->potential, from, to)) /
         step(b, from, to);
}

static double dissipated(const struct em_balance *b, size_t from, size_t to) {
  return growth(&b->lost, from, to) / step(b, from, to);
}

static double by_energy(const struct em_balance *b, size_t from, size_t to) {
  return stored(b, from, to) + dissipated(b, from, to) -
         growth(&b->drum, from, to) / step(b, from, to);
}

static size_t last(const struct em_balance *b) {
  return b->lost.count - 1;
}

double em_balance_by_work(const struct em_balance *balance) {
  return growth(&balance->work, 0, last(balance)) / balance->time;
}

double em_balance_by_torque(const struct em_balance *balance) {
  return by_torque(balance, 0, last(balance));
}

double em_balance_by_energy(const struct em_balance *balance) {
  return by_energy(balance, 0, last(balance));
}

double em_balance_mismatch(const struct em_balance *b) {
  const double work = em_balance_by_work(b), torque = em_balance_by_torque(b);
  const double energy = em_balance_by_energy(b);
  const double difference = b->time * fmax(fabs(work - energy), fabs(torque - energy));
  const double start = sum_at(&b->kinetic, 0) + sum_at(&b->spin, 0);
  const double end = sum_at(&b->kinetic, last(b)) + sum_at(&b->spin, last(b));
  const double drum = growth(&b->drum, 0, last(b)), lost = growth(&b->lost, 0, last(b));
  const double put_in = fmax(b->time * fmax(fabs(work), fabs(torque)), fabs(drum));
  const double scale =
      em_summary_energy_scale(start, end, growth(&b->potential, 0, last(b)), put_in, lost);
  if (isnan(energy)) return NAN;
  return scale > 0.0 ? difference / scale : 0.0;
}

double em_balance_stored(const struct em_balance *balance) {
  const double power = stored(balance, 0, last(balance));
  const double energy = sum_at(&balance->kinetic, 0) + sum_at(&balance->spin, 0);
  return fabs(power) * balance->time > ROUNDING * energy || isnan(power) ? power : 0.0;
}

double em_balance_dissipated(const struct em_balance *balance) {
  return dissipated(balance, 0, last(balance));
}

double em_balance_torque_at(const struct em_balance *balance, size_t k) {
  return by_torque(balance, k, k + 1);
}

double em_balance_energy_at(const struct em_balance *balance, size_t k) {
  return by_energy(balance, k, k + 1);
}

double em_balance_dissipated_at(const struct em_balance *balance, size_t k) {
  return dissipated(balance, k, k + 1);
}

double em_balance_drum_at(const struct em_balance *balance, size_t k) {
  return growth(&balance->drum, k, k + 1) / step(balance, k, k + 1);
}
