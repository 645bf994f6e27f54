/* Finds what curves cover, piece by piece. */
#include "draw/plot_room.h"

#include <math.h>

/* The diagram's area, in shares of the picture. */
static const double WIDTH = 0.88, HEIGHT = 0.76;

static void take(struct em_plot_range *r, double value) {
  if (!isfinite(value) || (r->log && !(value > 0.0))) return;
  r->low = fmin(r->low, value);
  r->high = fmax(r->high, value);
}

static struct em_plot_range begin(bool log) {
  return (struct em_plot_range){INFINITY, -INFINITY, log};
}

static void finish(struct em_plot_range *r, double low, double high) {
  if (low < high) {
    r->low = low;
    r->high = high;
  } else if (r->log && r->low <= r->high) {
    r->low = pow(10.0, floor(log10(r->low)));
    r->high = pow(10.0, ceil(log10(r->high)));
  }
}

double em_plot_room_share(const struct em_plot_range *r, double value) {
  const double u = r->log ? log(fmax(value, 1e-300) / r->low) / log(r->high / r->low)
                          : (value - r->low) / (r->high - r->low);
  return isfinite(u) ? u : 0.5;
}

static double half_of(const struct em_plot_series *s, size_t k) {
  return s->error != NULL && isfinite(s->error[k]) ? s->error[k] : 0.0;
}

static size_t points_of(const struct em_plot_series *s) {
  return s->style == EM_PLOT_STEPS ? s->count + 1 : s->count;
}

static struct em_plot_range range_x(const struct em_plot *plot) {
  struct em_plot_range r = begin(plot->log_x);
  for (size_t j = 0; j < plot->series_count; j++)
    for (size_t k = 0; k < points_of(&plot->series[j]); k++)
      take(&r, plot->series[j].x[k]);
  if (plot->category_count > 0)
    finish(&r, -0.6, (double)plot->category_count - 0.4);
  else
    finish(&r, plot->x_low, plot->x_high);
  return r;
}

static struct em_plot_range range_y(const struct em_plot *plot, bool second, double ground) {
  struct em_plot_range r = begin(!second && plot->log_y);
  double least = INFINITY; /* of the values without their errors */
  for (size_t j = 0; j < plot->series_count; j++) {
    const struct em_plot_series *s = &plot->series[j];
    if (s->second_axis != second) continue;
    for (size_t k = 0; k < s->count; k++) {
      take(&r, s->y[k] - half_of(s, k));
      take(&r, s->y[k] + half_of(s, k));
      least = fmin(least, s->y[k]);
    }
    if (s->style == EM_PLOT_STEPS) take(&r, ground);
  }
  if (!second && !r.log && least >= 0.0) r.low = fmax(r.low, 0.0); /* as in plot.c */
  finish(&r, second ? 0.0 : plot->y_low, second ? 0.0 : plot->y_high);
  return r;
}

static bool meets(const struct em_plot_box *b, double x0, double x1, double y0, double y1) {
  return fmax(x0, x1) > b->left && fmin(x0, x1) < b->right && fmax(y0, y1) > b->low &&
         fmin(y0, y1) < b->high;
}

/* Does what a series draws between its points k and k + 1 lie in the box? */
static bool part_meets(const struct em_plot_box *b, const struct em_plot_series *s, size_t k,
                       const struct em_plot_range *x, const struct em_plot_range *y,
                       double ground) {
  enum { PARTS = 16 };
  if (!isfinite(s->y[k])) return false;
  const double x0 = em_plot_room_share(x, s->x[k]), y0 = em_plot_room_share(y, s->y[k]),
               half = half_of(s, k);
  if (s->style == EM_PLOT_STEPS)
    return meets(b, x0, em_plot_room_share(x, s->x[k + 1]), em_plot_room_share(y, ground), y0);
  if (meets(b, x0, x0, em_plot_room_share(y, s->y[k] - half),
            em_plot_room_share(y, s->y[k] + half)))
    return true;
  if (s->style == EM_PLOT_POINTS || k + 1 == s->count || !isfinite(s->y[k + 1])) return false;
  const double dx = (em_plot_room_share(x, s->x[k + 1]) - x0) / PARTS;
  const double dy = (em_plot_room_share(y, s->y[k + 1]) - y0) / PARTS;
  for (int j = 0; j < PARTS; j++)
    if (meets(b, x0 + j * dx, x0 + (j + 1) * dx, y0 + j * dy, y0 + (j + 1) * dy)) return true;
  return false;
}

struct em_plot_room em_plot_room_of(const struct em_plot *plot, double ground) {
  return (struct em_plot_room){.plot = plot,
                               .ground = ground,
                               .x = range_x(plot),
                               .y = {range_y(plot, false, ground), range_y(plot, true, ground)},
                               .width = WIDTH * (plot->width > 0 ? plot->width : 1200),
                               .height = HEIGHT * (plot->height > 0 ? plot->height : 750)};
}

bool em_plot_room_is_free(const struct em_plot_room *room, const struct em_plot_box *b,
                          bool marks) {
  const struct em_plot *plot = room->plot;
  for (size_t j = 0; j < plot->series_count; j++) {
    const struct em_plot_series *s = &plot->series[j];
    for (size_t k = 0; k < s->count; k++)
      if (part_meets(b, s, k, &room->x, &room->y[s->second_axis], room->ground)) return false;
  }
  for (size_t k = 0; marks && k < plot->mark_count; k++) {
    const struct em_plot_mark *m = &plot->mark[k];
    const double at = em_plot_room_share(m->horizontal ? &room->y[0] : &room->x, m->at);
    if (m->horizontal ? at > b->low && at < b->high : at > b->left && at < b->right) return false;
  }
  return true;
}

double em_plot_room_letters(const char *text) {
  double n = 0.0;
  for (const char *c = text; *c != '\0'; c++)
    n += ((unsigned char)*c & 0xC0) != 0x80;
  return n;
}
