/* One coordinate of a ball between two borders: what slices and cells are made of. Borders may be
 * infinite. A ball counts as beyond a border when it is less than `slack` before it and moves
 * towards it, so that rounding never leaves a ball stuck at one. */
#ifndef EVENTMILL_EVENT_SPAN_H
#define EVENTMILL_EVENT_SPAN_H

#include <assert.h>
#include <math.h>

#include "event/body.h"
#include "eventmill/surface.h"

/* Time (s) until x + v t + ½ g t² falls below `low`; 0 when it is below and falling. */
static inline double em_span_down(double x, double v, double g, double low) {
  return low > -INFINITY ? em_surface_plane(x - low, v, g, false) : INFINITY;
}

static inline double em_span_up(double x, double v, double g, double high) {
  return high < INFINITY ? em_surface_plane(high - x, -v, -g, false) : INFINITY;
}

/* Time (s) until the coordinate leaves [low, high]. */
static inline double em_span_leave(double x, double v, double g, double low, double high) {
  return fmin(em_span_down(x, v, g, low), em_span_up(x, v, g, high));
}

/* Which border is being crossed: −1 the lower, +1 the upper, 0 none. */
static inline int em_span_side(double x, double v, double g, double low, double high,
                               double slack) {
  const double down = em_span_down(x, v, g, low), up = em_span_up(x, v, g, high);
  if (up <= down) return up < INFINITY && high - x <= slack ? 1 : 0;
  return x - low <= slack ? -1 : 0;
}

/* The periodic image of x that is nearest to c. */
static inline double em_span_image(double x, double c, double period) {
  return period > 0.0 ? x - period * nearbyint((x - c) / period) : x;
}

/* How far (m) from a point a ball may stray in a periodic box so that of any other ball, which
 * strays as far, only the nearest image can be met: with two displacements of 2 × room
 * between prediction and contact, 4 room + 2 R < period / 2. INFINITY when no edge is periodic.
 * Above 0, for a scene's periodic edges are long enough: see PERIOD_LEAST in scene_check.c. */
static inline double em_span_room(const struct em_world *w) {
  double room = INFINITY;
  const double period[3] = {w->period.x, w->period.y, w->period.z};
  for (int k = 0; k < 3; k++)
    if (period[k] > 0.0) room = fmin(room, 0.24 * (0.5 * period[k] - 2.0 * w->largest));
  assert(room > 0.0);
  return room;
}

/* Latest time that leave times may have: blades are never searched further than an epoch. */
static inline double em_span_limit(const struct em_world *w, double from) {
  return w->blade_count ? from + w->epoch_length : INFINITY;
}

#endif
