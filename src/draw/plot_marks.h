/* Lines across a diagram. */
#ifndef EM_DRAW_PLOT_MARKS_H
#define EM_DRAW_PLOT_MARKS_H

#include "draw/gnuplot.h"
#include "eventmill/plot.h"

/* Draws the marks of a diagram, with their names beside them: at the end and on the side where
 * there is no curve, or else with a ground of their own. `ground`: what filled curves stand on. */
void em_plot_marks(struct em_gnuplot *script, const struct em_plot *plot, double ground);

#endif
