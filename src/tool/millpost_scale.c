/* millpost scale: which speed of the rotor gives the same impacts with other balls, or in another
 * mill? (Reichardt 2005, 3.3 and 21.3) */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/plot.h"
#include "tool/figures.h"
#include "tool/millpost.h"

enum { MOST_RUNS = 512, MOST_GROUPS = 64 };

static const char *const option_names[] = {"from",   "to",    "above",  "match",
                                           "target", "level", "output", ""};

static const struct em_millpost_help help = {
    .name = "scale",
    .arguments = "REFERENCE RUN [RUN ...]",
    .summary =
        "Tells which speed of the rotor gives the same impacts with other balls or in another "
        "mill.",
    .details =
        "The runs of a sweep are sorted into groups that differ in nothing but the speed; in each\n"
        "group the speed is found at which the figure (--match, by default median-vn) equals that "
        "of\n"
        "the first run, by interpolation between neighbours. Beside it stand the rules of thumb: "
        "speed\n"
        "× √(mass of a ball, old/new) for another material, equal tip speed for another size, the\n"
        "same speed for more balls. --match takes every key of 'compare --json', e.g. rate-above.",
    .examples = "  millpost scale 1000rpm-3000.h5 *rpm-5000.h5 -o scale.png\n"
                "  millpost scale steel.h5 ceramic-*.h5 --match rate-above --above 2",
    .options = option_names,
    .least = 2,
    .most = MOST_RUNS,
};

/* One run of the sweep. */
struct point {
  double rpm;
  size_t balls;
  double diameter, density, mass; /* m, kg/m³, kg: of a ball */
  double chamber, length, reach;  /* m */
  struct em_interval y;
  int group;
};

struct answer {
  double rpm, half; /* NAN: not in the range of the runs */
  double low, high; /* range of the runs */
  int runs;
};

/* ---------------------------------------------------------------- reading */

static enum em_status describe(struct point *point, const struct em_run_file *run,
                               struct em_error *err) {
  const struct em_scene *scene = em_run_file_scene(run);
  if (scene->rotor_count == 0 || scene->rotor[0].blade_count == 0 || scene->species_count == 0)
    return em_error_set(err, EM_INPUT, em_run_file_path(run), 0, "scaling needs a rotor and balls");
  const struct em_species *s = &scene->species[0];
  point->rpm = fabs(scene->rotor[0].rpm);
  point->balls = em_scene_ball_count(scene);
  point->diameter = s->diameter;
  point->density = s->density;
  point->mass = s->density * M_PI / 6.0 * s->diameter * s->diameter * s->diameter;
  point->chamber = scene->chamber.diameter;
  point->length = scene->chamber.length;
  point->reach = scene->rotor[0].blade[0].reach;
  return EM_OK;
}

static enum em_status read_point(struct point *point, const char *path,
                                 const struct em_millpost_options *o, int kind,
                                 struct em_error *err) {
  struct em_run_file *run;
  enum em_status status = em_run_file_open(&run, path, err);
  if (status != EM_OK) return status;
  status = describe(point, run, err);
  struct em_figures figures;
  if (status == EM_OK)
    status = em_figures_read(&figures, run, o->from, o->to, isnan(o->above) ? 3.0 : o->above,
                             o->level, err);
  em_run_file_close(run);
  if (status != EM_OK) return status;
  point->y = figures.value[kind];
  if (point->y.value > 0.0 && point->rpm > 0.0) return EM_OK;
  return em_error_set(err, EM_INPUT, path, 0, "no value of '%s' at a speed above 0",
                      em_figures_key((enum em_figures_kind)kind));
}

static bool is_alike(const struct point *a, const struct point *b) {
  return a->balls == b->balls && a->diameter == b->diameter && a->density == b->density &&
         a->chamber == b->chamber && a->length == b->length && a->reach == b->reach;
}

/* Numbers the groups in the order of the command line; returns how many there are. */
static int sort_into_groups(struct point *point, int count) {
  int groups = 0;
  for (int k = 0; k < count; k++) {
    point[k].group = -1;
    for (int j = 0; j < k && point[k].group < 0; j++)
      if (is_alike(&point[j], &point[k])) point[k].group = point[j].group;
    if (point[k].group < 0) point[k].group = groups++;
  }
  return groups;
}

static int by_speed(const void *a, const void *b) {
  const struct point *p = a, *q = b;
  if (p->group != q->group) return p->group < q->group ? -1 : 1;
  return (p->rpm > q->rpm) - (p->rpm < q->rpm);
}

/* ---------------------------------------------------------------- the answer */

/* Between two runs, ln y is linear in ln rpm. */
static void between(struct answer *answer, const struct point *a, const struct point *b,
                    double target, double target_half) {
  const double dx = log(b->rpm / a->rpm), dy = log(b->y.value / a->y.value);
  const double s = log(target / a->y.value) / dy;
  if (!(s >= 0.0 && s <= 1.0) || isfinite(answer->rpm)) return;
  const double at_a = (1.0 - s) * a->y.half / a->y.value, at_b = s * b->y.half / b->y.value;
  const double half = sqrt(at_a * at_a + at_b * at_b + pow(target_half / target, 2.0));
  answer->rpm = a->rpm * exp(s * dx);
  answer->half = answer->rpm * half * fabs(dx / dy);
}

/* Points of a group are sorted by speed. The reference itself answers for its own group. */
static struct answer solve(const struct point *point, int count, int group, double target,
                           double target_half) {
  struct answer answer = {NAN, NAN, INFINITY, -INFINITY, 0};
  const struct point *before = NULL;
  for (int k = 0; k < count; k++) {
    if (point[k].group != group) continue;
    answer.low = fmin(answer.low, point[k].rpm);
    answer.high = fmax(answer.high, point[k].rpm);
    answer.runs++;
    if (before && before->rpm < point[k].rpm)
      between(&answer, before, &point[k], target, target_half);
    before = &point[k];
  }
  return answer;
}

/* (3-2), (3-3), and the same speed for more balls. */
static double rule_of_thumb(const struct point *reference, const struct point *p) {
  return reference->rpm * sqrt(reference->mass / p->mass) * reference->reach / p->reach;
}

/* ---------------------------------------------------------------- table and diagram */

static void group_name(char *text, size_t size, const struct point *p) {
  snprintf(text, size, "%zu balls of %g mm, %g kg/m³, drum %g mm", p->balls, 1e3 * p->diameter,
           p->density, 1e3 * p->chamber);
}

static const struct point *first_of(const struct point *point, int count, int group) {
  for (int k = 0; k < count; k++)
    if (point[k].group == group) return &point[k];
  return NULL;
}

static void columns(struct em_report *report) {
  em_report_begin(report, "groups", NULL);
  em_report_column(report, "group", "group", "");
  em_report_column(report, "runs", "runs", "");
  em_report_column(report, "lowest", "from", "rpm");
  em_report_column(report, "highest", "to", "rpm");
  em_report_column(report, "speed", "equal at", "rpm");
  em_report_column(report, "rule", "rule of thumb", "rpm");
  em_report_column(report, "difference", "needed / rule", "");
}

static void table(struct em_report *report, const struct point *point, int count, int groups,
                  const struct point *reference, double target, double target_half) {
  columns(report);
  for (int g = 0; g < groups; g++) {
    const struct point *p = first_of(point, count, g);
    const bool own = is_alike(p, reference) && target == reference->y.value;
    const struct answer a = solve(point, count, g, target, target_half);
    const struct em_interval speed = {own ? reference->rpm : a.rpm, own ? 0.0 : a.half, NAN, 0, 1};
    const double rule = rule_of_thumb(reference, p);
    char name[128];
    group_name(name, sizeof name, p);
    em_report_text(report, "%s", name);
    em_report_count(report, (uint64_t)a.runs);
    em_report_number(report, a.low);
    em_report_number(report, a.high);
    em_report_interval(report, &speed);
    em_report_number(report, rule);
    em_report_percent(report, speed.value / rule);
    if (isnan(speed.value))
      em_report_note(report, "%s: the value is not reached between %g and %g rpm; add runs.", name,
                     a.low, a.high);
  }
}

static enum em_status draw(const struct point *point, int count, int groups, int kind,
                           double target, const char *path, struct em_error *err) {
  double *cell = malloc(3 * (size_t)count * sizeof *cell);
  if (!cell) return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  struct em_plot_series series[2 * MOST_GROUPS];
  char name[MOST_GROUPS][128], label[128];
  double *x = cell, *y = cell + count, *half = cell + 2 * count;
  size_t used = 0, n = 0;
  for (int g = 0; g < groups && g < MOST_GROUPS; g++) {
    const size_t first = n;
    for (int k = 0; k < count; k++) {
      if (point[k].group != g) continue;
      x[n] = point[k].rpm;
      y[n] = point[k].y.value;
      half[n++] = point[k].y.half;
    }
    group_name(name[g], sizeof name[g], first_of(point, count, g));
    series[used++] = (struct em_plot_series){
        .style = EM_PLOT_LINE, .count = n - first, .x = x + first, .y = y + first, .colour = g + 1};
    series[used++] = (struct em_plot_series){.name = name[g],
                                             .style = EM_PLOT_POINTS,
                                             .count = n - first,
                                             .x = x + first,
                                             .y = y + first,
                                             .error = half + first,
                                             .colour = g + 1};
  }
  const char *words = em_figures_words((enum em_figures_kind)kind);
  while (*words == ' ')
    words++;
  snprintf(label, sizeof label, "%s  [%s]", words, em_figures_unit((enum em_figures_kind)kind));
  const struct em_plot_mark mark = {target, true, "to be reached"};
  const struct em_plot plot = {.title = "Which speed gives the same impacts?",
                               .x_label = "speed of the rotor  [rpm]",
                               .y_label = label,
                               .series_count = used,
                               .series = series,
                               .mark_count = 1,
                               .mark = &mark,
                               .key_left = true};
  const enum em_status status = em_plot_draw(&plot, path, err);
  free(cell);
  return status;
}

/* ---------------------------------------------------------------- command */

/* A key of the figures, with '-' for '_'; -1: none. */
static int find_figure(const char *name) {
  char key[64];
  snprintf(key, sizeof key, "%s", name);
  for (char *c = key; *c; c++)
    if (*c == '-') *c = '_';
  for (int k = 0; k < EM_FIGURES_COUNT; k++)
    if (strcmp(key, em_figures_key((enum em_figures_kind)k)) == 0) return k;
  return -1;
}

static int run_with(struct point *point, const struct em_millpost_options *o, int kind) {
  struct em_error err = {.code = EM_OK};
  enum em_status status = EM_OK;
  for (int k = 0; k < o->run_count && status == EM_OK; k++)
    status = read_point(&point[k], o->run[k], o, kind, &err);
  if (status != EM_OK) return em_millpost_fail(&err);
  const struct point reference = point[0];
  const bool own = isnan(o->target);
  const double target = own ? reference.y.value : o->target;
  const int groups = sort_into_groups(point, o->run_count);
  qsort(point, (size_t)o->run_count, sizeof *point, by_speed);
  struct em_report *report = em_report_new("scale");
  const char *words = em_figures_words((enum em_figures_kind)kind);
  while (*words == ' ')
    words++;
  em_report_fact_text(report, "match", "held fixed", "%s", words);
  em_report_fact_text(report, "reference", "reference", "%s, %g rpm", o->run[0], reference.rpm);
  em_report_fact(report, "target", "to be reached", target,
                 em_figures_unit((enum em_figures_kind)kind));
  table(report, point, o->run_count, groups, &reference, target, own ? reference.y.half : 0.0);
  if (o->out) status = draw(point, o->run_count, groups, kind, target, o->out, &err);
  const int code = status == EM_OK ? EM_MILLPOST_DONE : em_millpost_fail(&err);
  return em_millpost_print(report, o, code);
}

int em_millpost_scale(int argc, char **argv) {
  struct em_millpost_options o;
  const int code = em_millpost_options(&o, &help, argc, argv);
  if (code >= 0) return code;
  const int kind = find_figure(o.match ? o.match : "median-vn");
  if (kind < 0)
    return em_millpost_usage("scale",
                             "unknown figure '%s', expected median-vn, rate-above or "
                             "another key of 'compare --json'",
                             o.match);
  if (!isnan(o.target) && !(o.target > 0.0))
    return em_millpost_usage("scale", "--target must be above 0");
  struct point *point = calloc((size_t)o.run_count, sizeof *point);
  if (!point) {
    const struct em_error err = {.code = EM_MEMORY};
    return em_millpost_fail(&err);
  }
  const int result = run_with(point, &o, kind);
  free(point);
  return result;
}
