/* millpost verify: does a run obey the laws of an ideal gas? (Reichardt 2005, Tab. 14-2) */
#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/goodness.h"
#include "eventmill/histogram.h"
#include "eventmill/plot.h"
#include "record/output.h"
#include "tool/gas.h"
#include "tool/millpost.h"

/* Fewer values do not tell a law; an elastic gas without moving parts keeps its energy to this. */
enum { LEAST_VALUES = 100, MOST_TESTS = 64 };
static const double ENERGY_LIMIT = 1e-9;

static const char *const option_names[] = {"from", "to", "alpha", "anyway", "output", ""};

static const struct em_millpost_help help = {
    .name = "verify",
    .arguments = "RUN",
    .summary = "Holds a run against the laws of an ideal gas; exit code 3 when it does not pass.",
    .details =
        "Speeds (Maxwell, with the parameter that the energy predicts), components (normal), "
        "positions\n"
        "and impact points (uniform), relative speeds at collisions (4-D Maxwell), v_n (Rayleigh) "
        "and\n"
        "impact parameters (linear) are tested by χ² and Kolmogorov-Smirnov. Values are taken far\n"
        "enough apart to be independent. Laws of collisions need record.collisions=true. Where a "
        "law\n"
        "need not hold (a turning rotor, ε < 1, places under gravity) or a run is too short to "
        "test it,\n"
        "that is said instead. With -o FILE.png a diagram per law is written: FILE-speed.png, "
        "...\n\n"
        "The verdict and the exit code: holds, 0; refuted, 3; undecided, 3: the law of speeds "
        "applies,\n"
        "but there are too few values or balls to test it; no law applies, 0: there is nothing to "
        "verify.",
    .examples = "  mill run geometries/ideal-gas.cfg record.collisions=true -o gas.h5\n"
                "  millpost verify gas.h5 -o gas.png\n"
                "  millpost verify gas.h5 --alpha 0.01 --json",
    .options = option_names,
    .least = 1,
    .most = 1,
};

/* All p-values, and the laws that they belong to. */
struct trial {
  struct em_report *report;
  const struct em_gas *gas;
  const struct em_scene *scene;
  bool rows; /* the run has a collision table */
  double alpha;
  int tests, untested; /* untested: laws */
  double p[MOST_TESTS];
  char name[MOST_TESTS][96];
};

static void note_p(struct trial *trial, const char *name, const char *test, double p) {
  if (isnan(p) || trial->tests == MOST_TESTS) return;
  trial->p[trial->tests] = p;
  snprintf(trial->name[trial->tests], sizeof trial->name[0], "%s (%s)", name, test);
  trial->tests++;
}

/* ---------------------------------------------------------------- laws of values */

static double cdf_of(enum em_distribution law, double x) {
  return em_distribution_cdf(law, 1.0, x);
}

static enum em_status test_values(struct em_goodness *chi2, struct em_goodness *ks,
                                  enum em_gas_tie tie, enum em_distribution law, const double *x,
                                  size_t n) {
  double *u = malloc((n + 1) * sizeof *u);
  if (!u) return EM_MEMORY;
  for (size_t i = 0; i < n; i++)
    u[i] = cdf_of(law, x[i]);
  const int constraints = tie == EM_GAS_FREE ? 1 : tie == EM_GAS_ENERGY ? 2 : 3;
  enum em_status status = em_goodness_chi2_uniform(chi2, u, n, 0, constraints);
  if (status == EM_OK && tie == EM_GAS_FREE)
    *ks = em_goodness_ks(u, n);
  else if (status == EM_OK)
    status = em_goodness_ks_tied(ks, law, tie == EM_GAS_FITTED, u, n);
  free(u);
  return status;
}

/* The parameter in m/s that a speed law should have for balls of one mass. */
static double predicted(const struct em_gas *gas, enum em_gas_quantity q) {
  switch (em_gas_law(q)) {
  case EM_DISTRIBUTION_LINEAR:
  case EM_DISTRIBUTION_UNIFORM:
    return 1.0;
  default:
    break;
  }
  return q == EM_GAS_RELATIVE || q == EM_GAS_VN ? M_SQRT2 * gas->sigma : gas->sigma;
}

/* Estimate of the parameter in units of the predicted one; components were scaled by their own. */
static double fitted(const struct em_gas *gas, enum em_gas_quantity q) {
  const double n = (double)gas->n[q];
  const int k = em_distribution_freedom(em_gas_law(q));
  if (k == 0) return NAN;
  if (q >= EM_GAS_VX && q <= EM_GAS_VZ) return sqrt(gas->square[q - EM_GAS_VX] / n);
  double sum = 0.0;
  for (size_t i = 0; i < gas->n[q]; i++)
    sum += gas->x[q][i] * gas->x[q][i];
  return sqrt(sum / (n * k));
}

static void row_begin(struct trial *trial, const char *words, const char *law, size_t n) {
  em_report_text(trial->report, "%s", words);
  em_report_text(trial->report, "%s", law);
  em_report_count(trial->report, n);
}

static void row_p(struct trial *trial, const char *words, double chi2, double freedom, double p,
                  double d, double p_ks) {
  em_report_number(trial->report, chi2);
  em_report_number(trial->report, freedom);
  em_report_number(trial->report, p);
  em_report_number(trial->report, d);
  em_report_number(trial->report, p_ks);
  note_p(trial, words, "χ²", p);
  note_p(trial, words, "Kolmogorov-Smirnov", p_ks);
}

/* False, and a note, when there are too few values of a law that the run could tell. */
static bool is_enough(struct trial *trial, const char *words, size_t n) {
  if (n >= LEAST_VALUES) return true;
  em_report_note(trial->report, "Not tested: %s; %zu values, at least %d are needed.", words, n,
                 LEAST_VALUES);
  trial->untested++;
  return false;
}

static enum em_status value_row(struct trial *trial, enum em_gas_quantity q) {
  const struct em_gas *gas = trial->gas;
  if (!em_gas_has(trial->scene, q)) return EM_OK;
  if (q >= EM_GAS_RELATIVE && !trial->rows) {
    trial->untested++;
    return EM_OK;
  }
  if (!is_enough(trial, em_gas_words(q), gas->n[q])) return EM_OK;
  struct em_goodness chi2, ks;
  const enum em_status status =
      test_values(&chi2, &ks, em_gas_tie(q), em_gas_law(q), gas->x[q], gas->n[q]);
  if (status != EM_OK) return status;
  const double a = predicted(gas, q);
  row_begin(trial, em_gas_words(q), em_distribution_name(em_gas_law(q)), gas->n[q]);
  em_report_number(trial->report, em_distribution_freedom(em_gas_law(q)) ? a : NAN);
  em_report_number(trial->report, a * fitted(gas, q));
  row_p(trial, em_gas_words(q), chi2.statistic, chi2.freedom, chi2.p, ks.statistic, ks.p);
  return EM_OK;
}

/* ---------------------------------------------------------------- isotropy, positions */

/* Σ v_x², Σ v_y², Σ v_z² share the energy like a Dirichlet law with A = 3n/2: (A+1) Σ (s−⅓)²/⅓ is
 * χ² with 2 degrees of freedom. */
static void isotropy_row(struct trial *trial) {
  static const char *const words = "energy of x, y, z alike";
  const struct em_gas *gas = trial->gas;
  if (!is_enough(trial, words, gas->n[EM_GAS_SPEED])) return;
  const double *e = gas->square, sum = e[0] + e[1] + e[2];
  const double n = (double)gas->n[EM_GAS_SPEED];
  double chi2 = 0.0;
  for (int d = 0; d < 3; d++) {
    const double s = e[d] / sum - 1.0 / 3.0;
    chi2 += 3.0 * (1.5 * n + 1.0) * s * s;
  }
  row_begin(trial, words, "dirichlet", gas->n[EM_GAS_SPEED]);
  em_report_blank(trial->report);
  em_report_blank(trial->report);
  row_p(trial, words, chi2, 2.0, gsl_cdf_chisq_Q(chi2, 2.0), NAN, NAN);
}

static void wave_row(struct trial *trial, const struct em_gas_waves *waves) {
  const struct em_gas *gas = trial->gas;
  if (!waves->key || !is_enough(trial, waves->words, em_scene_ball_count(trial->scene))) return;
  if (!gas->alike)
    em_report_note(trial->report, "Not tested: %s; the balls are not alike.", waves->words);
  else if (gas->wave_frames == 0)
    em_report_note(trial->report,
                   "Not tested: %s; it takes a frame %.3g ball-ball collisions per ball after the "
                   "start, the run has %.3g.",
                   waves->words, gas->wave_spacing, gas->collisions);
  if (waves->freedom == 0) {
    trial->untested++;
    return;
  }
  const double freedom = (double)waves->freedom;
  row_begin(trial, waves->words, "uniform, by waves", waves->freedom);
  em_report_blank(trial->report);
  em_report_blank(trial->report);
  row_p(trial, waves->words, waves->chi2, freedom, gsl_cdf_chisq_Q(waves->chi2, freedom), NAN, NAN);
}

/* ---------------------------------------------------------------- table */

static bool is_place(enum em_gas_quantity q) {
  return q == EM_GAS_DRUM_ANGLE || q == EM_GAS_DRUM_AXIAL;
}

static bool is_relative(enum em_gas_quantity q) {
  return q == EM_GAS_RELATIVE || q == EM_GAS_IMPACT;
}

static bool is_point(enum em_gas_quantity q) {
  return q >= EM_GAS_NORMAL_X && q <= EM_GAS_NORMAL_Z;
}

/* Which laws are tested. */
struct held {
  bool velocities, relative, points, places;
};

static void columns(struct em_report *report) {
  em_report_begin(report, "laws", NULL);
  em_report_column(report, "quantity", "quantity", "");
  em_report_column(report, "law", "law", "");
  em_report_column(report, "values", "values", "");
  em_report_column(report, "predicted", "predicted", "m/s");
  em_report_column(report, "fitted", "fitted", "m/s");
  em_report_column(report, "chi2", "χ²", "");
  em_report_column(report, "freedom", "freedom", "");
  em_report_column(report, "p_chi2", "p (χ²)", "");
  em_report_column(report, "d", "D", "");
  em_report_column(report, "p_ks", "p (KS)", "");
}

static bool is_held(const struct held *held, enum em_gas_quantity q) {
  if (is_place(q)) return held->places;
  if (is_point(q)) return held->points;
  return is_relative(q) ? held->relative : held->velocities;
}

static enum em_status test_all(struct trial *trial, const struct held *held) {
  columns(trial->report);
  for (int q = 0; q < EM_GAS_COUNT; q++) {
    if (!is_held(held, (enum em_gas_quantity)q)) continue;
    const enum em_status status = value_row(trial, (enum em_gas_quantity)q);
    if (status != EM_OK) return status;
    if (q == EM_GAS_VZ) isotropy_row(trial);
  }
  for (int w = 0; held->places && w < 3; w++)
    wave_row(trial, &trial->gas->waves[w]);
  return EM_OK;
}

/* How many laws are refuted, with Bonferroni's correction for the number of tests. */
static int count_refuted(const struct trial *trial) {
  int refuted = 0;
  for (int k = 0; k < trial->tests; k++) {
    if (trial->p[k] * trial->tests >= trial->alpha) continue;
    em_report_note(trial->report, "REFUTED: %s, p = %.2g", trial->name[k], trial->p[k]);
    refuted++;
  }
  return refuted;
}

static int conclude(struct trial *trial, bool conserved) {
  const double drift = trial->gas->energy_drift;
  const bool decided = trial->gas->n[EM_GAS_SPEED] >= LEAST_VALUES;
  const bool few = trial->gas->most < LEAST_VALUES;
  int refuted = count_refuted(trial);
  if (conserved && isnan(drift))
    em_report_note(trial->report, "Not tested: that energy is conserved; gravity pulls the balls "
                                  "across a periodic boundary.");
  if (conserved && drift > ENERGY_LIMIT) {
    em_report_note(trial->report, "REFUTED: energy is conserved; it drifts by %.2g", drift);
    refuted++;
  }
  em_report_fact_text(trial->report, "verdict", "verdict",
                      refuted   ? "refuted"
                      : decided ? "holds"
                      : few     ? "undecided: too few balls"
                                : "undecided: too few values");
  em_report_fact_count(trial->report, "tests", "tests", (uint64_t)trial->tests);
  em_report_fact_count(trial->report, "untested", "laws that are not tested",
                       (uint64_t)trial->untested);
  if (!refuted && decided)
    em_report_note(trial->report, "All %d tests hold (smallest p × number of tests above %g).",
                   trial->tests, trial->alpha);
  if (!refuted && !decided && few)
    em_report_note(
        trial->report,
        "Not passed: the laws are those of many balls. These tell no more than %zu values "
        "of each, at least %d are needed.",
        trial->gas->most, LEAST_VALUES);
  else if (!refuted && !decided)
    em_report_note(trial->report, "Not passed: a longer run tells more about the law of speeds.");
  return refuted || !decided ? EM_MILLPOST_NOT_PASSED : EM_MILLPOST_DONE;
}

/* ---------------------------------------------------------------- diagrams */

static enum em_status draw_law(const struct em_run_file *run, const struct em_gas *gas,
                               enum em_gas_quantity q, const char *out, struct em_error *err) {
  enum { POINTS = 200 };
  const enum em_distribution law = em_gas_law(q);
  const bool speed = em_distribution_freedom(law) > 0, normal = law == EM_DISTRIBUTION_NORMAL;
  double a = predicted(gas, q);
  if (isnan(a)) a = 1.0;
  if (normal) a *= fitted(gas, q);
  const double high = speed ? 4.2 : 1.0, low = normal ? -4.2 : 0.0;
  size_t bins = em_histogram_default_bins((double)gas->n[q], 120);
  struct em_histogram *h = em_histogram_new(bins, a * low, a * high);
  if (!h) return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  for (size_t i = 0; i < gas->n[q]; i++)
    em_histogram_add(h, a * gas->x[q][i], 1.0);
  double *y = calloc(bins, sizeof *y), x[POINTS], f[POINTS];
  for (size_t k = 0; y && k < bins; k++)
    y[k] = em_histogram_density(h, k);
  for (int k = 0; k < POINTS; k++) {
    x[k] = a * (low + (high - low) * k / (POINTS - 1.0));
    f[k] = em_distribution_pdf(law, a, x[k]);
  }
  const struct em_plot_series series[] = {
      {.name = "simulated", .style = EM_PLOT_STEPS, .count = bins, .x = h->edge, .y = y},
      {.name = em_distribution_name(law),
       .style = EM_PLOT_DASHED,
       .count = POINTS,
       .x = x,
       .y = f}};
  char path[EM_SCENE_PATH], title[160], subtitle[256], label[160];
  em_output_name(path, sizeof path, out, em_gas_key(q), NULL);
  em_plot_subtitle(em_run_file_scene(run), subtitle, sizeof subtitle);
  snprintf(title, sizeof title, "Distribution: %s", em_gas_words(q));
  snprintf(label, sizeof label, "%s  [%s]", em_gas_words(q),
           !speed              ? "share of its range"
           : isnan(gas->sigma) ? "√(kT/m)"
                               : "m/s");
  const struct em_plot plot = {.title = title,
                               .subtitle = subtitle,
                               .x_label = label,
                               .y_label =
                                   speed && !isnan(gas->sigma) ? "density  [s/m]" : "density",
                               .series_count = 2,
                               .series = series};
  const enum em_status status =
      y ? em_plot_draw(&plot, path, err) : em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  free(y);
  em_histogram_free(h);
  return status;
}

static enum em_status draw_all(const struct em_run_file *run, const struct em_gas *gas,
                               const char *out, struct em_error *err) {
  enum em_status status = EM_OK;
  for (int q = 0; q < EM_GAS_COUNT && status == EM_OK; q++)
    if (gas->n[q] >= LEAST_VALUES) status = draw_law(run, gas, (enum em_gas_quantity)q, out, err);
  return status;
}

/* ---------------------------------------------------------------- command */

static void facts(struct em_report *report, const struct em_gas *gas) {
  em_report_fact(report, "kt", "kT by the energy", gas->kt, "J");
  em_report_fact(report, "kt_frames", "kT by the velocities", gas->kt_frames, "J");
  em_report_fact(report, "sigma", "σ of a velocity component", gas->sigma, "m/s");
  em_report_fact_count(report, "frames", "frames, far apart", gas->frames);
  em_report_fact_count(report, "windows", "windows of collisions, far apart", gas->windows);
  em_report_fact(report, "energy_drift", "largest relative change of the energy", gas->energy_drift,
                 "");
}

static int run_with(const struct em_run_file *run, const struct em_millpost_options *o) {
  struct em_error err = {.code = EM_OK};
  const struct em_scene *scene = em_run_file_scene(run);
  const char *no_velocities = em_gas_no_velocities(scene), *no_places = em_gas_no_places(scene);
  const char *no_relative = em_gas_no_relative(scene), *no_points = em_gas_no_points(scene);
  const struct held held = {.velocities = o->anyway || !*no_velocities,
                            .relative = o->anyway || !*no_relative,
                            .points = o->anyway || !*no_points,
                            .places = o->anyway || !*no_places};
  struct em_report *report = em_report_new("verify");
  em_report_fact_text(report, "run", "run", "%s", o->run[0]);
  if (*no_velocities)
    em_report_note(report, "The laws of velocities need not hold here: %s.", no_velocities);
  if (*no_relative && !*no_velocities)
    em_report_note(report,
                   "The laws of relative speeds and impact parameters need not hold here: %s.",
                   no_relative);
  if (*no_points && !*no_velocities)
    em_report_note(report, "The laws of impact points on balls need not hold here: %s.", no_points);
  if (*no_places) em_report_note(report, "The laws of places need not hold here: %s.", no_places);
  if (!held.velocities && !held.places) {
    em_report_fact_text(report, "verdict", "verdict", "no law applies");
    return em_millpost_print(report, o, EM_MILLPOST_DONE);
  }
  if (!em_run_file_has_rows(run))
    em_report_note(report, "Laws of collisions are not tested: the run has no collision table.");
  struct em_gas *gas;
  enum em_status status = em_gas_new(&gas, run, o->from, o->to, &err);
  struct trial trial = {.report = report,
                        .gas = gas,
                        .scene = scene,
                        .rows = em_run_file_has_rows(run),
                        .alpha = o->alpha};
  int code = EM_MILLPOST_DONE;
  if (status == EM_OK) {
    facts(report, gas);
    status = test_all(&trial, &held);
    if (status == EM_OK) code = conclude(&trial, held.velocities);
    if (status == EM_OK && o->out) status = draw_all(run, gas, o->out, &err);
    em_gas_free(gas);
  }
  if (status == EM_OK) return em_millpost_print(report, o, code);
  em_report_free(report);
  return em_millpost_fail(&err);
}

int em_millpost_verify(int argc, char **argv) {
  struct em_millpost_options options;
  const int code = em_millpost_options(&options, &help, argc, argv);
  if (code >= 0) return code;
  struct em_error err = {.code = EM_OK};
  struct em_run_file *run;
  if (em_millpost_open(&run, options.run[0], &err) != EM_OK) return em_millpost_fail(&err);
  const int result = run_with(run, &options);
  em_run_file_close(run);
  return result;
}
