/* Places for words beside points: the nearest that is free, one point after the other. */
#include "draw/plot_texts.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "draw/plot_room.h"

/* The diagram's area, in shares of the picture. */
static const double LEFT = 0.085, RIGHT = 0.97, BOTTOM = 0.115;
/* Pixels: of a letter and a line of the font; of a point; between them; steps away from a point. */
static const double LETTER = 6.9, LINE = 17.0, DOT = 6.0, GAP = 10.0, LEADER = 26.0, STEP = 6.0;
enum { STEPS = 40 };

struct box {
  double left, right, low, high;
};

/* A text with its point and its place, in pixels from the lower left corner. */
struct words {
  const char *text;
  const uint8_t *colour;
  double at[2]; /* in the diagram's own coordinates */
  double x, y;
  struct box box;
  bool leads; /* by a line */
};

static double share(double value, double low, double high, bool log) {
  return log ? log10(value / low) / log10(high / low) : (value - low) / (high - low);
}

static bool overlap(const struct box *a, const struct box *b) {
  return a->left < b->right && b->left < a->right && a->low < b->high && b->low < a->high;
}

/* Does the line from a text to its point cross a box? */
static bool crosses(const struct words *w, const struct box *b) {
  enum { PARTS = 24 };
  if (!w->leads) return false;
  const double x = w->box.left > w->x ? w->box.left : w->box.right;
  const double y = 0.5 * (w->box.low + w->box.high);
  for (int k = 0; k <= PARTS; k++) {
    const double s = (double)k / PARTS, px = w->x + s * (x - w->x), py = w->y + s * (y - w->y);
    if (px > b->left && px < b->right && py > b->low && py < b->high) return true;
  }
  return false;
}

/* Words `w[k]` against all points and the words that have their places: those before. */
static bool is_free(const struct words *w, size_t count, size_t k, const struct box *area) {
  const struct box *own = &w[k].box;
  if (own->left < area->left || own->right > area->right || own->low < area->low ||
      own->high > area->high)
    return false;
  for (size_t j = 0; j < count; j++) {
    const struct box dot = {w[j].x - DOT, w[j].x + DOT, w[j].y - DOT, w[j].y + DOT};
    if (overlap(own, &dot)) return false;
    if (j < k && (overlap(own, &w[j].box) || crosses(&w[k], &w[j].box) || crosses(&w[j], own)))
      return false;
  }
  return true;
}

/* Puts words so many pixels above their point, to its right or left. */
static void put(struct words *w, double above, bool left) {
  const double width = LETTER * em_plot_room_letters(w->text);
  w->leads = above != 0.0;
  const double away = w->leads ? LEADER : GAP;
  const double start = left ? w->x - away - width : w->x + away;
  w->box = (struct box){start, start + width, w->y + above - 0.5 * LINE, w->y + above + 0.5 * LINE};
}

static void place(struct words *w, size_t count, size_t k, const struct box *area) {
  for (int step = 0; step < STEPS; step++)
    for (int way = 0; way < 4; way++) {
      put(&w[k], (way % 2 ? STEP : -STEP) * step, way >= 2);
      if (is_free(w, count, k, area)) return;
    }
  put(&w[k], 0.0, false);
}

/* From the right to the left: what stands furthest right has the room beside it. */
static int by_place(const void *a, const void *b) {
  const struct words *u = a, *v = b;
  if (u->x != v->x) return u->x < v->x ? 1 : -1;
  return (u->y < v->y) - (u->y > v->y);
}

static size_t gather(struct words *w, const struct em_plot *plot, const struct box *area) {
  size_t count = 0;
  for (size_t k = 0; k < plot->series_count; k++) {
    const struct em_plot_series *s = &plot->series[k];
    for (size_t j = 0; s->text != NULL && j < s->count; j++) {
      const double u = share(s->x[j], plot->x_low, plot->x_high, plot->log_x);
      const double v = share(s->y[j], plot->y_low, plot->y_high, plot->log_y);
      if (!isfinite(u) || !isfinite(v)) continue;
      w[count++] = (struct words){.text = s->text[j],
                                  .colour = em_plot_colour(plot, k),
                                  .at = {s->x[j], s->y[j]},
                                  .x = area->left + u * (area->right - area->left),
                                  .y = area->low + v * (area->high - area->low)};
    }
  }
  return count;
}

static void write_words(struct em_gnuplot *g, const struct words *w, double width, double height) {
  const bool left = w->box.right < w->x;
  const double x = (left ? w->box.right : w->box.left) / width;
  const double y = 0.5 * (w->box.low + w->box.high) / height;
  fputs("set label ", g->out);
  em_gnuplot_string(g, w->text);
  fprintf(g->out,
          " at screen %.5f, screen %.5f %s font ',10' textcolor rgb '#%02x%02x%02x' noenhanced "
          "front\n",
          x, y, left ? "right" : "left", w->colour[0], w->colour[1], w->colour[2]);
  if (w->leads)
    fprintf(g->out,
            "set arrow from first %.9g, first %.9g to screen %.5f, screen %.5f nohead lw 0.8 lc "
            "rgb '#%02x%02x%02x' back\n",
            w->at[0], w->at[1], x + (left ? 3.0 : -3.0) / width, y, w->colour[0], w->colour[1],
            w->colour[2]);
}

void em_plot_texts(struct em_gnuplot *script, const struct em_plot *plot) {
  size_t room = 0;
  for (size_t k = 0; k < plot->series_count; k++)
    if (plot->series[k].text != NULL) room += plot->series[k].count;
  struct words *w = room > 0 ? calloc(room, sizeof *w) : NULL;
  if (w == NULL) return;
  const double width = plot->width > 0 ? plot->width : 1200;
  const double height = plot->height > 0 ? plot->height : 750;
  const struct box area = {LEFT * width, RIGHT * width, BOTTOM * height, EM_GNUPLOT_TOP * height};
  const size_t count = gather(w, plot, &area);
  qsort(w, count, sizeof *w, by_place);
  fprintf(script->out,
          "set lmargin at screen %g\nset rmargin at screen %g\nset bmargin at screen %g\n", LEFT,
          RIGHT, BOTTOM);
  for (size_t k = 0; k < count; k++)
    place(w, count, k, &area);
  for (size_t k = 0; k < count; k++)
    write_words(script, &w[k], width, height);
  free(w);
}
