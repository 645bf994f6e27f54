/* What is written on a picture: ground, title, legend, time, histogram; by cairo. */
#ifndef EM_DRAW_OVERLAY_H
#define EM_DRAW_OVERLAY_H

#include <cairo.h>

#include "eventmill/picture.h"

enum { EM_OVERLAY_BINS = 48 };

/* Shares of the picture that the legend and the texts need for themselves. */
void em_overlay_margins(const struct em_picture_options *options, struct em_camera *camera);

/* The ground with all that stays the same: to be drawn once. */
void em_overlay_ground(cairo_surface_t *surface, const struct em_scene *scene,
                       const struct em_picture_options *options, const struct em_colour_map *map);

/* What changes: the time; the histogram of the values (NULL: none), counts in EM_OVERLAY_BINS equal
 * bins of the scale. */
void em_overlay_moment(cairo_surface_t *surface, const struct em_picture_options *options,
                       const struct em_colour_map *map, double time, const unsigned *bin);

#endif
