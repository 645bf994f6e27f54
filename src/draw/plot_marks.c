/* Places for the names of lines. */
#include "draw/plot_marks.h"

#include <stdbool.h>

#include "draw/plot_room.h"

/* Pixels: of a letter and a line of the font, with what is around them. */
static const double LETTER = 7.2, LINE = 24.0;
/* Shares of the area: from the end of a line to its name. */
static const double FROM_END = 0.02;

/* A name at the far or the near end of its line, and below (to the right of) or above it. */
struct place {
  bool near, below;
};

static struct em_plot_box box_at(const struct em_plot_room *room, const struct em_plot_mark *m,
                                 struct place p) {
  const double along =
      LETTER * em_plot_room_letters(m->name) / (m->horizontal ? room->width : room->height);
  const double across = LINE / (m->horizontal ? room->height : room->width);
  const double at = em_plot_room_share(m->horizontal ? &room->y[0] : &room->x, m->at);
  const double first = p.near ? FROM_END : 1.0 - FROM_END - along, last = first + along;
  /* Above a lying line is more, left of a standing one is less. */
  const bool more = m->horizontal ? !p.below : p.below;
  const double low = more ? at : at - across, high = more ? at + across : at;
  if (m->horizontal) return (struct em_plot_box){first, last, low, high};
  return (struct em_plot_box){low, high, first, last};
}

static bool is_inside(const struct em_plot_box *b) {
  return b->left >= 0.0 && b->right <= 1.0 && b->low >= 0.0 && b->high <= 1.0;
}

static struct place find_place(const struct em_plot_room *room, const struct em_plot_mark *m) {
  const bool lying = m->horizontal; /* names begin at the left, or at the top */
  const struct place choice[] = {{lying, false}, {lying, true}, {!lying, false}, {!lying, true}};
  for (int wish = 0; wish < 2; wish++)
    for (int k = 0; k < 4; k++) {
      const struct em_plot_box box = box_at(room, m, choice[k]);
      if (is_inside(&box) && (wish || em_plot_room_is_free(room, &box, false))) return choice[k];
    }
  return choice[0];
}

void em_plot_marks(struct em_gnuplot *script, const struct em_plot *plot, double ground) {
  FILE *out = script->out;
  const struct em_plot_room room = em_plot_room_of(plot, ground);
  fputs("set style textbox opaque noborder fillcolor rgb '#ffffff' margins 0.4,0.4\n", out);
  for (size_t k = 0; k < plot->mark_count; k++) {
    const struct em_plot_mark *m = &plot->mark[k];
    fprintf(out,
            m->horizontal ? "set arrow from graph 0, first %.9g to graph 1, first %.9g"
                          : "set arrow from first %.9g, graph 0 to first %.9g, graph 1",
            m->at, m->at);
    fputs(" nohead dt 2 lw 1.2 lc rgb '#8b919c' back\n", out);
    if (m->name == NULL) continue;
    const struct place p = find_place(&room, m);
    const double end = p.near ? FROM_END : 1.0 - FROM_END;
    fputs("set label ", out);
    em_gnuplot_string(script, m->name);
    if (m->horizontal)
      fprintf(out, " at graph %g, first %.9g %s offset 0,%g", end, m->at, p.near ? "left" : "right",
              p.below ? -0.6 : 0.6);
    else
      fprintf(out, " at first %.9g, graph %g %s rotate by 90 offset %g,0", m->at, end,
              p.near ? "left" : "right", p.below ? 1.2 : -1.0);
    fputs(" font ',11' textcolor rgb '#6a707b' noenhanced boxed front\n", out);
  }
}
