/* Numbers along logarithmic axes. */
#ifndef EM_DRAW_PLOT_TICKS_H
#define EM_DRAW_PLOT_TICKS_H

#include "draw/gnuplot.h"

/* Makes an axis ("x", "y", "cb") with these ends (> 0) logarithmic, with at least three numbers
 * along it: powers of ten; over less than three decades 1, 2, 5, 10, …; over less than a third of
 * one, round numbers at even distances. */
void em_plot_ticks_log(struct em_gnuplot *script, const char *axis, double low, double high);

#endif
