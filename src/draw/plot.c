/* Diagrams of curves: histograms, courses in time, fits. */
#include "eventmill/plot.h"

#include <math.h>

#include "draw/gnuplot.h"
#include "draw/plot_key.h"
#include "draw/plot_marks.h"
#include "draw/plot_room.h"
#include "draw/plot_texts.h"
#include "draw/plot_ticks.h"
#include "eventmill/colour.h"
#include "num/locale.h"

/* Curves are told apart by so many colours, then by dashes and shapes of points. */
static const char *const dash[] = {"", " dt (16,5)", " dt (4,4)", " dt (16,4,3,4)"};
static const int shape[] = {7, 5, 9, 13};
enum { COLOURS = 8, MOST_CURVES = COLOURS * (int)(sizeof shape / sizeof *shape) };

/* The number of series k among the colours. */
static unsigned number_of(const struct em_plot *plot, size_t k) {
  unsigned next = 0;
  for (size_t j = 0; j < k; j++)
    if (plot->series[j].colour == 0) next++;
  const int own = plot->series[k].colour;
  return own > 0 ? (unsigned)own - 1U : next;
}

const uint8_t *em_plot_colour(const struct em_plot *plot, size_t k) {
  return em_colour_cycle(number_of(plot, k));
}

/* What filled curves stand on: 0, or on a logarithmic axis a value below all others. */
static double floor_of(const struct em_plot *plot) {
  if (!plot->log_y) return 0.0;
  if (plot->y_low > 0.0) return plot->y_low;
  double least = INFINITY;
  for (size_t j = 0; j < plot->series_count; j++)
    for (size_t k = 0; k < plot->series[j].count; k++)
      if (plot->series[j].y[k] > 0.0) least = fmin(least, plot->series[j].y[k]);
  return isfinite(least) ? pow(10.0, floor(log10(least))) : 1.0;
}

/* A histogram's outline as a polygon. */
static void write_steps(FILE *out, const struct em_plot_series *s, double ground) {
  if (s->count == 0) return;
  fprintf(out, "%.9g %.9g\n", s->x[0], ground);
  for (size_t k = 0; k < s->count; k++) {
    const double y = s->y[k] > ground || !isfinite(s->y[k]) ? s->y[k] : ground;
    const double height = isfinite(y) ? y : ground;
    fprintf(out, "%.9g %.9g\n%.9g %.9g\n", s->x[k], height, s->x[k + 1], height);
  }
  fprintf(out, "%.9g %.9g\n", s->x[s->count], ground);
}

static void write_data(FILE *out, const struct em_plot *plot, size_t k, double ground) {
  const struct em_plot_series *s = &plot->series[k];
  fprintf(out, "$d%zu << EOD\n", k);
  if (s->style == EM_PLOT_STEPS) {
    write_steps(out, s, ground);
  } else {
    for (size_t j = 0; j < s->count; j++) {
      if (!isfinite(s->y[j]) || !isfinite(s->x[j]))
        fputc('\n', out);
      else
        fprintf(out, "%.9g %.9g %.9g\n", s->x[j], s->y[j], s->error != NULL ? s->error[j] : 0.0);
    }
  }
  fputs("EOD\n", out);
}

static void write_axis(struct em_gnuplot *g, const char *axis, const char *label, bool log,
                       double low, double high) {
  if (label != NULL) {
    fprintf(g->out, "set %slabel ", axis);
    em_gnuplot_string(g, label);
    fputs(" noenhanced textcolor rgb '#2b2f36'\n", g->out);
  }
  if (log && low > 0.0 && low < high)
    em_plot_ticks_log(g, axis, low, high);
  else if (log)
    fprintf(g->out, "set logscale %s\nset format %s '10^{%%T}'\n", axis, axis);
  if (low < high) fprintf(g->out, "set %srange [%.9g:%.9g]\n", axis, low, high);
}

/* Error bars that reach below 0 do not take an axis there whose values do not. */
static bool is_positive(const struct em_plot *plot) {
  for (size_t j = 0; j < plot->series_count; j++)
    for (size_t k = 0; k < plot->series[j].count && !plot->series[j].second_axis; k++)
      if (plot->series[j].y[k] < 0.0) return false;
  return true;
}

static void write_frame(struct em_gnuplot *g, const struct em_plot *plot, double ground) {
  bool second = false;
  for (size_t k = 0; k < plot->series_count; k++)
    second |= plot->series[k].second_axis;
  em_gnuplot_title(g, plot->title, plot->subtitle);
  fprintf(g->out, "set tmargin at screen %.3f\n",
          plot->title == NULL && plot->subtitle == NULL ? 0.97 : EM_GNUPLOT_TOP);
  write_axis(g, "x", plot->x_label, plot->log_x, plot->x_low, plot->x_high);
  write_axis(g, "y", plot->y_label, plot->log_y, plot->y_low, plot->y_high);
  if (!plot->log_y && !(plot->y_low < plot->y_high) && is_positive(plot)) {
    /* What is cut off at 0 is not asked how far up it reaches. */
    const double most = em_plot_room_of(plot, ground).y[0].high;
    fputs("set yrange [0<*:", g->out);
    if (isfinite(most)) fprintf(g->out, "%.9g<", most);
    fputs("*]\n", g->out);
  }
  if (second) {
    write_axis(g, "y2", plot->y2_label, false, 0.0, 0.0);
    fputs("set border 11\nset y2tics\n", g->out);
  }
  if (plot->category_count > 0) {
    em_gnuplot_names(g, "x", plot->category, plot->category_count);
    fprintf(g->out, "set xrange [-0.6:%g]\n", (double)plot->category_count - 0.4);
  }
  em_plot_key(g, plot, ground);
  em_plot_marks(g, plot, ground);
  em_plot_texts(g, plot);
}

/* One or two layers: what is filled below what is drawn. */
static void write_curve(struct em_gnuplot *g, const struct em_plot *plot, size_t k, double ground) {
  const struct em_plot_series *s = &plot->series[k];
  const uint8_t *c = em_plot_colour(plot, k);
  const char *axes = s->second_axis ? "axes x1y2 " : "";
  const double solid = plot->series_count > 2 ? 0.07 : 0.18;
  const unsigned turn = number_of(plot, k) / COLOURS;
  char colour[24];
  snprintf(colour, sizeof colour, "lc rgb '#%02x%02x%02x'", c[0], c[1], c[2]);
  if (s->style == EM_PLOT_STEPS)
    fprintf(g->out,
            "$d%zu using 1:2 %swith filledcurves y=%.9g fs transparent solid %g noborder %s "
            "notitle, ",
            k, axes, ground, solid, colour);
  if (s->style == EM_PLOT_BAND && s->error != NULL)
    fprintf(g->out,
            "$d%zu using 1:($2-$3):($2+$3) %swith filledcurves fs transparent solid 0.20 noborder "
            "%s notitle, ",
            k, axes, colour);
  fprintf(g->out, "$d%zu using 1:2", k);
  if (s->style == EM_PLOT_POINTS && s->error != NULL)
    fprintf(g->out, ":3 %swith yerrorbars pt %d ps 0.8 lw 1.4 %s", axes, shape[turn], colour);
  else if (s->style == EM_PLOT_POINTS)
    fprintf(g->out, " %swith points pt %d ps 0.8 %s", axes, shape[turn], colour);
  else
    fprintf(g->out, " %swith lines lw %g %s%s", axes, s->style == EM_PLOT_STEPS ? 1.5 : 2.0, colour,
            s->style == EM_PLOT_DASHED ? " dt (12,6)" : dash[turn]);
  if (s->name == NULL) {
    fputs(" notitle", g->out);
  } else {
    fputs(" title ", g->out);
    em_gnuplot_string(g, s->name);
  }
}

/* Is there a point that can be drawn? */
static bool has_points(const struct em_plot *plot) {
  for (size_t j = 0; j < plot->series_count; j++) {
    const struct em_plot_series *s = &plot->series[j];
    for (size_t k = 0; k < s->count; k++)
      if (isfinite(s->x[k]) && isfinite(s->y[k]) && (!plot->log_x || s->x[k] > 0.0) &&
          (!plot->log_y || s->y[k] > 0.0))
        return true;
  }
  return false;
}

enum em_status em_plot_draw(const struct em_plot *plot, const char *path, struct em_error *err) {
  EM_LOCALE_PLAIN;
  struct em_gnuplot g;
  if (!has_points(plot)) return em_error_set(err, EM_INPUT, path, 0, "there is nothing to draw");
  for (size_t k = 0; k < plot->series_count; k++)
    if (number_of(plot, k) >= MOST_CURVES)
      return em_error_set(err, EM_INPUT, path, 0,
                          "too many curves for one diagram: at most %d can be told apart",
                          MOST_CURVES);
  const enum em_status status = em_gnuplot_begin(&g, path, plot->width > 0 ? plot->width : 1200,
                                                 plot->height > 0 ? plot->height : 750, err);
  if (status != EM_OK) return status;
  const double ground = floor_of(plot);
  for (size_t k = 0; k < plot->series_count; k++)
    write_data(g.out, plot, k, ground);
  write_frame(&g, plot, ground);
  fputs("plot ", g.out);
  for (size_t k = 0; k < plot->series_count; k++) {
    if (k > 0) fputs(", ", g.out);
    write_curve(&g, plot, k, ground);
  }
  fputc('\n', g.out);
  return em_gnuplot_end(&g, path, err);
}
