/* millpost fit: laws of restitution fitted to measured pairs (speed, restitution), ranked, and
 * printed as an entry for a scene. (Reichardt 2005, 7.2) */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/contact.h"
#include "eventmill/fit.h"
#include "eventmill/plot.h"
#include "tool/millpost.h"

enum { MOST_POINTS = 1000000 };

static const char *const option_names[] = {"output", ""};

static const struct em_millpost_help help = {
    .name = "fit",
    .arguments = "TABLE",
    .summary = "Fits all laws of restitution to measured pairs of speed (m/s) and restitution.",
    .details =
        "TABLE is a text file with two numbers per line, separated by blanks or a comma; what "
        "follows\n"
        "a # is a comment, and a first line without numbers is a heading. The laws are ranked by\n"
        "Akaike's criterion (the smaller, the better; 2 is a slight difference, 10 a clear one). "
        "The\n"
        "best is printed as an entry for a scene. In place of an error, - stands where a parameter "
        "ends\nat the bound that scenes have for it. Laws that the pairs do not determine, or "
        "whose "
        "curve\nends as the constant, cannot be fitted.",
    .examples = "  millpost fit shots.txt -o shots.png\n"
                "  millpost fit shots.csv --json",
    .options = option_names,
    .least = 1,
    .most = 1,
};

struct pairs {
  size_t n;
  double *v, *e;
};

struct result {
  enum em_law law;
  bool good;
  struct em_fit fit;
};

/* ---------------------------------------------------------------- reading */

static bool add_pair(struct pairs *pairs, double v, double e) {
  if ((pairs->n & (pairs->n - 1)) == 0) {
    const size_t room = pairs->n ? 2 * pairs->n : 1;
    double *more_v = realloc(pairs->v, room * sizeof *more_v);
    if (more_v) pairs->v = more_v;
    double *more_e = realloc(pairs->e, room * sizeof *more_e);
    if (more_e) pairs->e = more_e;
    if (!more_v || !more_e) return false;
  }
  pairs->v[pairs->n] = v;
  pairs->e[pairs->n++] = e;
  return true;
}

/* What a line of the table is: a line of WORDS does not begin with a number. */
enum line { EMPTY, PAIR, WORDS, WRONG };

static const char BLANKS[] = " \t\r\n";

static enum line parse(char *line, double *v, double *e) {
  char *hash = strchr(line, '#'), *end;
  if (hash) *hash = '\0';
  for (char *c = line; *c; c++)
    if (*c == ',' || *c == ';') *c = ' ';
  line += strspn(line, BLANKS);
  if (!*line) return EMPTY;
  *v = strtod(line, &end);
  if (end == line || strcspn(end, BLANKS) > 0) return WORDS;
  char *rest = end;
  *e = strtod(rest, &end);
  return end == rest || end[strspn(end, BLANKS)] ? WRONG : PAIR;
}

static enum em_status add_line(struct pairs *pairs, char *line, const char *path, int number,
                               struct em_error *err) {
  static const char mark[] = "\xEF\xBB\xBF"; /* of UTF-8, as some editors put it */
  double v, e;
  if (number == 1 && strncmp(line, mark, strlen(mark)) == 0) line += strlen(mark);
  const enum line kind = parse(line, &v, &e);
  if (kind == EMPTY || (kind == WORDS && number == 1)) return EM_OK;
  if (kind != PAIR)
    return em_error_set(err, EM_INPUT, path, number, "expected two numbers, speed and restitution");
  if (!(v >= 0.0) || !isfinite(v))
    return em_error_set(err, EM_INPUT, path, number, "the speed %g is not ≥ 0 m/s", v);
  if (!(e >= 0.0 && e <= 1.5))
    return em_error_set(err, EM_INPUT, path, number, "the restitution %g is not in 0 … 1.5", e);
  if (pairs->n == MOST_POINTS)
    return em_error_set(err, EM_INPUT, path, number, "more than %d pairs", MOST_POINTS);
  return add_pair(pairs, v, e) ? EM_OK : em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
}

static enum em_status read_lines(struct pairs *pairs, FILE *in, const char *path,
                                 struct em_error *err) {
  char *line = NULL;
  size_t size = 0;
  enum em_status status = EM_OK;
  for (int number = 1; status == EM_OK && getline(&line, &size, in) >= 0; number++)
    status = add_line(pairs, line, path, number, err);
  free(line);
  if (status != EM_OK) return status;
  if (ferror(in)) return em_error_set(err, EM_FILE, path, 0, "cannot be read");
  if (pairs->n >= 2 * EM_LAW_PARAMETERS) return EM_OK;
  return em_error_set(err, EM_INPUT, path, 0, "only %zu pairs, at least %d are needed", pairs->n,
                      2 * EM_LAW_PARAMETERS);
}

static enum em_status read_pairs(struct pairs *pairs, const char *path, struct em_error *err) {
  FILE *in = fopen(path, "r");
  if (!in) return em_error_set(err, EM_INPUT, path, 0, "cannot be read: %s", strerror(errno));
  const enum em_status status = read_lines(pairs, in, path, err);
  fclose(in);
  return status;
}

/* ---------------------------------------------------------------- fitting */

/* Scenes allow no negative parameters, and no constant above 1: p and −p are the same curve, as are
 * all constants from 1 on. */
static double bounded(enum em_law law, double p) {
  return law == EM_LAW_CONSTANT ? fmin(fabs(p), 1.0) : fabs(p);
}

static double value(double v, const double *p, const void *self) {
  struct em_restitution law = {.law = *(const enum em_law *)self};
  for (int k = 0; k < em_contact_law_size(law.law); k++)
    law.p[k] = bounded(law.law, p[k]);
  return em_contact_restitution(&law, v);
}

/* The best end of fits from the default parameters and from multiples of them; `zero` stands for a
 * parameter that is 0 by default. */
static void fit_from(struct result *best, const struct pairs *pairs, double zero) {
  static const double factor[] = {1.0, 0.5, 2.0, 0.2, 5.0};
  const struct em_restitution standard = em_contact_law_default(best->law);
  const struct em_fit_model model = {em_contact_law_size(best->law), value, &best->law};
  for (size_t k = 0; k < sizeof factor / sizeof *factor; k++) {
    double start[EM_LAW_PARAMETERS];
    struct em_fit fit;
    for (int j = 0; j < model.parameters; j++)
      start[j] = factor[k] * (standard.p[j] != 0.0 ? standard.p[j] : zero);
    if (em_fit_curve(&fit, &model, pairs->n, pairs->v, pairs->e, start, NULL) != EM_OK) continue;
    if (!fit.converged || !isfinite(fit.residual)) continue;
    if (best->good && fit.residual >= best->fit.residual) continue;
    for (int j = 0; j < model.parameters; j++)
      fit.p[j] = bounded(best->law, fit.p[j]);
    best->good = true;
    best->fit = fit;
  }
}

/* Is the curve the same at all speeds up to twice the largest? Then it is the constant law. */
static bool is_flat(const struct result *result, const struct pairs *pairs) {
  enum { POINTS = 64 };
  double fastest = 0.0, low = INFINITY, high = -INFINITY;
  for (size_t i = 0; i < pairs->n; i++)
    fastest = fmax(fastest, pairs->v[i]);
  for (int i = 1; i <= POINTS; i++) {
    const double e = value(2.0 * fastest * i / POINTS, result->fit.p, &result->law);
    low = fmin(low, e);
    high = fmax(high, e);
  }
  return high - low < 1e-6;
}

/* Do the pairs tell the law? Of a parameter at its bound 0 they can tell no error. */
static bool is_told(const struct result *result, const struct pairs *pairs) {
  if (result->law == EM_LAW_CONSTANT) return true;
  for (int j = 0; j < result->fit.parameters; j++)
    if (isnan(result->fit.error[j]) && result->fit.p[j] > 0.0) return false;
  return !is_flat(result, pairs);
}

/* As p and −p are the same curve, its slope at p = 0 is 0: a parameter that starts there stays. */
static struct result fit_law(enum em_law law, const struct pairs *pairs) {
  const struct em_restitution standard = em_contact_law_default(law);
  struct result best = {.law = law, .good = false};
  bool has_zero = false;
  for (int j = 0; j < em_contact_law_size(law); j++)
    has_zero = has_zero || standard.p[j] == 0.0;
  fit_from(&best, pairs, 0.1);
  if (has_zero) fit_from(&best, pairs, 0.0);
  best.good = best.good && is_told(&best, pairs);
  return best;
}

static int by_aic(const void *a, const void *b) {
  const struct result *p = a, *q = b;
  if (p->good != q->good) return p->good ? -1 : 1;
  return (p->fit.aic > q->fit.aic) - (p->fit.aic < q->fit.aic);
}

/* ---------------------------------------------------------------- output */

static void tables(struct em_report *report, const struct result *result) {
  em_report_begin(report, "ranking", "Laws, the best first");
  em_report_column(report, "law", "law", "");
  em_report_column(report, "parameters", "parameters", "");
  em_report_column(report, "residual", "Σ (ε − fit)²", "");
  em_report_column(report, "sigma", "σ", "");
  em_report_column(report, "aic", "AIC", "");
  em_report_column(report, "delta_aic", "above the best", "");
  for (int k = 0; k < EM_LAW_COUNT && result[k].good; k++) {
    em_report_text(report, "%s", em_contact_law_name(result[k].law));
    em_report_count(report, (uint64_t)result[k].fit.parameters);
    em_report_number(report, result[k].fit.residual);
    em_report_number(report, result[k].fit.sigma);
    em_report_number(report, result[k].fit.aic);
    em_report_number(report, result[k].fit.aic - result[0].fit.aic);
  }
  em_report_begin(report, "parameters", "Parameters, ± standard error");
  em_report_column(report, "law", "law", "");
  em_report_column(report, "name", "parameter", "");
  em_report_column(report, "value", "value", "");
  em_report_column(report, "error", "±", "");
  for (int k = 0; k < EM_LAW_COUNT && result[k].good; k++)
    for (int j = 0; j < result[k].fit.parameters; j++) {
      em_report_text(report, "%s", em_contact_law_name(result[k].law));
      em_report_text(report, "%s", em_contact_law_parameter(result[k].law, j));
      em_report_number(report, result[k].fit.p[j]);
      em_report_number(report, result[k].fit.error[j]);
    }
}

static void snippet(struct em_report *report, const struct result *best) {
  char text[512];
  int used = snprintf(text, sizeof text, "contact = { normal = { law = \"%s\";",
                      em_contact_law_name(best->law));
  for (int j = 0; j < best->fit.parameters; j++)
    used += snprintf(text + used, sizeof text - (size_t)used, " %s = %#.6g;",
                     em_contact_law_parameter(best->law, j), best->fit.p[j]);
  snprintf(text + used, sizeof text - (size_t)used, " }; };");
  em_report_fact_text(report, "scene", "for a scene", "%s", text);
}

static enum em_status draw(const struct pairs *pairs, const struct result *result, const char *path,
                           struct em_error *err) {
  enum { POINTS = 300 };
  double high = 0.0, x[POINTS], y[EM_LAW_COUNT][POINTS];
  struct em_plot_series series[EM_LAW_COUNT + 1];
  for (size_t i = 0; i < pairs->n; i++)
    high = fmax(high, pairs->v[i]);
  for (int i = 0; i < POINTS; i++)
    x[i] = high * i / (POINTS - 1.0);
  series[0] = (struct em_plot_series){.name = "measured",
                                      .style = EM_PLOT_POINTS,
                                      .count = pairs->n,
                                      .x = pairs->v,
                                      .y = pairs->e,
                                      .colour = 1};
  size_t count = 1;
  for (int k = 0; k < EM_LAW_COUNT && result[k].good; k++) {
    for (int i = 0; i < POINTS; i++)
      y[k][i] = value(x[i], result[k].fit.p, &result[k].law);
    series[count] = (struct em_plot_series){.name = em_contact_law_name(result[k].law),
                                            .style = k == 0 ? EM_PLOT_LINE : EM_PLOT_DASHED,
                                            .count = POINTS,
                                            .x = x,
                                            .y = y[k],
                                            .colour = k + 2};
    count++;
  }
  char subtitle[160];
  snprintf(subtitle, sizeof subtitle, "%zu pairs; best by Akaike's criterion: %s, σ = %.3g",
           pairs->n, em_contact_law_name(result[0].law), result[0].fit.sigma);
  const struct em_plot plot = {.title = "Normal restitution",
                               .subtitle = subtitle,
                               .x_label = "normal speed v_n  [m/s]",
                               .y_label = "restitution ε_n",
                               .series_count = count,
                               .series = series};
  return em_plot_draw(&plot, path, err);
}

/* ---------------------------------------------------------------- command */

static int run_with(struct pairs *pairs, const struct em_millpost_options *o) {
  struct em_error err = {.code = EM_OK};
  if (read_pairs(pairs, o->run[0], &err) != EM_OK) return em_millpost_fail(&err);
  struct result result[EM_LAW_COUNT];
  for (int law = 0; law < EM_LAW_COUNT; law++)
    result[law] = fit_law((enum em_law)law, pairs);
  qsort(result, EM_LAW_COUNT, sizeof *result, by_aic);
  if (!result[0].good) {
    em_error_set(&err, EM_NUMERIC, o->run[0], 0, "no law can be fitted");
    return em_millpost_fail(&err);
  }
  struct em_report *report = em_report_new("fit");
  em_report_fact_text(report, "table", "table", "%s", o->run[0]);
  em_report_fact_count(report, "pairs", "pairs", pairs->n);
  em_report_fact_text(report, "best", "best law", "%s", em_contact_law_name(result[0].law));
  snippet(report, &result[0]);
  tables(report, result);
  for (int k = 0; k < EM_LAW_COUNT; k++)
    if (!result[k].good)
      em_report_note(report, "%s cannot be fitted to these pairs.",
                     em_contact_law_name(result[k].law));
    else if (result[k].law == EM_LAW_CONSTANT && result[k].fit.p[0] == 1.0)
      em_report_note(report, "The constant ends at 1, the largest that scenes accept.");
  int code = EM_MILLPOST_DONE;
  if (o->out && draw(pairs, result, o->out, &err) != EM_OK) code = em_millpost_fail(&err);
  return em_millpost_print(report, o, code);
}

int em_millpost_fit(int argc, char **argv) {
  struct em_millpost_options options;
  const int code = em_millpost_options(&options, &help, argc, argv);
  if (code >= 0) return code;
  struct pairs pairs = {0, NULL, NULL};
  const int result = run_with(&pairs, &options);
  free(pairs.v);
  free(pairs.e);
  return result;
}
