/* Lying bars: figures of named things against a base, with their values written at their ends. */
#include <math.h>

#include "draw/gnuplot.h"
#include "draw/plot_ticks.h"
#include "eventmill/colour.h"
#include "eventmill/plot.h"
#include "num/locale.h"

/* Beyond this ratio of the largest to the smallest figure the axis is logarithmic: short bars
 * stay visible beside long ones. */
static const double WIDE = 3.0;
/* Room beside the bars for their values, and the least width of the axis. */
static const double ROOM = 0.14, LEAST = 0.05;

/* Fewer bars do not fill the height. */
enum { ROWS = 6 };

struct axis {
  double low, high;
  bool log;
};

static bool is_drawn(const struct em_plot_bars *bars, size_t k) {
  return isfinite(bars->value[k]) && isfinite(bars->low[k]) && isfinite(bars->high[k]);
}

static struct axis axis_of(const struct em_plot_bars *bars) {
  struct axis a = {bars->base, bars->base, false};
  for (size_t k = 0; k < bars->count; k++) {
    if (!is_drawn(bars, k)) continue;
    a.low = fmin(a.low, fmin(bars->value[k], bars->low[k]));
    a.high = fmax(a.high, fmax(bars->value[k], bars->high[k]));
  }
  a.log = a.low > 0.0 && a.high > WIDE * a.low;
  if (a.log) {
    const double room = pow(a.high / a.low, ROOM);
    a.low /= room;
    a.high *= room;
  } else {
    const double room = ROOM * fmax(a.high - a.low, LEAST);
    a.low -= room;
    a.high += room;
  }
  return a;
}

static void write_axis(struct em_gnuplot *g, const struct em_plot_bars *bars,
                       const struct axis *a) {
  fprintf(g->out, "set xrange [%.9g:%.9g]\nset xlabel ", a->low, a->high);
  em_gnuplot_string(g, bars->x_label);
  fputs(" noenhanced textcolor rgb '#2b2f36'\n", g->out);
  if (a->log) em_plot_ticks_log(g, "x", a->low, a->high);
}

/* Beyond the bar and its range, on the side to which it points. */
static void write_values(struct em_gnuplot *g, const struct em_plot_bars *bars) {
  for (size_t k = 0; k < bars->count; k++) {
    if (!is_drawn(bars, k)) continue;
    const double value = bars->value[k];
    const bool more = value >= bars->base;
    const double at = more ? fmax(value, bars->high[k]) : fmin(value, bars->low[k]);
    const bool plain = value == 0.0 || (fabs(value) >= 0.095 && fabs(value) < 9.995);
    fprintf(g->out, plain ? "set label '%.2f'" : "set label '%.3g'", value);
    fprintf(g->out, " at first %.9g, first %zu %s offset %g,0 font ',12' textcolor rgb '#2b2f36'\n",
            at, k, more ? "left" : "right", more ? 0.8 : -0.8);
  }
}

static void write_bars(struct em_gnuplot *g, const struct em_plot_bars *bars) {
  enum { LESS = 2, MORE = 1, DARK = 7 }; /* colours of the cycle */
  fputs("$d << EOD\n", g->out);
  for (size_t k = 0; k < bars->count; k++) {
    const double value = bars->value[k];
    const uint8_t *c = em_colour_cycle(value < bars->base ? LESS : MORE);
    if (is_drawn(bars, k))
      fprintf(g->out, "%zu %.9g %.9g %.9g %.9g %d\n", k, fmin(value, bars->base),
              fmax(value, bars->base), bars->low[k], bars->high[k], c[0] << 16 | c[1] << 8 | c[2]);
  }
  fputs("EOD\n", g->out);
  const uint8_t *dark = em_colour_cycle(DARK);
  fprintf(g->out,
          "plot $d using 2:1:2:3:($1-0.32):($1+0.32):6 with boxxyerror fs solid 0.85 noborder lc "
          "rgb variable notitle, $d using (0.5*($4+$5)):1:4:5 with xerrorbars pt 7 ps 0 lw 1.4 lc "
          "rgb '#%02x%02x%02x' ",
          dark[0], dark[1], dark[2]);
  fputs(bars->range_name ? "title " : "notitle", g->out);
  if (bars->range_name) em_gnuplot_string(g, bars->range_name);
  fputc('\n', g->out);
}

enum em_status em_plot_bars(const struct em_plot_bars *bars, const char *path,
                            struct em_error *err) {
  EM_LOCALE_PLAIN;
  size_t drawn = 0;
  for (size_t k = 0; k < bars->count; k++)
    drawn += is_drawn(bars, k);
  if (drawn == 0) return em_error_set(err, EM_INPUT, path, 0, "there is nothing to draw");
  struct em_gnuplot g;
  const enum em_status status = em_gnuplot_begin(&g, path, 1200, 750, err);
  if (status != EM_OK) return status;
  const struct axis a = axis_of(bars);
  em_gnuplot_title(&g, bars->title, bars->subtitle);
  fprintf(g.out, "set tmargin at screen %g\nset rmargin 4\nset key at screen 0.97, screen 0.925\n",
          EM_GNUPLOT_TOP);
  write_axis(&g, bars, &a);
  em_gnuplot_names(&g, "y", bars->name, bars->count);
  fprintf(g.out, "set yrange [%g:-0.6]\nset grid noytics\n", fmax((double)bars->count, ROWS) - 0.4);
  write_values(&g, bars);
  fprintf(g.out,
          "set arrow from first %.9g, graph 0 to first %.9g, graph 1 nohead lw 1.4 lc rgb "
          "'#5b606b' front\n",
          bars->base, bars->base);
  write_bars(&g, bars);
  return em_gnuplot_end(&g, path, err);
}
