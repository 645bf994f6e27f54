/* Maps: coloured cells, rectangles or parts of rings, drawn as patches of pm3d surfaces. */
#include <math.h>

#include "draw/gnuplot.h"
#include "draw/plot_ticks.h"
#include "eventmill/colour.h"
#include "eventmill/plot.h"
#include "num/locale.h"

/* Values that differ by less than this share are alike: their difference is rounding, and gnuplot
 * does not tell them apart. */
static const double ALIKE = 1e-6;

static bool is_shown(const struct em_plot_map *map, double value) {
  return isfinite(value) && (!map->log_value || value > 0.0);
}

/* The least and the largest value; false when no cell has one. */
static bool ends_of(const struct em_plot_map *map, double *low, double *high) {
  *low = INFINITY;
  *high = -INFINITY;
  for (size_t k = 0; k < map->cell_count; k++) {
    const double v = map->cell[k].value;
    if (!is_shown(map, v)) continue;
    *low = fmin(*low, v);
    *high = fmax(*high, v);
  }
  return *low <= *high;
}

/* The range of colours; false when no cell has a value. */
static bool range_of(const struct em_plot_map *map, double *low, double *high) {
  if (!ends_of(map, low, high)) return false;
  if (map->low < map->high) {
    *low = map->low;
    *high = map->high;
  }
  if (map->diverging) {
    *high = fmax(fabs(*low), fabs(*high));
    *low = -*high;
  }
  const double size = fmax(fabs(*low), fabs(*high));
  if (!(*high - *low > ALIKE * size)) {
    const double room = size > 0.0 ? 0.1 * size : 1.0;
    *low -= room;
    *high += room;
  }
  return true;
}

static void make_colours(const struct em_plot_map *map, struct em_colour_map *colours) {
  em_colour_make(map->diverging ? EM_COLOUR_BALANCE : EM_COLOUR_LAGOON, colours);
}

static void write_palette(FILE *out, const struct em_plot_map *map) {
  struct em_colour_map colours;
  make_colours(map, &colours);
  fputs("set palette maxcolors 0\nset palette defined (", out);
  for (int k = 0; k < EM_COLOUR_STEPS; k += 3) {
    const uint8_t *c = colours.rgb[k];
    fprintf(out, "%s%d '#%02x%02x%02x'", k > 0 ? ", " : "", k, c[0], c[1], c[2]);
  }
  fputs(")\n", out);
}

static void write_rectangle(FILE *out, const struct em_plot_cell *c) {
  for (int j = 0; j < 2; j++) {
    const double y = j ? c->high[1] : c->low[1];
    fprintf(out, "%.9g %.9g %.9g\n%.9g %.9g %.9g\n\n", c->low[0], y, c->value, c->high[0], y,
            c->value);
  }
  fputc('\n', out);
}

static void write_ring_part(FILE *out, const struct em_plot_cell *c) {
  const double arc = c->high[1] - c->low[1];
  const int steps = 1 + (int)(fabs(arc) / (2.0 * M_PI / 180.0));
  for (int k = 0; k <= steps; k++) {
    const double a = c->low[1] + arc * k / steps;
    fprintf(out, "%.9g %.9g %.9g\n%.9g %.9g %.9g\n\n", c->low[0] * cos(a), c->low[0] * sin(a),
            c->value, c->high[0] * cos(a), c->high[0] * sin(a), c->value);
  }
  fputc('\n', out);
}

static void write_cells(FILE *out, const struct em_plot_map *map) {
  fputs("$cells << EOD\n", out);
  for (size_t k = 0; k < map->cell_count; k++) {
    if (!is_shown(map, map->cell[k].value)) continue;
    if (map->polar)
      write_ring_part(out, &map->cell[k]);
    else
      write_rectangle(out, &map->cell[k]);
  }
  fputs("EOD\n", out);
}

static void write_ranges(FILE *out, const struct em_plot_map *map) {
  double x0 = INFINITY, x1 = -INFINITY, y0 = INFINITY, y1 = -INFINITY;
  for (size_t k = 0; k < map->cell_count; k++) {
    const struct em_plot_cell *c = &map->cell[k];
    x0 = fmin(x0, map->polar ? -c->high[0] : c->low[0]);
    x1 = fmax(x1, c->high[0]);
    y0 = fmin(y0, map->polar ? -c->high[0] : c->low[1]);
    y1 = fmax(y1, map->polar ? c->high[0] : c->high[1]);
  }
  fprintf(out, "set xrange [%.9g:%.9g] noextend\nset yrange [%.9g:%.9g] noextend\n", x0, x1, y0,
          y1);
}

static void write_label(struct em_gnuplot *g, const char *axis, const char *label,
                        const char *more) {
  if (label == NULL) return;
  fprintf(g->out, "set %slabel ", axis);
  em_gnuplot_string(g, label);
  fprintf(g->out, " noenhanced textcolor rgb '#2b2f36' %s\n", more);
}

/* The colour bar; it is pointed where values go beyond its end. */
static void write_bar(struct em_gnuplot *g, const struct em_plot_map *map, double low,
                      double high) {
  static const double left = 0.860, right = 0.882, bottom = 0.16, top = 0.80, tip = 0.018;
  double least, most;
  if (map->log_value) em_plot_ticks_log(g, "cb", low, high);
  fprintf(g->out,
          "set cbrange [%.9g:%.9g]\nset linetype 101 lw 1 lc rgb '#5b606b'\n"
          "set colorbox vertical user origin screen %g,%g size screen %g,%g border 101\n",
          low, high, left, bottom, right - left, top - bottom);
  ends_of(map, &least, &most);
  struct em_colour_map colours;
  make_colours(map, &colours);
  for (int up = 0; up < 2; up++) {
    const double slack = 1e-9 * (high - low);
    if (up ? most <= high + slack : least >= low - slack) continue;
    const double from = up ? top : bottom, to = up ? top + tip : bottom - tip;
    const uint8_t *c = colours.rgb[up ? EM_COLOUR_STEPS - 1 : 0];
    fprintf(g->out,
            "set object %d polygon from screen %g,%g to screen %g,%g to screen %g,%g to screen "
            "%g,%g fillstyle solid border lc rgb '#5b606b' fillcolor rgb '#%02x%02x%02x'\n",
            up + 1, left, from, right, from, 0.5 * (left + right), to, left, from, c[0], c[1],
            c[2]);
  }
}

enum em_status em_plot_map(const struct em_plot_map *map, const char *path, struct em_error *err) {
  EM_LOCALE_PLAIN;
  struct em_gnuplot g;
  double low, high;
  if (!range_of(map, &low, &high))
    return em_error_set(err, EM_INPUT, path, 0, "no cell of the map has a value to be drawn");
  const enum em_status status = em_gnuplot_begin(&g, path, map->width > 0 ? map->width : 1000,
                                                 map->height > 0 ? map->height : 900, err);
  if (status != EM_OK) return status;
  write_cells(g.out, map);
  write_palette(g.out, map);
  em_gnuplot_title(&g, map->title, map->subtitle);
  write_label(&g, "x", map->x_label, "");
  write_label(&g, "y", map->y_label, "");
  write_label(&g, "cb", map->value_label, "offset 0.5,0");
  write_ranges(g.out, map);
  write_bar(&g, map, low, high);
  fprintf(g.out, "set tmargin at screen %.3f\n", EM_GNUPLOT_TOP);
  if (map->polar || map->equal) fputs("set size ratio -1\n", g.out);
  fputs("unset grid\nunset key\nset view map\nset border 3\n"
        "set bmargin at screen 0.10\n"
        "set lmargin at screen 0.11\nset rmargin at screen 0.82\n"
        "set pm3d explicit corners2color c1\n"
        /* Values are colours alone: as heights, the lowest of a narrow range would be left out.
           Twice: the smoothed edges of neighbours let the ground through. */
        "splot $cells using 1:2:(0):3 with pm3d, $cells using 1:2:(0):3 with pm3d\n",
        g.out);
  return em_gnuplot_end(&g, path, err);
}
