/* Words beside the points of a diagram. */
#ifndef EM_DRAW_PLOT_TEXTS_H
#define EM_DRAW_PLOT_TEXTS_H

#include <stdint.h>

#include "draw/gnuplot.h"
#include "eventmill/plot.h"

/* Writes the texts of all series so that none lies on another, or on a point: beside its point, or
 * near it with a line that leads there. Sets the margins. Nothing where there are none. */
void em_plot_texts(struct em_gnuplot *script, const struct em_plot *plot);

/* The colour of series k (sRGB). */
const uint8_t *em_plot_colour(const struct em_plot *plot, size_t k);

#endif
