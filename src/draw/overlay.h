/* What is written on a picture: ground, title, legend, time, histogram; by cairo. */
#ifndef EM_DRAW_OVERLAY_H
#define EM_DRAW_OVERLAY_H

#include <cairo.h>

#include "eventmill/picture.h"

enum { EM_OVERLAY_BINS = 48 };

/* Shares of the picture that the legend and the texts need for themselves. */
void em_overlay_margins(const struct em_picture_options *options, struct em_camera *camera);

/* What is behind everything. */
void em_overlay_ground(cairo_surface_t *surface, const struct em_picture_options *options);

/* All texts that stay the same, on a surface that lets through what is behind them. */
void em_overlay_legend(cairo_surface_t *surface, const struct em_scene *scene,
                       const struct em_picture_options *options, const struct em_colour_map *map);

/* What changes, on top of everything: the time; the histogram of the values (NULL: none), counts in
 * EM_OVERLAY_BINS equal bins of the scale. */
void em_overlay_moment(cairo_surface_t *surface, const struct em_scene *scene,
                       const struct em_picture_options *options, const struct em_colour_map *map,
                       const struct em_picture_state *state, const unsigned *bin);

#endif
