/* Draws ground and legend. Lengths are given for a picture of 1280 × 720 and scaled with its size,
 * but not so far that the texts could not be read. Where the legend lies on the mill, the ground is
 * put between them. */
#include "draw/overlay.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "draw/letters.h"
#include "draw/plot_ticks.h"
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

/* The least scale: of texts that can be read. The least paper, in units of the layout, on which
 * there is room for a legend. */
static const double LEAST_SCALE = 0.62, LEAST_WIDTH = 320.0, LEAST_HEIGHT = 220.0;

/* Of the histogram's bars; of the letters. */
static const double LONGEST = 84.0, TITLE = 21.0, POINT = 14.5, KEY = 14.0, ROW = 28.0;

static double scale_of(const struct em_picture_options *o) {
  return fmax(fmin(o->width / 1280.0, o->height / 720.0), LEAST_SCALE);
}

static bool has_legend(const struct em_picture_options *o) {
  const double s = scale_of(o);
  return !o->hide_legend && o->width >= s * LEAST_WIDTH && o->height >= s * LEAST_HEIGHT;
}

static struct paper paper_on(cairo_surface_t *surface, const struct em_picture_options *o) {
  struct paper p = {.c = cairo_create(surface), .scale = scale_of(o), .dark = o->dark};
  p.width = o->width / p.scale;
  p.height = o->height / p.scale;
  cairo_scale(p.c, p.scale, p.scale);
  return p;
}

static bool has_bar(const struct em_picture_options *o) {
  return has_legend(o) && (o->by == EM_PICTURE_SPEED || o->by == EM_PICTURE_SPIN);
}

static struct bar bar_of(const struct paper *p) {
  const double h = fmin(430.0, p->height - 130.0);
  return (struct bar){p->width - 96.0, 0.5 * (p->height - h) + 14.0, 14.0, h};
}

void em_overlay_margins(const struct em_picture_options *options, struct em_camera *camera) {
  const double s = scale_of(options), w = options->width / s, h = options->height / s;
  camera->left = camera->right = 30.0 / w;
  camera->top = camera->bottom = 30.0 / h;
  if (!has_legend(options)) return;
  const bool wide = w > 1.25 * h;
  camera->right = (options->histogram ? 190.0 : 130.0) / w;
  camera->left = wide ? fmin(0.07, 90.0 / w) : 30.0 / w;
  camera->top = (wide ? 84.0 : 96.0) / h;
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

/* Chooses the font; returns how wide the text is. */
static double measure(const struct paper *p, double size, bool bold, const char *text) {
  cairo_text_extents_t box;
  cairo_select_font_face(p->c, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                         bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(p->c, size);
  cairo_text_extents(p->c, text, &box);
  return box.x_advance;
}

/* align: 0 left, 0.5 middle, 1 right of x. */
static void print(const struct paper *p, double x, double y, double size, bool bold, double align,
                  const char *text) {
  const double width = measure(p, size, bold, text);
  cairo_move_to(p->c, x - align * width, y);
  cairo_show_text(p->c, text);
}

static void take_ground(const struct paper *p, double alpha) {
  const double x = 0.46 * p->width, y = 0.46 * p->height;
  cairo_pattern_t *g = cairo_pattern_create_radial(x, y, 0.1 * p->height, x, y, 0.75 * p->width);
  if (p->dark) {
    cairo_pattern_add_color_stop_rgba(g, 0.0, 0.165, 0.180, 0.205, alpha);
    cairo_pattern_add_color_stop_rgba(g, 1.0, 0.045, 0.050, 0.060, alpha);
  } else {
    cairo_pattern_add_color_stop_rgba(g, 0.0, 0.985, 0.985, 0.982, alpha);
    cairo_pattern_add_color_stop_rgba(g, 1.0, 0.845, 0.860, 0.880, alpha);
  }
  cairo_set_source(p->c, g);
  cairo_pattern_destroy(g);
}

/* A panel behind a part of the legend, of the ground itself: it shows only where it lies on
 * something. */
static void back(const struct paper *p, double x, double y, double w, double h) {
  const double r = 8.0, right = x + w - r, low = y + h - r;
  cairo_new_path(p->c);
  cairo_arc(p->c, x + r, y + r, r, M_PI, 1.5 * M_PI);
  cairo_arc(p->c, right, y + r, r, 1.5 * M_PI, 2.0 * M_PI);
  cairo_arc(p->c, right, low, r, 0.0, 0.5 * M_PI);
  cairo_arc(p->c, x + r, low, r, 0.5 * M_PI, M_PI);
  cairo_close_path(p->c);
  take_ground(p, 0.86);
  cairo_fill(p->c);
}

/* As much of a text as is no wider than this, with "…" where it was cut. */
static void shorten(const struct paper *p, double size, bool bold, double width, char *text,
                    size_t room) {
  static const char dots[] = "…";
  size_t length = strlen(text);
  while (length > 0 && measure(p, size, bold, text) > width) {
    if (length > room - sizeof dots) length = room - sizeof dots;
    do
      length--;
    while (length > 0 && ((unsigned char)text[length] & 0xC0) == 0x80); /* UTF-8 */
    memcpy(text + length, dots, sizeof dots);
  }
}

static void draw_ticks(const struct paper *p, const struct bar *b, double low, double high) {
  enum { MOST = 16, DECIMALS = 5 };
  const double step = em_plot_ticks_step(high - low, 6.0), first = ceil(low / step - 1e-9);
  const int decimals = step < 1.0 ? (int)ceil(-log10(step) - 1e-9) : 0;
  const double most = fmax(fabs(low), fabs(high));
  const bool plain = decimals <= DECIMALS && most < 1e7;
  const int digits = plain ? decimals : 1 + (int)ceil(log10(most / step));
  for (int j = 0; j < MOST && (first + j) * step <= high + 1e-9 * step; j++) {
    const double value = (first + j) * step + 0.0;
    const double y = b->y + b->h * (1.0 - (value - low) / (high - low));
    char text[32];
    ink(p, 0.55);
    cairo_set_line_width(p->c, 1.0);
    cairo_move_to(p->c, b->x + b->w + 2.0, y);
    cairo_rel_line_to(p->c, 5.0, 0.0);
    cairo_stroke(p->c);
    snprintf(text, sizeof text, plain ? "%.*f" : "%.*g", digits, value);
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
  const double left = o->histogram ? LONGEST + 10.0 : 12.0;
  back(p, b.x - left, b.y - 56.0, p->width - 12.0 - b.x + left, b.h + 70.0);
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

/* Names with their colours: as many as there is room for. */
static void draw_swatches(const struct paper *p, const struct em_scene *scene,
                          const struct em_picture_options *o) {
  const bool by_class = o->by == EM_PICTURE_CLASS;
  const size_t all = by_class ? EM_CLASS_COUNT : scene->species_count;
  const size_t room = (size_t)fmin((p->height - 100.0) / ROW, 16.0);
  const size_t count = all <= room ? all : room;
  const double x = p->width - 150.0;
  double y = 0.5 * p->height - 0.5 * ROW * (double)count;
  back(p, x - 12.0, y - 52.0, p->width - x, ROW * (double)count + 40.0);
  ink(p, 0.92);
  print(p, x, y - 28.0, 15.0, true, 0.0, by_class ? "Last contact" : "Balls");
  for (size_t k = 0; k < count; k++, y += ROW) {
    char name[EM_SCENE_NAME];
    if (k + 1 == count && all > count) { /* the last line tells that there are more */
      snprintf(name, sizeof name, "and %zu more", all - k);
    } else {
      snprintf(name, sizeof name, "%s",
               by_class ? em_contact_class_name((enum em_class)k) : scene->species[k].name);
      set_colour(p, em_colour_cycle((unsigned)k));
      cairo_arc(p->c, x + 8.0, y - 5.0, 8.0, 0.0, 2.0 * M_PI);
      cairo_fill(p->c);
    }
    em_letters_clean(name);
    shorten(p, KEY, false, p->width - 12.0 - x - 26.0, name, sizeof name);
    ink(p, 0.80);
    print(p, x + 26.0, y, KEY, false, 0.0, name);
  }
}

/* Which balls are shown, where not all are. */
static void add_choice(const struct em_scene *scene, const struct em_picture_options *o, char *text,
                       size_t size) {
  const bool fewer = o->limit > 0 && o->limit < em_scene_ball_count(scene);
  const bool range = o->show_low > 0.0 || o->show_high > 0.0;
  if (o->hide_balls || (!fewer && !range)) return;
  size_t used = strlen(text);
  if (fewer) used += (size_t)snprintf(text + used, size - used, " · %zu of them", o->limit);
  if (range && o->show_high > 0.0)
    used += (size_t)snprintf(text + used, size - used, " · those at %g to %g m/s", o->show_low,
                             o->show_high);
  else if (range)
    used += (size_t)snprintf(text + used, size - used, " · those above %g m/s", o->show_low);
  if (o->histogram && has_bar(o)) snprintf(text + used, size - used, " (histogram: all)");
}

/* The title; below it the operating point. */
static void draw_title(const struct paper *p, const struct em_scene *scene,
                       const struct em_picture_options *o) {
  const double width = p->width - 56.0;
  char title[256], point[512];
  snprintf(title, sizeof title, "%s", scene->title);
  em_plot_operating_point(scene, point, 256);
  em_letters_clean(title);
  em_letters_clean(point);
  add_choice(scene, o, point, sizeof point);
  shorten(p, TITLE, true, width, title, sizeof title);
  shorten(p, POINT, false, width, point, sizeof point);
  const double w = fmax(measure(p, TITLE, true, title), measure(p, POINT, false, point));
  const bool two = title[0] != '\0';
  back(p, 18.0, 20.0, w + 20.0, two ? 58.0 : 36.0);
  ink(p, 0.95);
  print(p, 28.0, 44.0, TITLE, true, 0.0, title);
  ink(p, 0.70);
  print(p, 28.0, two ? 68.0 : 44.0, POINT, false, 0.0, point);
}

/* What the marks of collisions mean, above the time. */
static void draw_mark_key(const struct paper *p, const struct em_picture_options *o) {
  const double line = 23.0, x = 28.0, rim = 0.7; /* as in spheres.c */
  double y = p->height - 64.0 - line * EM_CLASS_COUNT;
  char text[64];
  snprintf(text, sizeof text, "Collisions, last %.3g ms", 1e3 * o->marked);
  back(p, x - 10.0, y - 22.0, measure(p, KEY, true, text) + 20.0,
       line * (EM_CLASS_COUNT + 1) + 8.0);
  ink(p, 0.92);
  print(p, x, y, KEY, true, 0.0, text);
  for (int k = 0; k < EM_CLASS_COUNT; k++) {
    y += line;
    cairo_set_source_rgb(p->c, 1.0, 1.0, 1.0);
    cairo_arc(p->c, x + 8.0, y - 5.0, 7.0, 0.0, 2.0 * M_PI);
    cairo_fill(p->c);
    set_colour(p, em_colour_cycle((unsigned)k));
    cairo_arc(p->c, x + 8.0, y - 5.0, 7.0 * rim, 0.0, 2.0 * M_PI);
    cairo_fill(p->c);
    ink(p, 0.80);
    print(p, x + 26.0, y, KEY, false, 0.0, em_contact_class_name((enum em_class)k));
  }
}

void em_overlay_ground(cairo_surface_t *surface, const struct em_picture_options *options) {
  const struct paper p = paper_on(surface, options);
  take_ground(&p, 1.0);
  cairo_paint(p.c);
  cairo_destroy(p.c);
}

void em_overlay_legend(cairo_surface_t *surface, const struct em_scene *scene,
                       const struct em_picture_options *options, const struct em_colour_map *map) {
  EM_LOCALE_PLAIN;
  if (!has_legend(options)) return;
  const struct paper p = paper_on(surface, options);
  draw_title(&p, scene, options);
  if (has_bar(options)) draw_bar(&p, options, map);
  if (options->by == EM_PICTURE_CLASS || options->by == EM_PICTURE_SPECIES)
    draw_swatches(&p, scene, options);
  if (options->marked > 0.0) draw_mark_key(&p, options);
  if (options->note[0] != '\0') {
    const double w = measure(&p, 14.0, false, options->note);
    back(&p, p.width - w - 38.0, p.height - 48.0, w + 20.0, 30.0);
    ink(&p, 0.60);
    print(&p, p.width - 28.0, p.height - 28.0, 14.0, false, 1.0, options->note);
  }
  cairo_destroy(p.c);
}

/* Bars that grow to the left of the colour bar, which is their axis. */
static void draw_histogram(const struct paper *p, const struct em_colour_map *map,
                           const unsigned *bin) {
  const struct bar b = bar_of(p);
  const double step = b.h / EM_OVERLAY_BINS;
  unsigned most = 1;
  for (int k = 0; k < EM_OVERLAY_BINS; k++)
    most = bin[k] > most ? bin[k] : most;
  for (int k = 0; k < EM_OVERLAY_BINS; k++) {
    const double w = LONGEST * bin[k] / most;
    set_colour(p, em_colour_at(map, k + 0.5, 0.0, EM_OVERLAY_BINS));
    cairo_rectangle(p->c, b.x - 5.0 - w, b.y + b.h - (k + 1) * step + 0.6, w, step - 1.2);
    cairo_fill(p->c);
  }
}

/* Of the time: a thousandth of the run can be told. */
static int decimals_of(const struct em_scene *scene) {
  return scene->duration > 0.0 ? (int)fmin(fmax(3.0 - floor(log10(scene->duration)), 4.0), 12.0)
                               : 4;
}

void em_overlay_moment(cairo_surface_t *surface, const struct em_scene *scene,
                       const struct em_picture_options *options, const struct em_colour_map *map,
                       const struct em_picture_state *state, const unsigned *bin) {
  EM_LOCALE_PLAIN;
  if (!has_legend(options)) return;
  const struct paper p = paper_on(surface, options);
  char text[96];
  const int used = snprintf(text, sizeof text, "t = %.*f s", decimals_of(scene), state->time);
  if (state->unmarked > 0)
    snprintf(text + used, sizeof text - (size_t)used, " · %zu earlier collisions unmarked",
             state->unmarked);
  back(&p, 18.0, p.height - 50.0, measure(&p, 18.0, false, text) + 20.0, 32.0);
  ink(&p, 0.90);
  print(&p, 28.0, p.height - 28.0, 18.0, false, 0.0, text);
  if (bin != NULL && has_bar(options)) draw_histogram(&p, map, bin);
  cairo_destroy(p.c);
}
