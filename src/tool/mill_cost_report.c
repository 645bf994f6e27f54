/* Tables of mill cost. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "record/output.h"
#include "tool/mill_cost.h"
#include "tool/report.h"

/* ---------------------------------------------------------------- tables */

static const char *const figure_key[EM_PRECISION_COUNT] = {
    [EM_PRECISION_SPEED] = "median_speed",
    [EM_PRECISION_VN] = "median_vn",
    [EM_PRECISION_RATE] = "rate_above_3",
    [EM_PRECISION_POWER] = "power",
};

static void shift_columns(struct em_report *report) {
  for (int k = 0; k < EM_PRECISION_COUNT; k++)
    em_report_column(report, figure_key[k], em_precision_words((enum em_precision_kind)k), "");
}

static void shift_cells(struct em_report *report, const struct em_cost_result *r) {
  static const struct em_interval unknown = {NAN, NAN, NAN, 0.0, 1.0};
  for (int k = 0; k < EM_PRECISION_COUNT; k++)
    em_report_percent_interval(report, r->failed ? &unknown : &r->shift[k]);
}

static void time_columns(struct em_report *report) {
  em_report_column(report, "variant", "variant", "");
  em_report_column(report, "time", "time", "");
  em_report_column(report, "time_low", "from", "");
  em_report_column(report, "time_high", "to", "");
  em_report_column(report, "time_per_collision", "per collision", "");
}

static void time_cells(struct em_report *report, const struct em_cost_result *r) {
  em_report_text(report, "%s", r->variant.name);
  em_report_number(report, r->failed ? NAN : r->time);
  em_report_number(report, r->failed ? NAN : r->time_low);
  em_report_number(report, r->failed ? NAN : r->time_high);
  em_report_number(report, r->failed ? NAN : r->collision);
}

/* Per 10⁹ flights. */
static double share(uint64_t n, uint64_t flights) {
  return flights ? 1e9 * (double)n / (double)flights : NAN;
}

/* Is this one measured, and of this table? */
static bool belongs(const struct em_cost_result *r, enum em_cost_group group) {
  return r->measured && r->variant.group == group;
}

static void accuracy_table(struct em_report *report, const struct em_cost *cost) {
  em_report_begin(report, "accuracy",
                  "accuracy against time: the scene as it is = 1; figures: shift against it");
  time_columns(report);
  em_report_column(report, "error_rms", "contact time, rms", "s");
  em_report_column(report, "error_most", "largest", "s");
  em_report_column(report, "missed", "missed", "/1e9 flights");
  em_report_column(report, "invented", "invented", "/1e9 flights");
  em_report_column(report, "energy", "energy error", "");
  shift_columns(report);
  for (size_t k = 0; k < cost->count; k++) {
    const struct em_cost_result *r = &cost->result[k];
    if (!belongs(r, EM_COST_ACCURACY)) continue;
    const struct em_cost_flights *f = &r->flights;
    time_cells(report, r);
    em_report_number(report, f->contacts ? f->rms : NAN);
    em_report_number(report, f->contacts ? f->most : NAN);
    em_report_number(report, share(f->missed, f->flights));
    em_report_number(report, share(f->invented, f->flights));
    em_report_number(report, r->failed ? NAN : r->energy);
    shift_cells(report, r);
  }
}

static void effects_table(struct em_report *report, const struct em_cost *cost) {
  em_report_begin(report, "effects",
                  "effects against time: the scene as it is = 1; figures: shift against it");
  time_columns(report);
  shift_columns(report);
  for (size_t k = 0; k < cost->count; k++) {
    const struct em_cost_result *r = &cost->result[k];
    if (!belongs(r, EM_COST_EFFECT)) continue;
    time_cells(report, r);
    shift_cells(report, r);
  }
}

static void recording_table(struct em_report *report, const struct em_cost *cost) {
  em_report_begin(report, "recording",
                  "recording against time: a run that writes nothing but its end = 1");
  em_report_column(report, "variant", "variant", "");
  em_report_column(report, "time", "time", "");
  em_report_column(report, "time_low", "from", "");
  em_report_column(report, "time_high", "to", "");
  for (size_t k = 0; k < cost->count; k++) {
    const struct em_cost_result *r = &cost->result[k];
    if (!belongs(r, EM_COST_RECORDING)) continue;
    em_report_text(report, "%s", r->variant.name);
    em_report_number(report, r->failed ? NAN : r->time);
    em_report_number(report, r->failed ? NAN : r->time_low);
    em_report_number(report, r->failed ? NAN : r->time_high);
  }
}

/* Fewer independent blocks than this tell no width: the rule of em_steady_find. */
static const double LEAST_INDEPENDENT = 10.0;

/* Simulated time (s) for a half width of 1 %: it falls with the root of time. 0: the figure does
 * not vary; NAN: this cannot be told. */
static double time_for_percent(const struct em_cost *cost, int k) {
  const size_t blocks = em_precision_blocks(cost->precision);
  const double width = em_mill_cost_width(&cost->figure[k]), r = width / 0.01;
  if (width == 0.0) return 0.0;
  if (width > 1.0 || (double)blocks < LEAST_INDEPENDENT * cost->figure[k].inefficiency) return NAN;
  return em_precision_time(cost->precision, blocks) * r * r;
}

static void one_percent_table(struct em_report *report, const struct em_cost *cost) {
  em_report_begin(report, "one_percent", "one per cent takes");
  em_report_column(report, "figure", "figure", "");
  em_report_column(report, "value", "value", "");
  em_report_column(report, "unit", "", "");
  em_report_column(report, "inefficiency", "blocks that count as one", "");
  em_report_column(report, "time", "simulated", "s");
  em_report_column(report, "cpu", "computing", "s");
  bool brief = false, exact = false;
  for (int k = 0; k < EM_PRECISION_COUNT; k++) {
    if (!isfinite(em_mill_cost_width(&cost->figure[k]))) continue;
    const double time = time_for_percent(cost, k);
    em_report_text(report, "%s", em_precision_words((enum em_precision_kind)k));
    em_report_interval(report, &cost->figure[k]);
    em_report_text(report, "%s", em_precision_unit((enum em_precision_kind)k));
    em_report_number(report, cost->figure[k].inefficiency);
    em_report_number(report, time);
    em_report_number(report, time * cost->cpu_per_time);
    brief = brief || isnan(time);
    exact = exact || time == 0.0;
  }
  if (brief)
    em_report_note(
        report,
        "one per cent: - where fewer than %g of the %zu blocks of time count, or a width "
        "exceeds its figure: too little to tell; run longer: --time above %.2g.",
        LEAST_INDEPENDENT, em_precision_blocks(cost->precision), cost->time);
  if (exact) em_report_note(report, "one per cent: 0 s where the figure is exact.");
}

static void statistics_table(struct em_report *report, const struct em_cost *cost) {
  em_report_begin(report, "statistics",
                  "statistics against time: half width of the confidence interval (95 %)");
  em_report_column(report, "time", "simulated", "s");
  em_report_column(report, "cpu", "computing", "s");
  shift_columns(report);
  const size_t all = em_precision_blocks(cost->precision);
  for (size_t n = all / 8; n > 0 && n <= all; n *= 2) {
    const double time = em_precision_time(cost->precision, n);
    em_report_number(report, time);
    em_report_number(report, time * cost->cpu_per_time);
    for (int k = 0; k < EM_PRECISION_COUNT; k++) {
      const struct em_interval f =
          em_precision_figure(cost->precision, n, (enum em_precision_kind)k, 3.0, 0.95);
      em_report_percent(report, em_mill_cost_width(&f));
    }
  }
}

static void note_flights(struct em_report *report, const struct em_cost *cost) {
  if (cost->sampled)
    em_report_note(report,
                   "contact times: against 113 bits, over %zu flights of this scene; 0 seen means "
                   "less than %.3g in 1e9 (95 %%).",
                   cost->sampled, 3e9 / (double)cost->sampled);
  else if (cost->flights)
    em_report_note(report,
                   "contact times: none judged; the scene has neither drum nor blades, or nothing "
                   "comes to contact.");
}

static void note_recording(struct em_report *report, const struct em_cost *cost) {
  for (size_t k = 0; k < cost->count; k++) {
    const struct em_cost_result *r = &cost->result[k];
    if (!belongs(r, EM_COST_RECORDING) || r->failed || isfinite(r->time)) continue;
    em_report_note(report,
                   "recording: - where a turn takes less than %g s of computing: too little to "
                   "tell; run longer: --time above %.2g.",
                   EM_COST_LEAST_RUN, cost->time);
    return;
  }
}

static void notes(struct em_report *report, const struct em_cost *cost) {
  size_t measured = 0;
  note_flights(report, cost);
  note_recording(report, cost);
  em_report_note(
      report,
      "d: diameter of a ball. time: from the least times in %d turns (of runs that record: "
      "%d); from, to: of the turns one by one.",
      cost->rounds, EM_COST_WHOLE_RUNS * cost->rounds);
  const double time = time_for_percent(cost, EM_PRECISION_RATE);
  if (time > 0.0)
    em_report_note(report,
                   "1 %% on the rate above 3 m/s takes %.2g s simulated, %.2g s of computing.",
                   time, time * cost->cpu_per_time);
  em_report_note(report, "level fast is tolerance 1e-6 d; level reference is polish: 113 bits.");
  if (cost->cut[0])
    em_report_note(report, "the scene as it is goes on for %.4g s only: %s", cost->long_time,
                   cost->cut);
  for (size_t k = 0; k < cost->count; k++) {
    measured += cost->result[k].measured;
    if (cost->result[k].failed)
      em_report_note(report, "%s: %s", cost->result[k].variant.name, cost->result[k].why);
  }
  if (measured < cost->count)
    em_report_note(report, "interrupted: %zu of %zu variants are measured.", measured, cost->count);
}

static void facts(struct em_report *report, const struct em_cost *cost) {
  em_report_fact_text(report, "scene", "scene", "%s", cost->path);
  em_report_fact(report, "steady", "steady from", cost->steady, "s");
  em_report_fact(report, "time", "each turn", cost->time, "s");
  em_report_fact(report, "long_time", "figures over", cost->long_time, "s");
  em_report_fact(report, "cpu_per_time", "computing time", cost->cpu_per_time, "s per simulated s");
  em_report_fact(report, "collisions_per_time", "collisions", cost->collisions_per_time, "/s");
  em_report_fact(report, "energy", "energy error", cost->energy, "relative");
}

/* ---------------------------------------------------------------- all of it */

static enum em_status write_csv(const struct em_report *report, const char *path,
                                struct em_error *err) {
  struct em_output file;
  const enum em_status status = em_output_begin(&file, path, EM_OUTPUT_STREAM, err);
  if (status) return status;
  return em_output_end(&file, em_report_print(report, EM_REPORT_CSV, file.out, err), err);
}

enum em_status em_mill_cost_report(const struct em_cost *cost, bool json, const char *csv,
                                   struct em_error *err) {
  struct em_report *report = em_report_new("cost");
  facts(report, cost);
  accuracy_table(report, cost);
  effects_table(report, cost);
  recording_table(report, cost);
  statistics_table(report, cost);
  one_percent_table(report, cost);
  notes(report, cost);
  enum em_status status =
      em_report_print(report, json ? EM_REPORT_JSON : EM_REPORT_TEXT, stdout, err);
  if (!status && csv) status = write_csv(report, csv, err);
  em_report_free(report);
  return status;
}
