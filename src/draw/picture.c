/* Pictures: the ground by cairo, balls and machine by OpenGL, the legend by cairo, put one upon the
 * other. */
#include "eventmill/picture.h"

#include <cairo.h>
#include <stdlib.h>
#include <string.h>

#include "draw/canvas.h"
#include "draw/occlusion.h"
#include "draw/overlay.h"
#include "draw/solids.h"
#include "draw/spheres.h"

struct order {
  float distance;
  unsigned index;
};

struct em_picture {
  const struct em_scene *scene;
  struct em_picture_options options;
  struct em_camera_aim aim;
  struct em_colour_map map;
  struct em_canvas *canvas;
  const struct em_gl *gl;
  struct em_spheres spheres;
  struct em_solids solids;
  struct em_occlusion occlusion;
  size_t sphere_room;
  struct em_sphere *sphere; /* twice sphere_room: as they come, and sorted */
  struct order *order;      /* sphere_room */
  unsigned bin[EM_OVERLAY_BINS];
  cairo_surface_t *ground, *legend, *sheet;
  uint8_t *small; /* the drawing at the picture's size; NULL where that is the canvas's */
};

const char *em_picture_name(enum em_picture_by by) {
#define NAME(code, text) text,
  static const char *const name[] = {EM_PICTURE_LIST(NAME)};
#undef NAME
  return (unsigned)by < EM_PICTURE_KINDS ? name[by] : "?";
}

int em_picture_find(const char *name) {
  for (int k = 0; k < EM_PICTURE_KINDS; k++)
    if (strcmp(name, em_picture_name((enum em_picture_by)k)) == 0) return k;
  return -1;
}

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double percentile_99(const struct em_vec *v, size_t count) {
  double *length = count > 0 ? malloc(count * sizeof *length) : NULL;
  if (length == NULL) return 0.0;
  for (size_t k = 0; k < count; k++)
    length[k] = em_vec_norm(v[k]);
  qsort(length, count, sizeof *length, ascending);
  const double result = length[(size_t)(0.99 * (double)(count - 1))];
  free(length);
  return result;
}

double em_picture_scale(const struct em_scene *scene, const struct em_balls *balls) {
  double tip = 0.0;
  for (size_t r = 0; r < scene->rotor_count; r++)
    for (size_t k = 0; k < scene->rotor[r].blade_count; k++) {
      const struct em_blade *blade = &scene->rotor[r].blade[k];
      tip = fmax(tip, fabs(blade->omega) * blade->reach);
    }
  if (tip > 0.0) return 1.1 * tip;
  const double most = balls != NULL ? percentile_99(balls->velocity, balls->count) : 0.0;
  return most > 0.0 ? most : em_scene_typical_speed(scene);
}

double em_picture_spin_scale(const struct em_balls *balls) {
  const double most = percentile_99(balls->spin, balls->count);
  return most > 0.0 ? most : 1.0;
}

struct em_picture_options em_picture_default(const struct em_scene *scene,
                                             const struct em_balls *balls) {
  return (struct em_picture_options){
      .width = 1280,
      .height = 720,
      .smooth = 2,
      .camera = em_camera_make(EM_CAMERA_THREE_QUARTER),
      .by = EM_PICTURE_SPEED,
      .map = EM_COLOUR_LAGOON,
      .high = em_picture_scale(scene, balls),
      .histogram = true,
  };
}

static void aim(struct em_picture *p) {
  struct em_vec low, high, outline[EM_SOLIDS_OUTLINE];
  const size_t count = em_solids_outline(p->scene, outline);
  em_scene_extent(p->scene, &low, &high);
  em_overlay_margins(&p->options, &p->options.camera);
  em_camera_aim(&p->options.camera, low, high, outline, count, p->options.width, p->options.height,
                &p->aim);
}

void em_picture_turn(struct em_picture *picture, double azimuth) {
  picture->options.camera.azimuth = azimuth;
  aim(picture);
}

static enum em_status make_sheets(struct em_picture *p, struct em_error *err) {
  const int w = p->options.width, h = p->options.height;
  p->ground = cairo_image_surface_create(CAIRO_FORMAT_RGB24, w, h);
  p->legend = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, w, h);
  p->sheet = cairo_image_surface_create(CAIRO_FORMAT_RGB24, w, h);
  if (p->options.smooth > 1) p->small = malloc(4 * (size_t)w * (size_t)h);
  if (cairo_surface_status(p->ground) != CAIRO_STATUS_SUCCESS ||
      cairo_surface_status(p->legend) != CAIRO_STATUS_SUCCESS ||
      cairo_surface_status(p->sheet) != CAIRO_STATUS_SUCCESS ||
      (p->options.smooth > 1 && p->small == NULL))
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a picture of %d x %d", w, h);
  em_overlay_ground(p->ground, &p->options);
  em_overlay_legend(p->legend, p->scene, &p->options, &p->map);
  cairo_surface_flush(p->ground);
  cairo_surface_flush(p->legend);
  return EM_OK;
}

static enum em_status make_layers(struct em_picture *p, struct em_error *err) {
  const struct em_picture_options *o = &p->options;
  enum em_status status =
      em_canvas_new(&p->canvas, o->smooth * o->width, o->smooth * o->height, err);
  if (status != EM_OK) return status;
  p->gl = em_canvas_current(p->canvas, err);
  if (p->gl == NULL) return EM_PICTURE;
  p->gl->Viewport(0, 0, o->smooth * o->width, o->smooth * o->height);
  p->gl->Enable(GL_DEPTH_TEST);
  p->gl->ClearColor(0.0F, 0.0F, 0.0F, 0.0F);
  status = em_spheres_make(&p->spheres, p->gl, err);
  if (status == EM_OK)
    status = em_solids_make(&p->solids, p->gl, p->scene, !o->hide_rotor, !o->hide_drum, err);
  return status == EM_OK ? make_sheets(p, err) : status;
}

enum em_status em_picture_new(struct em_picture **picture, const struct em_scene *scene,
                              const struct em_picture_options *options, struct em_error *err) {
  *picture = NULL;
  if (options->smooth < 1 || options->smooth > 4 || options->width < 1 || options->height < 1 ||
      options->width > EM_CANVAS_LARGEST / 4 || options->height > EM_CANVAS_LARGEST / 4)
    return em_error_set(
        err, EM_INPUT, NULL, 0,
        "a picture of %d x %d pixels, %d samples each way: 1 to %d pixels and 1 to 4 "
        "samples are possible",
        options->width, options->height, options->smooth, EM_CANVAS_LARGEST / 4);
  const bool scaled = options->by == EM_PICTURE_SPEED || options->by == EM_PICTURE_SPIN;
  if (scaled && !(options->high > options->low && isfinite(options->high - options->low)))
    return em_error_set(err, EM_INPUT, NULL, 0,
                        "the scale of colours goes from %g to %g; it must rise", options->low,
                        options->high);
  struct em_picture *made = calloc(1, sizeof *made);
  if (made == NULL) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a picture");
  made->scene = scene;
  made->options = *options;
  em_colour_make(options->map, &made->map);
  const enum em_status status = make_layers(made, err);
  if (status != EM_OK) {
    em_picture_free(made);
    return status;
  }
  aim(made);
  *picture = made;
  return EM_OK;
}

static void paint(struct em_sphere *sphere, const uint8_t *rgb) {
  memcpy(sphere->rgba, rgb, 3);
  sphere->rgba[3] = 255;
}

static void paint_ball(const struct em_picture *p, const struct em_picture_state *state, size_t k,
                       double speed, struct em_sphere *sphere) {
  static const uint8_t plain[3] = {206, 208, 212}, unknown[3] = {190, 193, 198};
  const struct em_picture_options *o = &p->options;
  switch (o->by) {
  case EM_PICTURE_SPEED:
    paint(sphere, em_colour_at(&p->map, speed, o->low, o->high));
    break;
  case EM_PICTURE_SPIN:
    paint(sphere, em_colour_at(&p->map, em_vec_norm(state->balls->spin[k]), o->low, o->high));
    break;
  case EM_PICTURE_CLASS:
    paint(sphere, state->last != NULL && state->last[k] < EM_CLASS_COUNT
                      ? em_colour_cycle(state->last[k])
                      : unknown);
    break;
  case EM_PICTURE_SPECIES:
    paint(sphere, em_colour_cycle(state->balls->species[k]));
    break;
  case EM_PICTURE_PLAIN:
  case EM_PICTURE_KINDS:
  default:
    paint(sphere, plain);
  }
}

static bool make_room(struct em_picture *p, size_t count) {
  if (count <= p->sphere_room) return true;
  struct em_sphere *more = realloc(p->sphere, 2 * count * sizeof *more);
  if (more == NULL) return false;
  p->sphere = more;
  struct order *order = realloc(p->order, count * sizeof *order);
  if (order == NULL) return false;
  p->order = order;
  p->sphere_room = count;
  return true;
}

static void put(struct em_sphere *sphere, struct em_vec place, double radius) {
  *sphere = (struct em_sphere){
      .place = {(float)place.x, (float)place.y, (float)place.z},
      .radius = (float)radius,
  };
}

/* limit balls of count, evenly: is ball k one of them? */
static bool is_chosen(size_t k, size_t count, size_t limit) {
  if (limit == 0 || limit >= count) return true;
  const double share = (double)limit / (double)count;
  return (size_t)((double)(k + 1) * share + 1e-9) > (size_t)((double)k * share + 1e-9);
}

static void tally(struct em_picture *p, double value) {
  const double u = (value - p->options.low) / (p->options.high - p->options.low);
  const int k = u >= 1.0 ? EM_OVERLAY_BINS - 1 : u > 0.0 ? (int)(u * EM_OVERLAY_BINS) : 0;
  p->bin[k]++;
}

static bool is_number(struct em_vec v) {
  return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

/* Chooses, places and colours the balls that are shown, and counts all of them. */
static enum em_status collect(struct em_picture *p, const struct em_picture_state *state,
                              size_t *shown, struct em_error *err) {
  const struct em_picture_options *o = &p->options;
  const struct em_balls *balls = state->balls;
  size_t n = 0;
  memset(p->bin, 0, sizeof p->bin);
  for (size_t k = 0; k < balls->count; k++) {
    if (!is_number(balls->position[k]) || !is_number(balls->velocity[k]))
      return em_error_set(err, EM_INPUT, NULL, 0,
                          "ball %zu has no place or velocity that is a number", k);
    const double speed = em_vec_norm(balls->velocity[k]);
    if (o->by == EM_PICTURE_SPEED) tally(p, speed);
    if (o->by == EM_PICTURE_SPIN) tally(p, em_vec_norm(balls->spin[k]));
    if (o->hide_balls || !is_chosen(k, balls->count, o->limit)) continue;
    if (speed < o->show_low || (o->show_high > 0.0 && speed > o->show_high)) continue;
    put(&p->sphere[n], balls->position[k], balls->radius[k]);
    paint_ball(p, state, k, speed, &p->sphere[n]);
    n++;
  }
  *shown = n;
  return EM_OK;
}

static size_t add_beads(struct em_picture *p, const struct em_picture_state *state, size_t n) {
  for (size_t k = 0; k < state->bead_count; k++, n++) {
    put(&p->sphere[n], state->bead[k].place, state->bead[k].radius);
    paint(&p->sphere[n], state->bead[k].rgb);
    if (state->bead[k].disc) p->sphere[n].rgba[3] = 0;
  }
  return n;
}

static int farthest_first(const void *a, const void *b) {
  const float x = ((const struct order *)a)->distance, y = ((const struct order *)b)->distance;
  return (x < y) - (x > y);
}

/* Puts the spheres in order, farthest first, into the second half of their room. */
static const struct em_sphere *sort_by_distance(struct em_picture *p, size_t count) {
  const float *m = p->aim.view;
  for (size_t k = 0; k < count; k++) {
    const float *c = p->sphere[k].place;
    float eye[3];
    for (int a = 0; a < 3; a++)
      eye[a] = m[a] * c[0] + m[4 + a] * c[1] + m[8 + a] * c[2] + m[12 + a];
    const float d2 = eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2];
    p->order[k] = (struct order){p->aim.parallel ? -eye[2] : d2, (unsigned)k};
  }
  if (count > 0) qsort(p->order, count, sizeof *p->order, farthest_first);
  struct em_sphere *sorted = p->sphere + p->sphere_room;
  for (size_t k = 0; k < count; k++)
    sorted[k] = p->sphere[p->order[k].index];
  return sorted;
}

static enum em_status draw_machine_and_balls(struct em_picture *p,
                                             const struct em_picture_state *state,
                                             struct em_error *err) {
  size_t count = 0;
  if (!make_room(p, state->balls->count + state->bead_count))
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for %zu balls", state->balls->count);
  const enum em_status status = collect(p, state, &count, err);
  if (status != EM_OK) return status;
  if (!em_occlusion_fill(&p->occlusion, p->sphere, count))
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for %zu balls", count);
  count = add_beads(p, state, count);
  const struct em_sphere *sorted = sort_by_distance(p, count);
  p->gl = em_canvas_current(p->canvas, err);
  if (p->gl == NULL) return EM_PICTURE;
  p->gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  em_solids_draw_metal(&p->solids, p->gl, &p->aim, state->blade_angle);
  em_spheres_draw(&p->spheres, p->gl, &p->aim, sorted, count);
  em_solids_draw_glass(&p->solids, p->gl, &p->aim);
  return EM_OK;
}

/* Averages factor × factor samples into each pixel. */
static void shrink(const uint8_t *from, uint8_t *to, int width, int height, int factor) {
  const size_t row = 4 * (size_t)width * (size_t)factor, area = (size_t)factor * (size_t)factor;
  for (int y = 0; y < height; y++)
    for (int x = 0; x < width; x++, to += 4) {
      unsigned sum[4] = {0};
      for (int j = 0; j < factor; j++) {
        const uint8_t *s = from + (size_t)(y * factor + j) * row + 4 * (size_t)(x * factor);
        for (int i = 0; i < factor; i++, s += 4)
          for (int c = 0; c < 4; c++)
            sum[c] += s[c];
      }
      for (int c = 0; c < 4; c++)
        to[c] = (uint8_t)((sum[c] + area / 2) / area);
    }
}

/* a + b × weight / 256 for two bytes, each in its half of a word; at most 255. */
static uint32_t blend_two(uint32_t a, uint32_t b, uint32_t weight) {
  const uint32_t sum = (a & 0x00ff00ffU) + (((b & 0x00ff00ffU) * weight >> 8) & 0x00ff00ffU);
  const uint32_t over = sum & 0x01000100U;
  return (sum | (over - (over >> 8))) & 0x00ff00ffU;
}

/* One layer (premultiplied) over another; all B, G, R, A. */
static void compose(const uint8_t *over, const uint8_t *ground, uint8_t *sheet, size_t pixels) {
  for (size_t k = 0; k < 4 * pixels; k += 4) {
    uint32_t o, g;
    memcpy(&o, over + k, sizeof o);
    memcpy(&g, ground + k, sizeof g);
    const uint32_t alpha = o >> 24, weight = 256U - alpha - (alpha >> 7);
    g = blend_two(o, g, weight) | blend_two(o >> 8, g >> 8, weight) << 8;
    memcpy(sheet + k, &g, sizeof g);
  }
}

/* B, G, R, X to R, G, B, A. */
static void copy_out(const uint8_t *sheet, uint8_t *rgba, size_t pixels) {
  for (size_t k = 0; k < pixels; k++) {
    uint32_t v;
    memcpy(&v, sheet + 4 * k, sizeof v);
    v = 0xff000000U | (v & 0xff00U) | (v & 0xffU) << 16 | (v >> 16 & 0xffU);
    memcpy(rgba + 4 * k, &v, sizeof v);
  }
}

enum em_status em_picture_draw(struct em_picture *picture, const struct em_picture_state *state,
                               uint8_t *rgba, struct em_error *err) {
  const enum em_status status = draw_machine_and_balls(picture, state, err);
  if (status != EM_OK) return status;
  const struct em_picture_options *o = &picture->options;
  const size_t pixels = (size_t)o->width * (size_t)o->height;
  const uint8_t *drawn = em_canvas_read(picture->canvas);
  uint8_t *sheet = cairo_image_surface_get_data(picture->sheet);
  if (o->smooth > 1) {
    shrink(drawn, picture->small, o->width, o->height, o->smooth);
    drawn = picture->small;
  }
  compose(drawn, cairo_image_surface_get_data(picture->ground), sheet, pixels);
  compose(cairo_image_surface_get_data(picture->legend), sheet, sheet, pixels);
  cairo_surface_mark_dirty(picture->sheet);
  em_overlay_moment(picture->sheet, picture->scene, o, &picture->map, state,
                    o->histogram ? picture->bin : NULL);
  cairo_surface_flush(picture->sheet);
  copy_out(sheet, rgba, pixels);
  return EM_OK;
}

enum em_status em_picture_triple(struct em_picture *picture, const struct em_picture_state state[3],
                                 uint8_t *rgba, struct em_error *err) {
  const size_t pixels = (size_t)picture->options.width * (size_t)picture->options.height;
  uint8_t *one = calloc(pixels, 4);
  if (one == NULL) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for three pictures");
  enum em_status status = EM_OK;
  for (size_t c = 0; c < 3 && status == EM_OK; c++) {
    status = em_picture_draw(picture, &state[c], one, err);
    for (size_t k = 0; status == EM_OK && k < 4 * pixels; k += 4) {
      rgba[k + c] = (uint8_t)((54U * one[k] + 183U * one[k + 1] + 19U * one[k + 2]) >> 8);
      rgba[k + 3] = 255;
    }
  }
  free(one);
  return status;
}

const char *em_picture_renderer(const struct em_picture *picture) {
  return em_canvas_size(picture->canvas).renderer;
}

void em_picture_free(struct em_picture *picture) {
  if (picture == NULL) return;
  if (picture->gl != NULL && em_canvas_current(picture->canvas, NULL) != NULL) {
    em_solids_clear(&picture->solids, picture->gl);
    em_spheres_clear(&picture->spheres, picture->gl);
  }
  if (picture->ground != NULL) cairo_surface_destroy(picture->ground);
  if (picture->legend != NULL) cairo_surface_destroy(picture->legend);
  if (picture->sheet != NULL) cairo_surface_destroy(picture->sheet);
  em_canvas_free(picture->canvas);
  em_occlusion_clear(&picture->occlusion);
  free(picture->sphere);
  free(picture->order);
  free(picture->small);
  free(picture);
}
