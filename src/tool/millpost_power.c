/* millpost power: what the motor must deliver, and where the energy goes. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/plot.h"
#include "tool/balance.h"
#include "tool/gather.h"
#include "tool/millpost.h"
#include "tool/window.h"

static const char *const option_names[] = {"from", "to", "above", "level", "curve", "output", ""};

static const struct em_millpost_help help = {
    .name = "power",
    .arguments = "RUN",
    .summary = "Tells what power the rotor takes, and where the energy goes.",
    .details = "The power is found in three ways: the work done in the contacts with blades, the "
               "torque on\n"
               "each blade times its speed, and the energy balance (growth of the balls' energy + "
               "what all\n"
               "contacts dissipate). The share of dissipation above a threshold speed needs the "
               "collision\n"
               "table; without it the share of Σ ½ m v_n² is given. --curve: power against time, "
               "between\n"
               "one sample of the observables and the next.",
    .examples = "  millpost power simoloyer-2l.h5 -o power.png\n"
                "  millpost power simoloyer-2l.h5 --above 2 --json",
    .options = option_names,
    .least = 1,
    .most = 1,
};

/* ---------------------------------------------------------------- facts */

static void input_facts(struct em_report *report, const struct em_balance *b, double level) {
  const double torque = em_balance_by_torque(b), energy = em_balance_by_energy(b);
  if (b->blades > 0) {
    const struct em_interval power = em_trace_rate_interval(&b->work, 0, b->work.width, level);
    em_report_fact_interval(report, "power", "power of the blades", &power, "W");
    em_report_fact(report, "power_by_torque", "  by torque × speed", torque, "W");
    em_report_fact(report, "power_by_energy", "  by energy balance", energy, "W");
  }
  if (b->drum.count > 0)
    em_report_fact(report, "power_drum", "power of the drum",
                   em_trace_rate(&b->drum, 0, b->drum.width), "W");
  const double dissipated = em_balance_dissipated(b), stored = em_balance_stored(b);
  em_report_fact(report, "dissipated", "dissipated", dissipated, "W");
  em_report_fact(report, "stored", "stored", stored, "W");
  em_report_fact(report, "imbalance", "largest difference / energy", em_balance_mismatch(b), "");
  if (b->falls)
    em_report_note(report, "There is no balance of energy: gravity pulls the balls across a "
                           "periodic boundary.");
}

/* The part of the window that lies between two samples of the observables; what is told of it is
 * told of this part. */
static struct em_window sampled(const struct em_balance *b, const struct em_window *window,
                                struct em_report *report) {
  struct em_window part = *window;
  part.from = b->lost.time[0];
  part.to = b->lost.time[b->lost.count - 1];
  part.closed = window->closed && part.to == window->to;
  const double slack = 1e-9 * (window->to - window->from);
  if (part.from > window->from + slack || part.to < window->to - slack)
    em_report_note(report,
                   "Power and energy are told from %g s to %g s, between samples of the "
                   "observables.",
                   part.from, part.to);
  return part;
}

static void specific_facts(struct em_report *report, const struct em_balance *b,
                           const struct em_balls *balls) {
  double mass = 0.0;
  for (size_t i = 0; i < balls->count; i++)
    mass += balls->mass[i];
  const double dissipated = em_balance_dissipated(b);
  em_report_fact(report, "ball_mass", "mass of all balls", mass, "kg");
  em_report_fact(report, "dissipated_per_ball", "dissipated per ball",
                 dissipated / (double)balls->count, "W");
  em_report_fact(report, "dissipated_per_kg", "dissipated per kg of balls", dissipated / mass,
                 "W/kg");
}

/* ---------------------------------------------------------------- efficiency */

/* Sums per class of what lies above the threshold, and of everything. */
struct useful {
  double above[EM_CLASS_COUNT], all[EM_CLASS_COUNT];
  bool dissipated; /* true: J dissipated; false: J of ½ m_eff v_n² */
  struct em_window window;
};

static enum em_status from_table(struct useful *useful, const struct em_run_file *run,
                                 const struct em_window *window, double threshold,
                                 struct em_error *err) {
  struct em_rows *rows =
      em_run_file_rows_new(EM_COLUMN_TIME | EM_COLUMN_CLASS | EM_COLUMN_VN | EM_COLUMN_LOST);
  if (!rows) return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  useful->dissipated = true;
  enum em_status status = EM_OK;
  for (uint64_t first = 0; status == EM_OK; first += rows->count) {
    status = em_run_file_rows(run, first, rows, err);
    if (status != EM_OK || rows->count == 0) break;
    for (size_t k = 0; k < rows->count; k++) {
      if (!em_window_has(window, rows->time[k])) continue;
      if (rows->cls[k] >= EM_CLASS_COUNT) continue;
      const double lost = (double)rows->lost[k];
      useful->all[rows->cls[k]] += lost;
      if ((double)rows->vn[k] > threshold) useful->above[rows->cls[k]] += lost;
    }
  }
  em_run_file_rows_free(rows);
  return status;
}

/* Σ v² of a histogram above a speed; counts are spread evenly over their bins. NAN: some lie above
 * all bins. */
static double squares(const struct em_histogram *h, double threshold) {
  double sum = h->above > 0.0 ? NAN : 0.0;
  for (size_t k = 0; k < h->bins; k++) {
    const double high = h->edge[k + 1], low = fmax(h->edge[k], threshold);
    if (low >= high) continue;
    sum += h->count[k] * (high * high * high - low * low * low) / (3.0 * (high - h->edge[k]));
  }
  return sum;
}

/* The mean effective mass of a class cancels within it; Σ ½ m v_n² of the window gives its weight.
 */
static enum em_status from_histograms(struct useful *useful, const struct em_run_file *run,
                                      const struct em_balance *b, const struct em_window *window,
                                      double threshold, struct em_error *err) {
  struct em_gather *gather;
  const enum em_status status = em_gather_new(&gather, run, EM_GATHER_VN, 0, window, err);
  if (status != EM_OK) return status;
  useful->window = em_gather_window(gather, window);
  for (int cls = 0; cls < EM_CLASS_COUNT; cls++) {
    const double all = squares(gather->total[cls], 0.0);
    if (all == 0.0 || b->impact.width != EM_CLASS_COUNT) continue;
    useful->all[cls] = em_trace_rate(&b->impact, (size_t)cls, (size_t)cls + 1) * b->time;
    useful->above[cls] = useful->all[cls] * squares(gather->total[cls], threshold) / all;
  }
  em_gather_free(gather);
  return EM_OK;
}

/* ---------------------------------------------------------------- tables */

static void class_table(struct em_report *report, const struct em_balance *b,
                        const struct useful *useful, double threshold, double level) {
  char heading[96];
  em_report_begin(report, "classes", "Dissipation per class");
  em_report_column(report, "class", "class", "");
  em_report_column(report, "dissipated", "dissipated", "W");
  em_report_column(report, "share", "share", "");
  em_report_column(report, "impact", "Σ ½ m_eff v_n²", "W");
  snprintf(heading, sizeof heading, "%s above %g m/s",
           useful->dissipated ? "of it in contacts" : "of Σ ½ m v_n²", threshold);
  em_report_column(report, "share_above", heading, "");
  const double all = em_balance_dissipated(b);
  double above = 0.0, total = 0.0;
  for (int cls = 0; cls < EM_CLASS_COUNT; cls++) {
    const size_t c = (size_t)cls;
    const struct em_interval lost = em_trace_rate_interval(&b->lost, c, c + 1, level);
    const struct em_interval impact = em_trace_rate_interval(&b->impact, c, c + 1, level);
    em_report_text(report, "%s", em_contact_class_name((enum em_class)cls));
    em_report_interval(report, &lost);
    em_report_percent(report, all > 0.0 ? lost.value / all : NAN);
    em_report_interval(report, &impact);
    const bool any = useful->all[cls] > 0.0 && (lost.value > 0.0 || !useful->dissipated);
    em_report_percent(report, any ? useful->above[cls] / useful->all[cls] : NAN);
    above += useful->above[cls];
    total += useful->all[cls];
  }
  const struct em_interval lost = em_trace_rate_interval(&b->lost, 0, b->lost.width, level);
  const struct em_interval impact = em_trace_rate_interval(&b->impact, 0, b->impact.width, level);
  em_report_text(report, "all");
  em_report_interval(report, &lost);
  em_report_percent(report, all > 0.0 ? 1.0 : NAN);
  em_report_interval(report, &impact);
  em_report_percent(report,
                    total > 0.0 && (all > 0.0 || !useful->dissipated) ? above / total : NAN);
}

static void blade_table(struct em_report *report, const struct em_balance *b, double level) {
  em_report_begin(report, "blades", "Blades");
  em_report_column(report, "blade", "blade", "");
  em_report_column(report, "speed", "speed", "rpm");
  em_report_column(report, "torque", "torque", "N m");
  em_report_column(report, "power", "power", "W");
  for (size_t k = 0; k < b->blades; k++) {
    const struct em_interval torque = em_trace_rate_interval(&b->impulse, k, k + 1, level);
    const struct em_interval power = em_trace_rate_interval(&b->work, k, k + 1, level);
    em_report_count(report, k);
    em_report_number(report, b->omega[k] * 30.0 / M_PI);
    em_report_interval(report, &torque);
    em_report_interval(report, &power);
  }
}

/* ---------------------------------------------------------------- against time */

/* The curves that there can be, and how much power one has between two samples. */
static const struct curve {
  const char *key, *name;
  enum em_plot_style style;
  double (*at)(const struct em_balance *balance, size_t k);
} curves[] = {
    {"dissipated", "dissipated", EM_PLOT_LINE, em_balance_dissipated_at},
    {"power_drum", "drum", EM_PLOT_LINE, em_balance_drum_at},
    {"power_by_torque", "blades, by torque", EM_PLOT_LINE, em_balance_torque_at},
    {"power_by_energy", "blades, by energy balance", EM_PLOT_DASHED, em_balance_energy_at}};

enum { CURVES = sizeof curves / sizeof *curves };

static bool is_shown(const struct em_balance *b, const struct curve *curve) {
  if (curve->at == em_balance_dissipated_at) return true;
  return curve->at == em_balance_drum_at ? b->drum.count > 0 : b->blades > 0;
}

static void curve_table(struct em_report *report, const struct em_balance *b) {
  em_report_begin(report, "curve", "Power against time");
  em_report_column(report, "low", "from", "s");
  em_report_column(report, "high", "to", "s");
  for (size_t c = 0; c < CURVES; c++)
    if (is_shown(b, &curves[c])) em_report_column(report, curves[c].key, curves[c].name, "W");
  if (b->blades > 0) em_report_column(report, "difference", "torque less balance", "W");
  for (size_t k = 0; k + 1 < b->lost.count; k++) {
    em_report_number(report, b->lost.time[k]);
    em_report_number(report, b->lost.time[k + 1]);
    for (size_t c = 0; c < CURVES; c++)
      if (is_shown(b, &curves[c])) em_report_number(report, curves[c].at(b, k));
    if (b->blades > 0)
      em_report_number(report, em_balance_torque_at(b, k) - em_balance_energy_at(b, k));
  }
}

/* Mean power over time between the samples `from` and `to`. */
static double mean_power(const struct em_balance *b, const struct curve *curve, size_t from,
                         size_t to) {
  const double *time = b->lost.time;
  if (to == from + 1) return curve->at(b, from);
  double energy = 0.0;
  for (size_t k = from; k < to; k++)
    energy += curve->at(b, k) * (time[k + 1] - time[k]);
  return energy / (time[to] - time[from]);
}

static enum em_status draw(const struct em_run_file *run, const struct em_balance *b,
                           const char *path, struct em_error *err) {
  const size_t n = b->lost.count - 1, points = n > 400 ? 200 : n;
  double *t = calloc((1 + CURVES) * points, sizeof *t), low = 0.0, high = 0.0;
  if (!t) return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  for (size_t k = 0; k < points; k++)
    t[k] = 0.5 * (b->lost.time[k * n / points] + b->lost.time[(k + 1) * n / points]);
  struct em_plot_series series[CURVES];
  size_t count = 0;
  for (size_t c = 0; c < CURVES; c++) {
    if (!is_shown(b, &curves[c])) continue;
    double *power = t + (1 + count) * points;
    for (size_t k = 0; k < points; k++) {
      power[k] = mean_power(b, &curves[c], k * n / points, (k + 1) * n / points);
      low = fmin(low, power[k]);
      high = fmax(high, power[k]);
    }
    series[count] = (struct em_plot_series){
        .name = curves[c].name, .style = curves[c].style, .count = points, .x = t, .y = power};
    count++;
  }
  const bool rotor = b->blades > 0, drum = b->drum.count > 0;
  char subtitle[256];
  em_plot_subtitle(em_run_file_scene(run), subtitle, sizeof subtitle);
  const struct em_plot plot = {.title = rotor && drum
                                            ? "Power of the rotor and the drum, and dissipation"
                                        : rotor ? "Power of the rotor and dissipation"
                                        : drum  ? "Power of the drum and dissipation"
                                                : "Dissipation",
                               .subtitle = subtitle,
                               .x_label = "time  [s]",
                               .y_label = "power  [W]",
                               .y_low = 1.1 * low,
                               .y_high = 1.3 * high, /* room for the names */
                               .series_count = count,
                               .series = series};
  const enum em_status status = em_plot_draw(&plot, path, err);
  free(t);
  return status;
}

/* ---------------------------------------------------------------- command */

static enum em_status analyse(struct em_report *report, const struct em_run_file *run,
                              const struct em_millpost_options *o, struct em_error *err) {
  struct em_window window;
  struct em_balance balance;
  struct em_balls *balls = NULL;
  struct useful useful = {.dissipated = false};
  const double threshold = isnan(o->above) ? 3.0 : o->above;
  enum em_status status = em_window_find(&window, run, o->from, o->to, err);
  if (status == EM_OK) status = em_run_file_balls(run, &balls, err);
  if (status == EM_OK) status = em_balance_new(&balance, run, &window, err);
  if (status != EM_OK) {
    em_start_free(balls);
    return status;
  }
  useful.window = window;
  const struct em_window part = sampled(&balance, &window, report);
  if (em_run_file_has_rows(run))
    status = from_table(&useful, run, &part, threshold, err);
  else if (em_run_file_block_count(run) > 0)
    status = from_histograms(&useful, run, &balance, &window, threshold, err);
  if (status == EM_OK) {
    em_report_fact_text(report, "run", "run", "%s", o->run[0]);
    em_window_report(report, &window);
    input_facts(report, &balance, o->level);
    specific_facts(report, &balance, balls);
    if (useful.window.from != window.from || useful.window.to != window.to)
      em_report_note(report,
                     "What is above %g m/s is counted from %g s to %g s, in whole blocks of the "
                     "histograms.",
                     threshold, useful.window.from, useful.window.to);
    class_table(report, &balance, &useful, threshold, o->level);
    if (balance.blades > 0) blade_table(report, &balance, o->level);
    if (o->curve) curve_table(report, &balance);
  }
  if (status == EM_OK && o->out) status = draw(run, &balance, o->out, err);
  em_balance_free(&balance);
  em_start_free(balls);
  return status;
}

int em_millpost_power(int argc, char **argv) {
  struct em_millpost_options options;
  const int code = em_millpost_options(&options, &help, argc, argv);
  if (code >= 0) return code;
  struct em_error err = {.code = EM_OK};
  struct em_run_file *run;
  if (em_millpost_open(&run, options.run[0], &err) != EM_OK) return em_millpost_fail(&err);
  struct em_report *report = em_report_new("power");
  const enum em_status status = analyse(report, run, &options, &err);
  em_run_file_close(run);
  if (status == EM_OK) return em_millpost_print(report, &options, EM_MILLPOST_DONE);
  em_report_free(report);
  return em_millpost_fail(&err);
}
