/* Draws ground and legend. Lengths are given for a picture of 1280 × 720 and scaled with its size.
 */
#include "draw/overlay.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "eventmill/plot.h"
#include "num/locale.h"

struct paper {
  cairo_t *c;
  double scale, width, height; /* width and height in units of the layout */
  bool dark;
};

/* Where the colour bar is, in units of the layout. */
struct bar {
  double x, y, w, h;
};

static double scale_of(const struct em_picture_options *o) {
  return fmin(o->width / 1280.0, o->height / 720.0);
}

static struct paper paper_on(cairo_surface_t *surface, const struct em_picture_options *o) {
  struct paper p = {.c = cairo_create(surface), .scale = scale_of(o), .dark = o->dark};
  p.width = o->width / p.scale;
  p.height = o->height / p.scale;
  cairo_scale(p.c, p.scale, p.scale);
  return p;
}

static bool has_bar(const struct em_picture_options *o) {
  return !o->hide_legend && (o->by == EM_PICTURE_SPEED || o->by == EM_PICTURE_SPIN);
}

static struct bar bar_of(const struct paper *p) {
  const double h = fmin(430.0, p->height - 250.0);
  return (struct bar){p->width - 96.0, 0.5 * (p->height - h) + 14.0, 14.0, h};
}

void em_overlay_margins(const struct em_picture_options *options, struct em_camera *camera) {
  const double s = scale_of(options), w = options->width / s, h = options->height / s;
  camera->left = camera->right = 30.0 / w;
  camera->top = camera->bottom = 30.0 / h;
  if (options->hide_legend) return;
  const bool wide = w > 1.25 * h;
  camera->right = (options->histogram ? 190.0 : 130.0) / w;
  camera->left = (wide ? 90.0 : 30.0) / w;
  camera->top = (wide ? 56.0 : 96.0) / h;
  camera->bottom = (wide ? 30.0 : 64.0) / h;
}

/* strength 0: the ground, 1: the strongest ink. */
static void ink(const struct paper *p, double strength) {
  const double from[3] = {p->dark ? 0.09 : 0.96, p->dark ? 0.10 : 0.965, p->dark ? 0.12 : 0.97};
  const double to[3] = {p->dark ? 0.96 : 0.11, p->dark ? 0.965 : 0.125, p->dark ? 0.97 : 0.15};
  cairo_set_source_rgb(p->c, from[0] + strength * (to[0] - from[0]),
                       from[1] + strength * (to[1] - from[1]),
                       from[2] + strength * (to[2] - from[2]));
}

/* align: 0 left, 0.5 middle, 1 right of x. */
static void print(const struct paper *p, double x, double y, double size, bool bold, double align,
                  const char *text) {
  cairo_text_extents_t box;
  cairo_select_font_face(p->c, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                         bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(p->c, size);
  cairo_text_extents(p->c, text, &box);
  cairo_move_to(p->c, x - align * box.x_advance, y);
  cairo_show_text(p->c, text);
}

static void fill_ground(const struct paper *p) {
  const double x = 0.46 * p->width, y = 0.46 * p->height;
  cairo_pattern_t *g = cairo_pattern_create_radial(x, y, 0.1 * p->height, x, y, 0.75 * p->width);
  if (p->dark) {
    cairo_pattern_add_color_stop_rgb(g, 0.0, 0.165, 0.180, 0.205);
    cairo_pattern_add_color_stop_rgb(g, 1.0, 0.045, 0.050, 0.060);
  } else {
    cairo_pattern_add_color_stop_rgb(g, 0.0, 0.985, 0.985, 0.982);
    cairo_pattern_add_color_stop_rgb(g, 1.0, 0.845, 0.860, 0.880);
  }
  cairo_set_source(p->c, g);
  cairo_paint(p->c);
  cairo_pattern_destroy(g);
}

/* A step of 1, 2 or 5 times a power of ten, with about six of them in the range. */
static double tick_step(double range) {
  const double raw = range / 6.0, power = pow(10.0, floor(log10(raw))), lead = raw / power;
  return power * (lead < 1.5 ? 1.0 : lead < 3.5 ? 2.0 : lead < 7.5 ? 5.0 : 10.0);
}

static void draw_ticks(const struct paper *p, const struct bar *b, double low, double high) {
  const double step = tick_step(high - low);
  const int digits = step < 1.0 ? (int)ceil(-log10(step) - 1e-9) : 0;
  for (double k = ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1.0) {
    const double y = b->y + b->h * (1.0 - (k * step - low) / (high - low));
    char text[32];
    ink(p, 0.55);
    cairo_set_line_width(p->c, 1.0);
    cairo_move_to(p->c, b->x + b->w + 2.0, y);
    cairo_rel_line_to(p->c, 5.0, 0.0);
    cairo_stroke(p->c);
    snprintf(text, sizeof text, "%.*f", digits, k * step + 0.0);
    ink(p, 0.80);
    print(p, b->x + b->w + 12.0, y + 5.0, 14.0, false, 0.0, text);
  }
}

static void set_colour(const struct paper *p, const uint8_t *rgb) {
  cairo_set_source_rgb(p->c, rgb[0] / 255.0, rgb[1] / 255.0, rgb[2] / 255.0);
}

static void draw_bar(const struct paper *p, const struct em_picture_options *o,
                     const struct em_colour_map *map) {
  const struct bar b = bar_of(p);
  const bool spin = o->by == EM_PICTURE_SPIN;
  cairo_pattern_t *g = cairo_pattern_create_linear(0.0, b.y + b.h, 0.0, b.y);
  for (int k = 0; k < EM_COLOUR_STEPS; k += 5)
    cairo_pattern_add_color_stop_rgb(g, k / (double)(EM_COLOUR_STEPS - 1), map->rgb[k][0] / 255.0,
                                     map->rgb[k][1] / 255.0, map->rgb[k][2] / 255.0);
  cairo_rectangle(p->c, b.x, b.y, b.w, b.h);
  cairo_set_source(p->c, g);
  cairo_fill(p->c);
  cairo_pattern_destroy(g);
  draw_ticks(p, &b, o->low, o->high);
  ink(p, 0.92);
  print(p, b.x - 1.0, b.y - 34.0, 15.0, true, 0.0, spin ? "Spin" : "Speed");
  ink(p, 0.70);
  print(p, b.x - 1.0, b.y - 15.0, 14.0, false, 0.0, spin ? "rad/s" : "m/s");
}

static void draw_swatches(const struct paper *p, const struct em_scene *scene,
                          const struct em_picture_options *o) {
  const bool by_class = o->by == EM_PICTURE_CLASS;
  const size_t count = by_class ? EM_CLASS_COUNT : scene->species_count;
  const double x = p->width - 150.0;
  double y = 0.5 * p->height - 14.0 * (double)count;
  ink(p, 0.92);
  print(p, x, y - 28.0, 15.0, true, 0.0, by_class ? "Last contact" : "Balls");
  for (size_t k = 0; k < count && k < 16; k++, y += 28.0) {
    set_colour(p, em_colour_cycle((unsigned)k));
    cairo_arc(p->c, x + 8.0, y - 5.0, 8.0, 0.0, 2.0 * M_PI);
    cairo_fill(p->c);
    ink(p, 0.80);
    print(p, x + 26.0, y, 14.0, false, 0.0,
          by_class ? em_contact_class_name((enum em_class)k) : scene->species[k].name);
  }
}

/* "TITLE · OPERATING POINT" in two lines. */
static void draw_title(const struct paper *p, const struct em_scene *scene) {
  char point[256];
  em_plot_subtitle(scene, point, sizeof point);
  const char *rest = point;
  if (strncmp(point, scene->title, strlen(scene->title)) == 0 && scene->title[0] != '\0') {
    rest = point + strlen(scene->title);
    if (strncmp(rest, " · ", strlen(" · ")) == 0) rest += strlen(" · ");
  }
  ink(p, 0.95);
  print(p, 28.0, 44.0, 21.0, true, 0.0, scene->title);
  ink(p, 0.70);
  print(p, 28.0, scene->title[0] != '\0' ? 68.0 : 44.0, 14.5, false, 0.0, rest);
}

void em_overlay_ground(cairo_surface_t *surface, const struct em_scene *scene,
                       const struct em_picture_options *options, const struct em_colour_map *map) {
  EM_LOCALE_PLAIN;
  const struct paper p = paper_on(surface, options);
  fill_ground(&p);
  if (!options->hide_legend) {
    draw_title(&p, scene);
    if (has_bar(options)) draw_bar(&p, options, map);
    if (options->by == EM_PICTURE_CLASS || options->by == EM_PICTURE_SPECIES)
      draw_swatches(&p, scene, options);
    if (options->note[0] != '\0') {
      ink(&p, 0.60);
      print(&p, p.width - 28.0, p.height - 28.0, 14.0, false, 1.0, options->note);
    }
  }
  cairo_destroy(p.c);
}

/* Bars that grow to the left of the colour bar, which is their axis. */
static void draw_histogram(const struct paper *p, const struct em_colour_map *map,
                           const unsigned *bin) {
  const struct bar b = bar_of(p);
  const double step = b.h / EM_OVERLAY_BINS, longest = 84.0;
  unsigned most = 1;
  for (int k = 0; k < EM_OVERLAY_BINS; k++)
    most = bin[k] > most ? bin[k] : most;
  for (int k = 0; k < EM_OVERLAY_BINS; k++) {
    const double w = longest * bin[k] / most;
    set_colour(p, em_colour_at(map, k + 0.5, 0.0, EM_OVERLAY_BINS));
    cairo_rectangle(p->c, b.x - 5.0 - w, b.y + b.h - (k + 1) * step + 0.6, w, step - 1.2);
    cairo_fill(p->c);
  }
}

void em_overlay_moment(cairo_surface_t *surface, const struct em_picture_options *options,
                       const struct em_colour_map *map, double time, const unsigned *bin) {
  EM_LOCALE_PLAIN;
  if (options->hide_legend) return;
  const struct paper p = paper_on(surface, options);
  char text[64];
  snprintf(text, sizeof text, "t = %.4f s", time);
  ink(&p, 0.90);
  print(&p, 28.0, p.height - 28.0, 18.0, false, 0.0, text);
  if (bin != NULL && has_bar(options)) draw_histogram(&p, map, bin);
  cairo_destroy(p.c);
}
