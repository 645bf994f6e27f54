/* Pictures of mill cost. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "eventmill/plot.h"
#include "tool/mill_cost.h"

static enum em_status draw(const struct em_cost *cost, struct em_plot *plot, const char *prefix,
                           const char *what, struct em_error *err) {
  char path[EM_SCENE_PATH + 32], subtitle[256];
  snprintf(path, sizeof path, "%s-%s.png", prefix, what);
  em_plot_subtitle(cost->scene, subtitle, sizeof subtitle);
  plot->subtitle = subtitle;
  const enum em_status status = em_plot_draw(plot, path, err);
  plot->subtitle = NULL;
  return status;
}

/* Variants whose names begin with the same word are a family: one colour. */
static bool is_family(const char *a, const char *b) {
  const size_t n = strcspn(a, " ");
  return n == strcspn(b, " ") && strncmp(a, b, n) == 0;
}

/* Where errors of 0 lie. */
static const double LOWEST = 1e-22;

/* The points of the diagram, family after family. */
struct cloud {
  size_t count, families;
  double x[EM_COST_VARIANTS], y[EM_COST_VARIANTS];
  char text[EM_COST_VARIANTS][96];
  const char *texts[EM_COST_VARIANTS];
  int line[EM_COST_VARIANTS];
  struct em_plot_series series[EM_COST_VARIANTS];
};

/* Its name, and whether it loses or invents contacts. */
static void describe(char *text, size_t size, const struct em_cost_result *r) {
  const struct em_cost_flights *f = &r->flights;
  const double scale = 1e9 / (double)f->flights;
  int n = snprintf(text, size, "%s", r->variant.name);
  if (f->missed)
    n += snprintf(text + n, size - (size_t)n, ", misses %.0e", scale * (double)f->missed);
  if (f->invented)
    snprintf(text + n, size - (size_t)n, ", invents %.0e", scale * (double)f->invented);
}

/* Texts of points that lie close together go below them, one under the other. */
static void set_lines(struct cloud *c) {
  for (size_t n = 0; n < c->count; n++) {
    int before = 0, near = 0;
    for (size_t k = 0; k < c->count; k++) {
      if (fabs(log10(c->y[k] / c->y[n])) > 0.4 || fabs(log10(c->x[k] / c->x[n])) > 0.3) continue;
      near++;
      before += k < n;
    }
    c->line[n] = near > 1 ? 1 + before : 0;
  }
}

static void gather_points(struct cloud *c, const struct em_cost *cost) {
  const char *before = "";
  for (size_t k = 0; k < cost->count; k++) {
    const struct em_cost_result *r = &cost->result[k];
    const size_t n = c->count;
    if (r->variant.group != EM_COST_ACCURACY || r->failed || !r->flights.contacts) continue;
    if (!isfinite(r->flights.rms)) continue;
    c->x[n] = r->time;
    c->y[n] = fmax(r->flights.rms, LOWEST);
    describe(c->text[n], sizeof c->text[n], r);
    c->texts[n] = c->text[n];
    if (!is_family(before, r->variant.name)) {
      c->series[c->families++] = (struct em_plot_series){.style = EM_PLOT_POINTS,
                                                         .x = &c->x[n],
                                                         .y = &c->y[n],
                                                         .text = &c->texts[n],
                                                         .text_line = &c->line[n]};
      before = r->variant.name;
    }
    c->series[c->families - 1].count++;
    c->count++;
  }
  set_lines(c);
}

static enum em_status draw_accuracy(const struct em_cost *cost, const char *prefix,
                                    struct em_error *err) {
  struct cloud c = {0};
  gather_points(&c, cost);
  if (c.count == 0) return EM_OK;
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
                         .x_high = 2.0 * high, /* room for the last name */
                         .y_low = 0.1 * LOWEST,
                         .y_high = 0.1,
                         .series_count = c.families,
                         .series = c.series};
  return draw(cost, &plot, prefix, "accuracy", err);
}

/* Bars with numbers, whose names stand in the legend. */
static enum em_status draw_effects(const struct em_cost *cost, const char *prefix,
                                   struct em_error *err) {
  struct em_plot_series series[EM_COST_VARIANTS];
  double x[EM_COST_VARIANTS], y[EM_COST_VARIANTS];
  char label[EM_COST_VARIANTS][96], number[EM_COST_VARIANTS][8];
  const char *names[EM_COST_VARIANTS + 8];
  double low = 0.0, high = 0.0;
  size_t n = 0;
  for (size_t k = 0; k < cost->count; k++) {
    const struct em_cost_result *r = &cost->result[k];
    if (r->variant.group == EM_COST_ACCURACY || r->failed || !isfinite(r->time)) continue;
    x[n] = (double)n;
    y[n] = 100.0 * (r->time - 1.0);
    low = fmin(low, y[n]);
    high = fmax(high, y[n]);
    snprintf(number[n], sizeof number[n], "%zu", n + 1);
    snprintf(label[n], sizeof label[n], "%zu  %s", n + 1, r->variant.name);
    series[n] = (struct em_plot_series){
        .name = label[n], .style = EM_PLOT_BARS, .count = 1, .x = &x[n], .y = &y[n]};
    names[n] = number[n];
    n++;
  }
  struct em_plot plot = {.title = "Effects against time",
                         .y_label = "computing time against the scene as it is  [%]",
                         .y_low = 1.1 * low - 1.0, /* room for the legend above the bars */
                         .y_high = high + 1.2 * (high - low) + 5.0,
                         .series_count = n,
                         .series = series,
                         .category = names,
                         .category_count = n,
                         .width = 1400};
  return n ? draw(cost, &plot, prefix, "effects", err) : EM_OK;
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
    if (!(cost->figure[j].half > 0.0) || cost->figure[j].value == 0.0) continue;
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
  return used && n > 1 ? draw(cost, &plot, prefix, "statistics", err) : EM_OK;
}

enum em_status em_mill_cost_draw(const struct em_cost *cost, const char *prefix,
                                 struct em_error *err) {
  enum em_status status = draw_accuracy(cost, prefix, err);
  if (!status) status = draw_effects(cost, prefix, err);
  if (!status) status = draw_statistics(cost, prefix, err);
  return status;
}
