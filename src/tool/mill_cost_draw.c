/* Pictures of mill cost. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "eventmill/plot.h"
#include "tool/mill_cost.h"

enum picture { ACCURACY, EFFECTS, RECORDING, STATISTICS };
static const char *const pictures[EM_COST_PICTURES] = {"accuracy", "effects", "recording",
                                                       "statistics"};

void em_mill_cost_draw_path(const char *prefix, unsigned picture, char path[EM_COST_PICTURE_PATH]) {
  snprintf(path, EM_COST_PICTURE_PATH, "%s-%s.png", prefix, pictures[picture]);
}

static enum em_status draw(const struct em_cost *cost, struct em_plot *plot, const char *prefix,
                           enum picture picture, struct em_error *err) {
  char path[EM_COST_PICTURE_PATH], subtitle[256];
  em_mill_cost_draw_path(prefix, picture, path);
  em_plot_subtitle(cost->scene, subtitle, sizeof subtitle);
  plot->subtitle = subtitle;
  const enum em_status status = em_plot_draw(plot, path, err);
  plot->subtitle = NULL;
  return status;
}

/* A picture that has nothing to show is not drawn. */
static enum em_status leave_out(const char *prefix, enum picture picture, const char *why) {
  char path[EM_COST_PICTURE_PATH];
  em_mill_cost_draw_path(prefix, picture, path);
  fprintf(stderr, "%s: not drawn, %s\n", path, why);
  return EM_OK;
}

/* Variants whose names begin with the same word are a family: one colour. */
static bool is_family(const char *a, const char *b) {
  const size_t n = strcspn(a, " ");
  return n == strcspn(b, " ") && strncmp(a, b, n) == 0;
}

/* Where errors of 0 lie, on the axis of logarithms. */
static const double LOWEST = 1e-22;

/* The points of the diagram, family after family. */
struct cloud {
  size_t count, families;
  double x[EM_COST_VARIANTS], y[EM_COST_VARIANTS];
  char text[EM_COST_VARIANTS][96];
  const char *texts[EM_COST_VARIANTS];
  struct em_plot_series series[EM_COST_VARIANTS];
};

/* Adds ", misses 2e6": so many in 1e9 flights. */
static void add_count(char *text, size_t size, const char *what, uint64_t n, uint64_t flights) {
  char number[16];
  int digit = 0, power = 0;
  if (n == 0) return;
  snprintf(number, sizeof number, "%.0e", 1e9 * (double)n / (double)flights);
  sscanf(number, "%de%d", &digit, &power);
  const size_t used = strlen(text);
  snprintf(text + used, size - used, ", %s %de%d", what, digit, power);
}

/* Its name, whether it has no error at all, and whether it loses or invents contacts. */
static void describe(char *text, size_t size, const struct em_cost_result *r) {
  const struct em_cost_flights *f = &r->flights;
  snprintf(text, size, f->rms > 0.0 ? "%s" : "%s: error 0", r->variant.name);
  add_count(text, size, "misses", f->missed, f->flights);
  add_count(text, size, "invents", f->invented, f->flights);
}

static void gather_points(struct cloud *c, const struct em_cost *cost) {
  const char *before = "";
  for (size_t k = 0; k < cost->count; k++) {
    const struct em_cost_result *r = &cost->result[k];
    const size_t n = c->count;
    if (r->variant.group != EM_COST_ACCURACY || !r->measured || r->failed || !r->flights.contacts)
      continue;
    if (!isfinite(r->flights.rms)) continue;
    c->x[n] = r->time;
    c->y[n] = fmax(r->flights.rms, LOWEST);
    describe(c->text[n], sizeof c->text[n], r);
    c->texts[n] = c->text[n];
    if (!is_family(before, r->variant.name)) {
      c->series[c->families++] = (struct em_plot_series){
          .style = EM_PLOT_POINTS, .x = &c->x[n], .y = &c->y[n], .text = &c->texts[n]};
      before = r->variant.name;
    }
    c->series[c->families - 1].count++;
    c->count++;
  }
}

static enum em_status draw_accuracy(const struct em_cost *cost, const char *prefix,
                                    struct em_error *err) {
  struct cloud c = {0};
  gather_points(&c, cost);
  if (c.count == 0) return leave_out(prefix, ACCURACY, "no contact with drum or blades was judged");
  double low = 1.0, high = 1.0;
  for (size_t k = 0; k < c.count; k++) {
    low = fmin(low, c.x[k]);
    high = fmax(high, c.x[k]);
  }
  struct em_plot plot = {.title = "Accuracy against time",
                         .x_label =
                             "computing time, the scene as it is = 1; misses, invents: per 1e9 "
                             "flights",
                         .y_label = "error of contact times, rms  [s]",
                         .log_x = true,
                         .log_y = true,
                         .x_low = 0.8 * low,
                         .x_high = 2.5 * high, /* room for the last name */
                         .y_low = 0.1 * LOWEST,
                         .y_high = 0.1,
                         .series_count = c.families,
                         .series = c.series};
  return draw(cost, &plot, prefix, ACCURACY, err);
}

/* The variants of one table, each with the range of its turns. */
struct bars {
  size_t count;
  const char *name[EM_COST_VARIANTS];
  double value[EM_COST_VARIANTS], low[EM_COST_VARIANTS], high[EM_COST_VARIANTS];
};

static void gather_bars(struct bars *b, const struct em_cost *cost, enum em_cost_group group) {
  for (size_t k = 0; k < cost->count; k++) {
    const struct em_cost_result *r = &cost->result[k];
    if (r->variant.group != group || !r->measured || r->failed || !isfinite(r->time)) continue;
    b->name[b->count] = r->variant.name;
    b->value[b->count] = r->time;
    b->low[b->count] = r->time_low;
    b->high[b->count++] = r->time_high;
  }
}

static enum em_status draw_bars(const struct em_cost *cost, const char *prefix,
                                enum picture picture, enum em_cost_group group, const char *title,
                                const char *x_label, struct em_error *err) {
  struct bars b = {0};
  char path[EM_COST_PICTURE_PATH], subtitle[256];
  gather_bars(&b, cost, group);
  if (b.count == 0) return leave_out(prefix, picture, "none of its variants is measured");
  em_mill_cost_draw_path(prefix, picture, path);
  em_plot_subtitle(cost->scene, subtitle, sizeof subtitle);
  const struct em_plot_bars bars = {.title = title,
                                    .subtitle = subtitle,
                                    .x_label = x_label,
                                    .base = 1.0,
                                    .count = b.count,
                                    .name = b.name,
                                    .value = b.value,
                                    .low = b.low,
                                    .high = b.high,
                                    .range_name = "turns, one by one"};
  return em_plot_bars(&bars, path, err);
}

static enum em_status draw_statistics(const struct em_cost *cost, const char *prefix,
                                      struct em_error *err) {
  enum { POINTS = 24 };
  struct em_plot_series series[EM_PRECISION_COUNT];
  double x[POINTS], y[EM_PRECISION_COUNT][POINTS];
  const size_t all = em_precision_blocks(cost->precision);
  size_t n = 0, used = 0, before = 0;
  for (int k = 0; k < POINTS; k++) {
    const size_t blocks =
        (size_t)llround((double)all * pow(16.0, ((double)k - (POINTS - 1)) / (POINTS - 1)));
    if (blocks < 4 || blocks == before) continue;
    before = blocks;
    x[n] = em_precision_time(cost->precision, blocks);
    for (int j = 0; j < EM_PRECISION_COUNT; j++) {
      const struct em_interval f =
          em_precision_figure(cost->precision, blocks, (enum em_precision_kind)j, 3.0, 0.95);
      y[j][n] = 100.0 * em_mill_cost_width(&f);
      if (!(y[j][n] > 0.0) || !isfinite(y[j][n])) y[j][n] = NAN;
    }
    n++;
  }
  for (int j = 0; j < EM_PRECISION_COUNT; j++) {
    if (!(em_mill_cost_width(&cost->figure[j]) > 0.0)) continue;
    series[used++] = (struct em_plot_series){.name = em_precision_words((enum em_precision_kind)j),
                                             .style = EM_PLOT_LINE,
                                             .count = n,
                                             .x = x,
                                             .y = y[j]};
  }
  struct em_plot plot = {.title = "Statistics against time",
                         .x_label = "simulated time  [s]",
                         .y_label = "half width of the confidence interval  [%]",
                         .log_x = true,
                         .log_y = true,
                         .series_count = used,
                         .series = series};
  if (used == 0 || n < 2) return leave_out(prefix, STATISTICS, "no figure varies");
  return draw(cost, &plot, prefix, STATISTICS, err);
}

enum em_status em_mill_cost_draw(const struct em_cost *cost, const char *prefix,
                                 struct em_error *err) {
  enum em_status status = draw_accuracy(cost, prefix, err);
  if (!status)
    status = draw_bars(cost, prefix, EFFECTS, EM_COST_EFFECT, "Effects against time",
                       "computing time, the scene as it is = 1", err);
  if (!status)
    status = draw_bars(cost, prefix, RECORDING, EM_COST_RECORDING, "Recording against time",
                       "computing time, a run that writes nothing but its end = 1", err);
  if (!status) status = draw_statistics(cost, prefix, err);
  return status;
}
