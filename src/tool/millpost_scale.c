/* millpost scale: which speed of the rotor gives the same impacts with other balls, or in another
 * mill? (Reichardt 2005, 3.3 and 21.3) */
#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/plot.h"
#include "eventmill/start.h"
#include "tool/figures.h"
#include "tool/millpost.h"

enum { MOST_RUNS = 512, MOST_GROUPS = 64, NAME = 256 };

static const char *const option_names[] = {"from",   "to",    "above",  "match",
                                           "target", "level", "output", ""};

static const struct em_millpost_help help = {
    .name = "scale",
    .arguments = "REFERENCE RUN [RUN ...]",
    .summary =
        "Tells which speed of the rotor gives the same impacts with other balls or in another "
        "mill.",
    .details =
        "The runs of a sweep are sorted into groups that differ in nothing but the speed, seed,\n"
        "duration and what is recorded; runs at one speed are averaged. In each group the speed is "
        "found at which the figure (--match, by default median-vn) equals that "
        "of\n"
        "the first run, by interpolation between neighbours. Beside it stand the rules of thumb: "
        "speed\n"
        "× √(mean mass of a ball, old/new) for another material, equal tip speed for another size, "
        "the\n"
        "same speed for more balls. --match takes every key of 'compare --json', e.g. rate-above.",
    .examples = "  millpost scale 1000rpm-3000.h5 *rpm-5000.h5 -o scale.png\n"
                "  millpost scale steel.h5 ceramic-*.h5 --match rate-above --above 2",
    .options = option_names,
    .least = 2,
    .most = MOST_RUNS,
};

/* One run of the sweep, or the mean of several at one speed. */
struct point {
  char label[96];
  char *kind; /* what runs of a group have in common, owned */
  double rpm;
  char balls[192]; /* how many of which species */
  double mass;     /* kg: of a ball, on average */
  struct em_chamber chamber;
  double reach; /* m */
  enum em_end end;
  double time;     /* s, simulated */
  double from, to; /* s, window of the figure */
  struct em_interval y;
  int group, runs;
};

struct answer {
  double rpm, half; /* NAN: not in the range of the runs */
  double low, high; /* range of the runs */
  int runs;
  bool several; /* it is reached at other speeds as well: rpm is the lowest */
};

/* ---------------------------------------------------------------- reading */

static double relative(double speed, double to) {
  return (double)(float)(speed / to); /* a rounded ratio is the same at each speed */
}

/* What follows from the rest of the scene, the speed included, takes values that no scene has. */
static void leave_out_what_follows(struct em_scene *scene) {
  int after;
  double within;
  em_scene_jam(scene, &after, &within);
  if (scene->remedy.jam_after == after) scene->remedy.jam_after = -1;
  if (scene->remedy.jam_within == within) scene->remedy.jam_within = -1.0;
}

/* The scene without what may differ between runs of a group: the rotor's speed, to which others are
 * relative, seed, duration, what is recorded, the title. */
static enum em_status read_kind(char **kind, const struct em_run_file *run, struct em_error *err) {
  struct em_scene *scene;
  const enum em_status status =
      em_scene_parse(&scene, em_run_file_scene_text(run), em_run_file_path(run), 0, NULL, err);
  if (status != EM_OK) return status;
  leave_out_what_follows(scene);
  const double rpm = scene->rotor[0].rpm, omega = rpm * M_PI / 30.0;
  for (size_t r = 0; r < scene->rotor_count; r++) {
    struct em_rotor *rotor = &scene->rotor[r];
    rotor->rpm = relative(rotor->rpm, rpm);
    for (size_t k = 0; k < rotor->blade_count; k++)
      rotor->blade[k].omega = relative(rotor->blade[k].omega, omega);
  }
  scene->title[0] = '\0';
  scene->seed = 0;
  scene->duration = 0.0;
  scene->record = (struct em_recording){.frames = 0.0};
  *kind = em_scene_text(scene);
  em_scene_free(scene);
  return *kind ? EM_OK : em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
}

/* Of many species, how many there are. */
static void describe_balls(struct point *point, const struct em_scene *scene) {
  enum { TOLD = 3 };
  const size_t balls = em_scene_ball_count(scene), kinds = scene->species_count;
  size_t used = 0;
  point->mass = 0.0;
  for (size_t k = 0; k < kinds; k++) {
    const struct em_species *s = &scene->species[k];
    point->mass += (double)s->count / (double)balls * em_start_mass(s);
    if (kinds <= TOLD)
      used += (size_t)snprintf(point->balls + used, sizeof point->balls - used,
                               "%s%zu balls of %g mm, %g kg/m³", k > 0 ? " and " : "",
                               (size_t)s->count, 1e3 * s->diameter, s->density);
  }
  if (kinds > TOLD)
    snprintf(point->balls, sizeof point->balls, "%zu balls of %zu species", balls, kinds);
}

static enum em_status describe(struct point *point, const struct em_run_file *run,
                               struct em_error *err) {
  const struct em_scene *scene = em_run_file_scene(run);
  if (scene->rotor_count == 0 || scene->rotor[0].blade_count == 0 || scene->rotor[0].rpm == 0.0 ||
      scene->species_count == 0)
    return em_error_set(err, EM_INPUT, em_run_file_path(run), 0,
                        "scaling needs a rotor that turns, and balls");
  point->rpm = fabs(scene->rotor[0].rpm);
  describe_balls(point, scene);
  point->chamber = scene->chamber;
  point->reach = scene->rotor[0].blade[0].reach;
  point->time = em_run_file_state(run)->time;
  point->end = em_run_file_state(run)->end;
  em_millpost_label(em_run_file_path(run), point->label, sizeof point->label);
  return read_kind(&point->kind, run, err);
}

static enum em_status read_point(struct point *point, const char *path,
                                 const struct em_millpost_options *o, int kind,
                                 struct em_error *err) {
  struct em_run_file *run;
  enum em_status status = em_millpost_open(&run, path, err);
  if (status != EM_OK) return status;
  status = describe(point, run, err);
  struct em_figures figures;
  if (status == EM_OK)
    status = em_figures_read(&figures, run, o->from, o->to, isnan(o->above) ? 3.0 : o->above,
                             o->level, err);
  em_run_file_close(run);
  if (status != EM_OK) return status;
  const struct em_window *window = em_figures_window(&figures, (enum em_figures_kind)kind);
  point->from = window->from;
  point->to = window->to;
  point->y = figures.value[kind];
  if (point->y.value > 0.0) return EM_OK;
  return em_error_set(err, EM_INPUT, path, 0, "no value of '%s'",
                      em_figures_key((enum em_figures_kind)kind));
}

/* Numbers the groups in the order of the command line; returns how many there are. */
static int sort_into_groups(struct point *point, int count) {
  int groups = 0;
  for (int k = 0; k < count; k++) {
    point[k].group = -1;
    for (int j = 0; j < k && point[k].group < 0; j++)
      if (strcmp(point[j].kind, point[k].kind) == 0) point[k].group = point[j].group;
    if (point[k].group < 0) point[k].group = groups++;
  }
  return groups;
}

/* Equal speeds by their values, so that sums do not depend on the order of the command line. */
static int by_speed(const void *a, const void *b) {
  const struct point *p = a, *q = b;
  if (p->group != q->group) return p->group < q->group ? -1 : 1;
  if (p->rpm != q->rpm) return p->rpm < q->rpm ? -1 : 1;
  return (p->y.value > q->y.value) - (p->y.value < q->y.value);
}

/* Sorted points to means of the runs at one speed, whose half widths add like errors. Returns how
 * many there are. */
static int average(struct point *mean, const struct point *point, int count) {
  int means = 0;
  for (int first = 0, next; first < count; first = next) {
    double sum = 0.0, square = 0.0;
    for (next = first; next < count && point[next].group == point[first].group &&
                       point[next].rpm == point[first].rpm;
         next++) {
      sum += point[next].y.value;
      square += point[next].y.half * point[next].y.half;
    }
    struct point *m = &mean[means++];
    *m = point[first];
    m->runs = next - first;
    m->y.value = sum / m->runs;
    m->y.half = sqrt(square) / m->runs;
  }
  return means;
}

/* ---------------------------------------------------------------- the answer */

/* Between two runs, ln y is linear in ln rpm. */
static void between(struct answer *answer, const struct point *a, const struct point *b,
                    double target, double target_half) {
  const double dx = log(b->rpm / a->rpm), dy = log(b->y.value / a->y.value);
  const double s = log(target / a->y.value) / dy;
  if (!(s >= 0.0 && s <= 1.0)) return;
  const double rpm = a->rpm * exp(s * dx);
  if (isfinite(answer->rpm)) {
    answer->several =
        answer->several || rpm > answer->rpm * (1.0 + 1e-9); /* not at the run between */
    return;
  }
  const double at_a = (1.0 - s) * a->y.half / a->y.value, at_b = s * b->y.half / b->y.value;
  const double half = sqrt(at_a * at_a + at_b * at_b + pow(target_half / target, 2.0));
  answer->rpm = rpm;
  answer->half = answer->rpm * half * fabs(dx / dy);
}

/* Points of a group are sorted by speed. The reference itself answers for its own group. */
static struct answer solve(const struct point *point, int count, int group, double target,
                           double target_half) {
  struct answer answer = {NAN, NAN, INFINITY, -INFINITY, 0, false};
  const struct point *before = NULL;
  for (int k = 0; k < count; k++) {
    if (point[k].group != group) continue;
    answer.low = fmin(answer.low, point[k].rpm);
    answer.high = fmax(answer.high, point[k].rpm);
    answer.runs += point[k].runs;
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

static const char *words_of(int kind) {
  const char *words = em_figures_words((enum em_figures_kind)kind);
  return words + strspn(words, " ");
}

static const struct point *first_of(const struct point *point, int count, int group) {
  for (int k = 0; k < count; k++)
    if (point[k].group == group) return &point[k];
  return NULL;
}

static void describe_group(char *text, size_t size, const struct point *p) {
  const struct em_chamber *c = &p->chamber;
  const int used = snprintf(text, size, "%s, ", p->balls);
  if (c->shape == EM_SHAPE_DRUM)
    snprintf(text + used, size - (size_t)used, "drum %g mm", 1e3 * c->diameter);
  else
    snprintf(text + used, size - (size_t)used, "box %g × %g × %g mm", 1e3 * c->size.x,
             1e3 * c->size.y, 1e3 * c->size.z);
}

/* With a run of the group, where another group has the same name. */
static void group_name(char *text, size_t size, const struct point *point, int count, int groups,
                       int group) {
  char other[NAME];
  const struct point *p = first_of(point, count, group);
  describe_group(text, size, p);
  for (int g = 0; g < groups; g++) {
    describe_group(other, sizeof other, first_of(point, count, g));
    if (g == group || strcmp(other, text) != 0) continue;
    const size_t used = strlen(text);
    snprintf(text + used, size - used, ", as %s", p->label);
    return;
  }
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
                  const struct point *reference, double target, double target_half, bool own) {
  columns(report);
  for (int g = 0; g < groups; g++) {
    const struct point *p = first_of(point, count, g);
    const bool itself = own && g == reference->group;
    const struct answer a = solve(point, count, g, target, target_half);
    const struct em_interval speed = {itself ? reference->rpm : a.rpm, itself ? 0.0 : a.half, NAN,
                                      0, 1};
    const double rule = rule_of_thumb(reference, p);
    char name[NAME];
    group_name(name, sizeof name, point, count, groups, g);
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
    if (a.several && !itself)
      em_report_note(report, "%s: the value is reached at more than one speed; the lowest is told.",
                     name);
  }
}

/* Each run with its window, which is that of whole blocks where collisions come from histograms. */
static void run_table(struct em_report *report, const struct point *point, int count, int kind) {
  em_report_begin(report, "runs", NULL);
  em_report_column(report, "run", "run", "");
  em_report_column(report, "rpm", "speed", "rpm");
  em_report_column(report, "from", "from", "s");
  em_report_column(report, "to", "to", "s");
  em_report_column(report, "value", "figure", em_figures_unit((enum em_figures_kind)kind));
  for (int k = 0; k < count; k++) {
    em_report_text(report, "%s", point[k].label);
    em_report_number(report, point[k].rpm);
    em_report_number(report, point[k].from);
    em_report_number(report, point[k].to);
    em_report_interval(report, &point[k].y);
    if (point[k].end != EM_END_DONE)
      em_report_note(report, "%s is not done: %s at %g s.", point[k].label,
                     em_run_file_end_name(point[k].end), point[k].time);
  }
}

static enum em_status draw(const struct point *point, int count, int groups, int kind,
                           double target, const char *path, struct em_error *err) {
  double *cell = malloc(3 * (size_t)count * sizeof *cell);
  if (!cell) return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  struct em_plot_series series[2 * MOST_GROUPS];
  char name[MOST_GROUPS][NAME], label[128];
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
    group_name(name[g], sizeof name[g], point, count, groups, g);
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
  snprintf(label, sizeof label, "%s  [%s]", words_of(kind),
           em_figures_unit((enum em_figures_kind)kind));
  const struct em_plot_mark mark = {target, true, "to be reached"};
  const struct em_plot plot = {.title = "Which speed gives the same impacts?",
                               .x_label = "speed of the rotor  [rpm]",
                               .y_label = label,
                               .series_count = used,
                               .series = series,
                               .mark_count = 1,
                               .mark = &mark};
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

/* Reads the runs, each once; *count: how many there are. */
static enum em_status read_points(struct point *point, int *count,
                                  const struct em_millpost_options *o, int kind,
                                  struct em_error *err) {
  *count = 0;
  for (int k = 0; k < o->run_count; k++) {
    bool seen = false;
    for (int j = 0; j < k; j++)
      seen = seen || strcmp(o->run[j], o->run[k]) == 0;
    if (seen) continue;
    const enum em_status status = read_point(&point[(*count)++], o->run[k], o, kind, err);
    if (status != EM_OK) return status;
  }
  return EM_OK;
}

/* point, mean: room for as many as there are runs. */
static int run_with(struct point *point, struct point *mean, const struct em_millpost_options *o,
                    int kind) {
  struct em_error err = {.code = EM_OK};
  int runs;
  enum em_status status = read_points(point, &runs, o, kind, &err);
  if (status != EM_OK) return em_millpost_fail(&err);
  assert(runs > 0);
  const int groups = sort_into_groups(point, runs);
  const double rpm = point[0].rpm;
  qsort(point, (size_t)runs, sizeof *point, by_speed);
  const int count = average(mean, point, runs);
  const struct point *reference = mean; /* in the first group */
  while (reference->rpm != rpm)
    reference++;
  const bool own = isnan(o->target);
  const double target = own ? reference->y.value : o->target;
  struct em_report *report = em_report_new("scale");
  em_report_fact_text(report, "match", "held fixed", "%s", words_of(kind));
  em_report_fact_text(report, "reference", "reference", "%s, %g rpm%s", o->run[0], rpm,
                      reference->runs > 1 ? ", mean of the runs at this speed" : "");
  em_report_fact(report, "target", "to be reached", target,
                 em_figures_unit((enum em_figures_kind)kind));
  table(report, mean, count, groups, reference, target, own ? reference->y.half : 0.0, own);
  run_table(report, point, runs, kind);
  if (o->out) status = draw(mean, count, groups, kind, target, o->out, &err);
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
  const size_t runs = (size_t)o.run_count;
  struct point *point = calloc(2 * runs, sizeof *point);
  if (!point) {
    const struct em_error err = {.code = EM_MEMORY};
    return em_millpost_fail(&err);
  }
  const int result = run_with(point, point + runs, &o, kind);
  for (size_t k = 0; k < runs; k++)
    free(point[k].kind);
  free(point);
  return result;
}
