/* The legend of a diagram of curves. */
#ifndef EM_DRAW_PLOT_KEY_H
#define EM_DRAW_PLOT_KEY_H

#include "draw/gnuplot.h"
#include "eventmill/plot.h"

/* Puts the legend into the first corner (top right, top left, bottom right, bottom left) where it
 * lies on no curve; else beside the diagram, or below it where the names are long. Sets the right
 * margin. Nothing where no curve has a name. `ground`: what filled curves stand on. */
void em_plot_key(struct em_gnuplot *script, const struct em_plot *plot, double ground);

#endif
