/* Diagrams in one house style, drawn by gnuplot: curves and histograms, bars, maps of cells.
 *
 * The ending of the path says what is written: .png, .svg, .pdf, or .gp for the gnuplot script with
 * its data, to be changed by hand. A file appears complete or not at all. */
#ifndef EVENTMILL_PLOT_H
#define EVENTMILL_PLOT_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/error.h"
#include "eventmill/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

enum em_plot_style {
  EM_PLOT_LINE,   /* x, y joined by a line */
  EM_PLOT_DASHED, /* the same, dashed: theory, limits */
  EM_PLOT_POINTS, /* x, y as dots; with `error`, as bars y ± error */
  EM_PLOT_BAND,   /* y ± error as a faint band around a line */
  EM_PLOT_STEPS   /* histogram: x holds count + 1 edges of bins, y the count heights of the bins */
};

/* One curve. Points whose y is NaN leave a gap. Arrays stay the caller's. */
struct em_plot_series {
  const char *name; /* in the legend; NULL: not there */
  enum em_plot_style style;
  size_t count;
  const double *x, *y;
  const double *error;     /* half length of the error bar or band; NULL: none */
  int colour;              /* 1, 2, …: a colour of the house's cycle; 0: the next one */
  bool second_axis;        /* y belongs to the right axis */
  const char *const *text; /* for POINTS within given ranges: written beside each, where no other
                              text or point is; NULL: nothing */
};

/* A line across the diagram, at a threshold or a quartile. */
struct em_plot_mark {
  double at;
  bool horizontal;
  const char *name; /* written beside it; NULL: none */
};

/* A diagram of up to 32 curves; zero is the default of everything. Labels carry their units: "v_n
 * [m/s]". Texts are UTF-8 and taken literally. */
struct em_plot {
  const char *title;    /* what is shown */
  const char *subtitle; /* scene and operating point: see em_plot_subtitle */
  const char *x_label, *y_label, *y2_label;
  bool log_x, log_y;
  double x_low, x_high; /* range; both 0: from the data */
  double y_low, y_high;
  size_t series_count;
  const struct em_plot_series *series;
  size_t mark_count;
  const struct em_plot_mark *mark;
  const char *const *category; /* names at x = 0, 1, …; NULL: numbers */
  size_t category_count;
  int width, height; /* pixels; 0: 1200 × 750 */
};

/* Lying bars from a base to the figures of named things, from the top down, each figure written at
 * its bar's end. Where figures differ much, their axis is logarithmic. Those that are NaN are not
 * drawn. */
struct em_plot_bars {
  const char *title, *subtitle;
  const char *x_label;
  double base;
  size_t count;
  const char *const *name;
  const double *value;
  const double *low, *high; /* a range, drawn on the bar */
  const char *range_name;   /* in the legend; NULL: not there */
};

/* One cell of a map: a rectangle [low, high] of the plane, or, in a polar map, the part of a ring
 * between the radii low[0], high[0] and the angles low[1] < high[1] (rad, from the first axis
 * towards the second). */
struct em_plot_cell {
  double low[2], high[2];
  double value; /* NaN: left blank */
};

struct em_plot_map {
  const char *title, *subtitle;
  const char *x_label, *y_label;
  const char *value_label; /* beside the colour bar */
  size_t cell_count;
  const struct em_plot_cell *cell;
  bool polar;
  bool equal;        /* one metre is as long along x as along y; always so for polar maps */
  bool log_value;    /* values ≤ 0 are left blank */
  bool diverging;    /* blue – white – red about 0, for differences */
  double low, high;  /* range of colours; both 0: from the data; where values go beyond it, the end
                        of the colour bar is pointed */
  int width, height; /* pixels; 0: 1000 × 900 */
};

/* Draws a diagram. Errors: EM_INPUT (nothing to draw, unknown ending), EM_FILE (cannot be written),
 * EM_PICTURE (gnuplot is missing or failed; its message is in err). */
enum em_status em_plot_draw(const struct em_plot *plot, const char *path, struct em_error *err);

/* Draws bars; errors as above. */
enum em_status em_plot_bars(const struct em_plot_bars *bars, const char *path,
                            struct em_error *err);

/* Draws a map; errors as above. */
enum em_status em_plot_map(const struct em_plot_map *map, const char *path, struct em_error *err);

/* Writes scene and operating point ("Simoloyer, 2 litres · 1300 rpm · 3500 balls of 5 mm") into
 * text; those of several scenes ("Simoloyer, 2 litres · 1300 rpm / 1700 rpm · 3500 balls of 5 mm");
 * or the operating point alone. Cut to size bytes. Long titles are shortened. */
void em_plot_subtitle(const struct em_scene *scene, char *text, size_t size);
void em_plot_subtitles(const struct em_scene *const *scene, size_t count, char *text, size_t size);
void em_plot_operating_point(const struct em_scene *scene, char *text, size_t size);

#ifdef __cplusplus
}
#endif

#endif
