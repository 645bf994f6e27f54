/* A place for the legend. */
#include "draw/plot_key.h"

#include <math.h>
#include <stdbool.h>

#include "draw/plot_room.h"

/* Pixels: of a letter and a line of the font; of a sample of the curve; around all. */
static const double LETTER = 7.4, LINE = 23.5, SAMPLE = 60.0, AROUND = 16.0;
/* Around it, in shares of the area; wider legends go below the diagram. */
static const double MARGIN = 0.06, WIDE = 0.3;
/* A legend below the diagram, in shares of the picture. */
static const double TALLEST = 0.46, WIDEST = 0.9;

/* The names: how many, and how long. */
struct names {
  size_t count;
  double longest;
};

static struct names names_of(const struct em_plot *plot) {
  struct names n = {0, 0.0};
  for (size_t j = 0; j < plot->series_count; j++) {
    if (plot->series[j].name == NULL) continue;
    n.longest = fmax(n.longest, em_plot_room_letters(plot->series[j].name));
    n.count++;
  }
  return n;
}

/* One name below the other, as small as it takes. (Of a vertical legend, gnuplot makes more columns
 * where it is taller than the diagram.) */
static void put_below(struct em_gnuplot *script, const struct em_plot *plot,
                      const struct names *names) {
  const double width = plot->width > 0 ? plot->width : 1200;
  const double height = plot->height > 0 ? plot->height : 750;
  const double row = LINE / height, lines = row * (double)names->count;
  const double size =
      fmin(1.0, fmin(TALLEST / lines, WIDEST * width / (LETTER * names->longest + SAMPLE)));
  fprintf(script->out,
          "set bmargin at screen %.3f\n"
          "set key at screen 0.07, screen %.3f left top Left reverse horizontal maxcols 1 "
          "font ',%.3g' spacing %g\n",
          size * lines + 0.14, size * lines + 0.03, 12.0 * size, size < 1.0 ? 1.05 : 1.25);
}

void em_plot_key(struct em_gnuplot *script, const struct em_plot *plot, double ground) {
  static const char *const place[] = {"top right", "top left Left reverse", "bottom right",
                                      "bottom left Left reverse"};
  const struct names names = names_of(plot);
  const struct em_plot_room room = em_plot_room_of(plot, ground);
  const double w = (LETTER * names.longest + SAMPLE + AROUND) / room.width;
  const double h = (LINE * (double)names.count + AROUND) / room.height;
  bool texts = false, second = false;
  for (size_t j = 0; j < plot->series_count; j++) {
    texts |= plot->series[j].text != NULL;
    second |= plot->series[j].second_axis;
  }
  int corner = 0;
  for (; corner < 4 && names.count > 0; corner++) {
    const bool left = corner & 1, low = corner & 2;
    const struct em_plot_box box = {left ? -1.0 : 1.0 - w - MARGIN, left ? w + MARGIN : 2.0,
                                    low ? -1.0 : 1.0 - h - MARGIN, low ? h + MARGIN : 2.0};
    if (em_plot_room_is_free(&room, &box, true)) break;
  }
  const bool outside = corner == 4 && !texts, below = outside && w > WIDE;
  if (!outside || below) fprintf(script->out, "set rmargin %d\n", second ? 10 : 4);
  if (below)
    put_below(script, plot, &names);
  else if (outside)
    fputs("set key outside right top Left reverse\n", script->out);
  else
    fprintf(script->out, "set key %s\n", place[corner % 4]);
}
