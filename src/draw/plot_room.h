/* What is free in a diagram of curves, in shares of its area: 0, 0 is the lower left corner. The
 * ends of axes are gnuplot's and known only about. */
#ifndef EM_DRAW_PLOT_ROOM_H
#define EM_DRAW_PLOT_ROOM_H

#include <stdbool.h>

#include "eventmill/plot.h"

/* The values at the ends of an axis. */
struct em_plot_range {
  double low, high;
  bool log;
};

struct em_plot_room {
  const struct em_plot *plot;
  double ground;                /* what filled curves stand on */
  struct em_plot_range x, y[2]; /* y: left and right */
  double width, height;         /* of the area, about, in pixels */
};

struct em_plot_box {
  double left, right, low, high;
};

struct em_plot_room em_plot_room_of(const struct em_plot *plot, double ground);

/* Where a value is along an axis. */
double em_plot_room_share(const struct em_plot_range *range, double value);

/* Is there no curve in the box, and no line across the diagram, where `marks` are asked for? */
bool em_plot_room_is_free(const struct em_plot_room *room, const struct em_plot_box *box,
                          bool marks);

/* Letters of a text in UTF-8. */
double em_plot_room_letters(const char *text);

#endif
