/* Where numbers stand along an axis. */
#ifndef EM_DRAW_PLOT_TICKS_H
#define EM_DRAW_PLOT_TICKS_H

#include "draw/gnuplot.h"

/* A step of 1, 2 or 5 times a power of ten, of which about `steps` make the range. */
double em_plot_ticks_step(double range, double steps);

/* Makes an axis ("x", "y", "cb") with these ends (> 0) logarithmic, with at least three numbers
 * along it: powers of ten; over less than three decades 1, 2, 5, 10, …; over less than a third of
 * one, round numbers at even distances. */
void em_plot_ticks_log(struct em_gnuplot *script, const char *axis, double low, double high);

#endif
