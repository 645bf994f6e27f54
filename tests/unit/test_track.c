/* Films of a ball that hits a plate, drawn by the renderer, spoilt as a camera spoils them (uneven
 * light that flickers, stripes, noise, a plate in the picture), and measured: restitution within
 * 1 %, and errors that are as large as they say. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "draw/canvas.h"
#include "draw/spheres.h"
#include "draw/track_bounce.h"
#include "eventmill/picture.h"
#include "eventmill/track.h"

/* A shot: the ball's centre goes along a parabola, and comes back from the plate. */
struct shot {
  int width, height, frames;
  double fps, pixel;      /* 1/s; m per pixel */
  double radius;          /* m */
  double speed, e, slide; /* m/s towards the plate, restitution, m/s along it */
  double gravity;         /* m/s² towards the plate */
  double impact;          /* s */
  enum em_track_plate plate;
  double noise, flicker; /* grey values; relative */
  double ground;         /* grey value at its brightest. 0: 210 */
  uint8_t red, green, blue;
  int hidden, shown; /* frames from the one to before the other are without the ball */
};

struct studio {
  struct em_canvas *canvas;
  const struct em_gl *gl;
  struct em_spheres spheres;
  struct em_camera_aim aim;
  uint32_t random;
};

static double uniform(struct studio *s) {
  s->random = s->random * 1664525U + 1013904223U;
  return (s->random >> 8) / 16777216.0;
}

static double normal(struct studio *s) {
  return sqrt(-2.0 * log(1.0 - uniform(s))) * cos(2.0 * M_PI * uniform(s));
}

/* Parallel light; pixel (0, 0) is the top left one, lengths in m, y upwards. */
static void open_studio(struct studio *s, const struct shot *shot) {
  struct em_error err;
  memset(s, 0, sizeof *s);
  s->random = 7;
  assert_int_equal(em_canvas_new(&s->canvas, shot->width, shot->height, &err), EM_OK);
  assert_non_null(s->gl = em_canvas_current(s->canvas, &err));
  assert_int_equal(em_spheres_make(&s->spheres, s->gl, &err), EM_OK);
  for (int k = 0; k < 4; k++)
    s->aim.view[5 * k] = 1.0F;
  s->aim.projection[0] = (float)(2.0 / (shot->width * shot->pixel));
  s->aim.projection[5] = (float)(2.0 / (shot->height * shot->pixel));
  s->aim.projection[10] = -1.0F;
  s->aim.projection[14] = -1.0F;
  s->aim.projection[15] = 1.0F;
  s->aim.width = shot->width;
  s->aim.height = shot->height;
  s->aim.parallel = true;
  s->gl->Viewport(0, 0, shot->width, shot->height);
}

static void close_studio(struct studio *s) {
  em_spheres_clear(&s->spheres, s->gl);
  em_canvas_free(s->canvas);
}

/* Distance of the ball from the plate, and place along it, at a time. */
static void place_at(const struct shot *shot, double time, double *gap, double *along) {
  const double t = time - shot->impact;
  *gap = t < 0.0 ? -shot->speed * t - 0.5 * shot->gravity * t * t
                 : shot->e * shot->speed * t - 0.5 * shot->gravity * t * t;
  *along = shot->slide * t;
}

/* The ground: light that falls off to the corners, fixed stripes, the plate. */
static double light_at(const struct shot *shot, int x, int y) {
  const double u = (x - 0.4 * shot->width) / shot->width,
               v = (y - 0.6 * shot->height) / shot->height;
  const bool at_plate = shot->plate == EM_TRACK_RIGHT    ? x >= shot->width - 24
                        : shot->plate == EM_TRACK_LEFT   ? x < 24
                        : shot->plate == EM_TRACK_BOTTOM ? y >= shot->height - 24
                                                         : y < 24;
  const double brightest = shot->ground > 0.0 ? shot->ground / 210.0 : 1.0;
  return brightest * (210.0 - 160.0 * (u * u + v * v) + 4.0 * sin(1.7 * x)) *
         (at_plate ? 0.35 : 1.0);
}

static void spoil(struct studio *s, const struct shot *shot, double gain, const uint8_t *bgra,
                  uint8_t *rgba) {
  for (int y = 0; y < shot->height; y++)
    for (int x = 0; x < shot->width; x++) {
      const size_t p = 4 * ((size_t)y * (size_t)shot->width + (size_t)x);
      const double ground = light_at(shot, x, y) * (1.0 - bgra[p + 3] / 255.0);
      const double noise = shot->noise > 0.0 ? shot->noise * normal(s) : 0.0;
      for (size_t c = 0; c < 3; c++) {
        const double value = gain * (ground + bgra[p + 2 - c]) + noise;
        rgba[p + c] = (uint8_t)lround(fmin(fmax(value, 0.0), 255.0));
      }
      rgba[p + 3] = 255;
    }
}

static void draw_ball(struct studio *s, const struct shot *shot, double time) {
  double gap, along;
  place_at(shot, time, &gap, &along);
  const double half_w = 0.5 * shot->width * shot->pixel, half_h = 0.5 * shot->height * shot->pixel;
  const double face = 24.0 * shot->pixel + shot->radius;
  const bool level = shot->plate == EM_TRACK_LEFT || shot->plate == EM_TRACK_RIGHT;
  const double away = (level ? half_w : half_h) - face - gap;
  const double sign = shot->plate == EM_TRACK_RIGHT || shot->plate == EM_TRACK_TOP ? 1.0 : -1.0;
  const struct em_sphere ball = {
      .place = {(float)(level ? sign * away : along), (float)(level ? along : sign * away), -1.0F},
      .radius = (float)shot->radius,
      .rgba = {shot->red, shot->green, shot->blue, 255},
  };
  s->gl->ClearColor(0.0F, 0.0F, 0.0F, 0.0F);
  s->gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  em_spheres_draw(&s->spheres, s->gl, &s->aim, &ball, 1);
}

static void film(const struct shot *shot, const char *folder) {
  struct studio s;
  char path[300];
  open_studio(&s, shot);
  uint8_t *rgba = malloc(4 * (size_t)shot->width * (size_t)shot->height);
  assert_non_null(rgba);
  assert_int_equal(mkdir(folder, 0700), 0);
  for (int k = 0; k < shot->frames; k++) {
    struct em_error err;
    const bool hidden = k >= shot->hidden && k < shot->shown;
    draw_ball(&s, shot, hidden ? -1e3 : k / shot->fps);
    const double gain = 1.0 + shot->flicker * sin(2.0 * M_PI * 100.0 * k / shot->fps);
    spoil(&s, shot, gain, em_canvas_read(s.canvas), rgba);
    snprintf(path, sizeof path, "%s/frame-%d.png", folder, k);
    assert_int_equal(em_picture_save(path, rgba, shot->width, shot->height, &err), EM_OK);
  }
  free(rgba);
  close_studio(&s);
}

static void clean(const char *folder, int frames) {
  char path[300];
  for (int k = 0; k < frames; k++) {
    snprintf(path, sizeof path, "%s/frame-%d.png", folder, k);
    unlink(path);
  }
  rmdir(folder);
}

static char folder_name[64];

static struct em_track *measure(const struct shot *shot, const struct em_track_options *o) {
  struct em_track *track = NULL;
  struct em_error err = {.code = EM_OK};
  snprintf(folder_name, sizeof folder_name, "/tmp/em-track-%ld", (long)getpid());
  film(shot, folder_name);
  const enum em_status status = em_track_folder(&track, folder_name, o, &err);
  clean(folder_name, shot->frames);
  if (status != EM_OK) print_error("%s\n", err.text);
  assert_int_equal(status, EM_OK);
  return track;
}

static void near(double value, double truth, double tolerance, const char *what) {
  if (fabs(value - truth) <= tolerance) return;
  print_error("%s: %.9g, expected %.9g within %.3g\n", what, value, truth, tolerance);
  fail();
}

/* Restitution and speeds within `relative`, and within four standard errors plus 0.1 %. */
static void check(const struct em_track *t, const struct shot *shot, double relative) {
  const double v = shot->speed, e = shot->e;
  assert_int_equal(t->plate, shot->plate);
  near(t->restitution.value, e, relative * e, "restitution");
  near(t->restitution.value, e, 4.0 * t->restitution.error + 1e-3 * e, "restitution, by its error");
  near(t->approach.value, v, relative * v, "approach");
  near(t->departure.value, e * v, relative * e * v, "departure");
  near(t->impact, shot->impact, 0.1 / shot->fps, "impact");
  assert_true(t->restitution.error > 0.0 && t->restitution.error < 0.01);
  assert_true(t->sigma < 0.3);
}

/* 24 m/s at a steel plate on the right. */
static const struct shot fast = {
    .width = 480,
    .height = 96,
    .frames = 64,
    .fps = 20000,
    .pixel = 1e-4,
    .radius = 2.5e-3,
    .speed = 24.0,
    .e = 0.55,
    .slide = 0.6,
    .impact = 0.0012,
    .plate = EM_TRACK_RIGHT,
    .noise = 4.0,
    .flicker = 0.06,
    .red = 70,
    .green = 70,
    .blue = 74,
};

/* A drop from a small height onto a plate below. */
static const struct shot drop = {
    .width = 96,
    .height = 320,
    .frames = 70,
    .fps = 1000,
    .pixel = 1.2e-4,
    .radius = 2.5e-3,
    .speed = 0.9,
    .e = 0.86,
    .slide = 0.02,
    .gravity = 9.81,
    .impact = 0.0342,
    .plate = EM_TRACK_BOTTOM,
    .noise = 4.0,
    .flicker = 0.06,
    .red = 70,
    .green = 70,
    .blue = 74,
};

static void test_fast_shot(void **state) {
  (void)state;
  const struct em_track_options o = {.fps = fast.fps, .scale = fast.pixel};
  struct em_track *t = measure(&fast, &o);
  check(t, &fast, 0.01);
  near(t->radius.value, 25.0, 0.25, "radius");
  near(fabs(t->tangent_before.value), fast.slide, 0.05, "speed along the plate");
  for (size_t k = 0; k < t->count; k++)
    near(t->spot[k].roundness, 1.0, 0.05, "roundness");
  assert_true(t->before >= 20 && t->after >= 30);
  em_track_free(t);
}

static void test_drop(void **state) {
  (void)state;
  const struct em_track_options o = {.fps = drop.fps, .diameter = 2.0 * drop.radius};
  struct em_track *t = measure(&drop, &o);
  check(t, &drop, 0.012);
  near(t->restitution.value, drop.e, 0.01 * drop.e, "restitution");
  near(t->gravity, 9.81, 1.0, "gravity");
  em_track_free(t);
}

/* Balls that are shaded, or stand out in one colour alone, on light and on dark grounds, with and
 * without noise, at both ends of the smoothing: found in each frame, radius and speed to 1 %. */
static void test_looks(void **state) {
  (void)state;
  static const struct {
    double ground, noise, smoothing;
    uint8_t red, green, blue;
  } look[] = {
      {245.0, 0.0, 1.0, 205, 205, 205}, {245.0, 4.0, 3.0, 205, 205, 205},
      {245.0, 4.0, 0.5, 245, 230, 40},  {30.0, 0.0, 3.0, 190, 190, 190},
      {30.0, 3.0, 1.0, 190, 190, 190},  {30.0, 0.0, 0.5, 245, 230, 40},
  };
  for (size_t k = 0; k < sizeof look / sizeof *look; k++) {
    struct shot shot = drop;
    shot.pixel = 2.5e-3 / 9.4;
    shot.height = 160;
    shot.fps = 500;
    shot.frames = 35;
    shot.ground = look[k].ground;
    shot.noise = look[k].noise;
    shot.flicker = 0.01;
    shot.red = look[k].red, shot.green = look[k].green, shot.blue = look[k].blue;
    const struct em_track_options o = {
        .fps = shot.fps, .diameter = 2.0 * shot.radius, .smoothing = look[k].smoothing};
    struct em_track *t = measure(&shot, &o);
    assert_int_equal(t->count, shot.frames);
    assert_int_equal(t->lost, 0);
    check(t, &shot, 0.01);
    near(t->radius.value, 9.4, 0.07, "radius");
    near(t->radius.value, 9.4, 3.0 * t->radius.error, "radius, by its error");
    near(t->approach.value, shot.speed, 3.0 * t->approach.error, "approach, by its error");
    em_track_free(t);
  }
}

/* Frames that lack the ball are counted; too many about the impact, and nothing is measured. */
static void test_lost_frames(void **state) {
  (void)state;
  struct em_track *t;
  struct em_error err = {.code = EM_OK};
  struct shot shot = drop;
  shot.pixel *= 2.0;
  shot.height = 160;
  const struct em_track_options o = {.fps = shot.fps, .scale = shot.pixel};
  shot.hidden = 32, shot.shown = 37;
  t = measure(&shot, &o);
  assert_int_equal(t->lost, 5);
  assert_int_equal(t->count, shot.frames - 5);
  check(t, &shot, 0.012);
  em_track_free(t);
  shot.hidden = 10, shot.shown = 60;
  film(&shot, folder_name);
  assert_int_equal(em_track_folder(&t, folder_name, &o, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "lost in the 50 frames about the impact, from 10 to 59"));
  clean(folder_name, shot.frames);
}

/* From all four sides, at several restitutions. */
static void test_sides(void **state) {
  (void)state;
  static const enum em_track_plate side[] = {EM_TRACK_LEFT, EM_TRACK_TOP};
  for (int k = 0; k < 2; k++) {
    struct shot shot = fast;
    shot.plate = side[k];
    shot.e = 0.4 + 0.5 * k;
    if (side[k] == EM_TRACK_TOP) {
      shot.width = 96;
      shot.height = 480;
    }
    const struct em_track_options o = {.fps = shot.fps, .scale = shot.pixel};
    struct em_track *t = measure(&shot, &o);
    check(t, &shot, 0.01);
    em_track_free(t);
  }
}

/* The wrong side is no plate, an empty folder no film, a ball that flies by no impact. */
static void test_bad_films(void **state) {
  (void)state;
  struct em_track_options o = {.fps = fast.fps, .scale = fast.pixel, .plate = EM_TRACK_LEFT};
  struct em_track *t = NULL;
  struct em_error err = {.code = EM_OK};
  struct shot shot = fast;
  snprintf(folder_name, sizeof folder_name, "/tmp/em-track-%ld", (long)getpid());
  assert_int_equal(em_track_folder(&t, "/nowhere", &o, &err), EM_FILE);
  assert_int_equal(mkdir(folder_name, 0700), 0);
  assert_int_equal(em_track_folder(&t, folder_name, &o, &err), EM_INPUT);
  rmdir(folder_name);
  film(&shot, folder_name);
  assert_int_equal(em_track_folder(&t, folder_name, &o, &err), EM_INPUT);
  assert_null(t);
  o.smoothing = 3.5;
  assert_int_equal(em_track_folder(&t, folder_name, &o, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "0.5 to 3 are possible"));
  o.smoothing = 0.0;
  o.fps = 0.0;
  assert_int_equal(em_track_folder(&t, folder_name, &o, &err), EM_INPUT);
  clean(folder_name, shot.frames);
  shot.frames = 20; /* it is not there yet */
  o = (struct em_track_options){.fps = fast.fps, .scale = fast.pixel};
  film(&shot, folder_name);
  assert_int_equal(em_track_folder(&t, folder_name, &o, &err), EM_INPUT);
  clean(folder_name, shot.frames);
}

/* Places on straight lines, without a film: from (2, 3) m/s to what the plate makes of it. */
static enum em_status bounce(struct em_track *track, double turn_x, double turn_y,
                             struct em_error *err) {
  enum { FRAMES = 20, IMPACT = 9 };
  static struct em_track_spot spot[FRAMES];
  for (size_t k = 0; k < FRAMES; k++) {
    const double t = (double)k - IMPACT - 0.5;
    spot[k] = (struct em_track_spot){.frame = k,
                                     .x = 50.0 + (t < 0.0 ? 2.0 : 2.0 * turn_x) * t,
                                     .y = 50.0 + (t < 0.0 ? 3.0 : 3.0 * turn_y) * t};
  }
  *track = (struct em_track){.frames = FRAMES, .count = FRAMES, .spot = spot, .scale = {1.0, 0.0}};
  return em_track_bounce(track, 1.0, EM_TRACK_AUTO, "a-film", err);
}

/* Four frames on a side do not tell gravity, and the errors say what it may have done; an error of
 * the scale is one of the speeds, not of their ratio. */
static void test_errors(void **state) {
  (void)state;
  enum { FRAMES = 8 };
  struct em_track_spot spot[FRAMES];
  struct em_error err = {.code = EM_OK};
  for (size_t k = 0; k < FRAMES; k++) {
    const double t = ((double)k - 3.5) / 100.0;
    spot[k] = (struct em_track_spot){.frame = k,
                                     .x = 1e3 * ((t < 0.0 ? 1.0 : -0.8) * t + 0.5 * 9.81 * t * t)};
  }
  struct em_track track = {.frames = FRAMES, .count = FRAMES, .spot = spot, .scale = {1e-3, 0.0}};
  assert_int_equal(em_track_bounce(&track, 100.0, EM_TRACK_RIGHT, "a-film", &err), EM_OK);
  near(track.restitution.value, 0.8, 2.0 * track.restitution.error, "restitution");
  near(track.approach.value, 1.0, 2.0 * track.approach.error, "approach");
  near(track.departure.value, 0.8, 2.0 * track.departure.error, "departure");
  const double alone = track.approach.error, ratio = track.restitution.error;
  track.scale.error = 3e-4;
  assert_int_equal(em_track_bounce(&track, 100.0, EM_TRACK_RIGHT, "a-film", &err), EM_OK);
  near(track.approach.error, hypot(alone, 0.3 * track.approach.value), 1e-9, "error of the speed");
  near(track.restitution.error, ratio, 1e-12, "error of the ratio");
  for (size_t k = 0; k < 2; k++)
    spot[k].x -= 30.0; /* as if frames were missing */
  assert_int_equal(em_track_bounce(&track, 100.0, EM_TRACK_RIGHT, "a-film", &err), EM_INPUT);
  assert_non_null(strstr(err.text, "about two parabolas"));
}

/* The plate is where the coordinate that comes back was going, whatever the other one does. */
static void test_plate(void **state) {
  (void)state;
  struct em_track track;
  struct em_error err = {.code = EM_OK};
  assert_int_equal(bounce(&track, -0.8, 1.0, &err), EM_OK);
  assert_int_equal(track.plate, EM_TRACK_RIGHT);
  near(track.restitution.value, 0.8, 1e-9, "restitution in x");
  assert_int_equal(bounce(&track, 1.0, -0.8, &err), EM_OK);
  assert_int_equal(track.plate, EM_TRACK_BOTTOM);
  near(track.restitution.value, 0.8, 1e-9, "restitution in y");
  assert_int_equal(bounce(&track, -0.9, -0.9, &err), EM_OK);
  assert_int_equal(track.plate, EM_TRACK_BOTTOM); /* the larger change */
  assert_int_equal(bounce(&track, 1.0, -1.6, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "a-film: error: no impact on a plate"));
  assert_int_equal(bounce(&track, 1.0, 1.0, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "a-film: error: the ball does not come back"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_fast_shot),   cmocka_unit_test(test_drop),
      cmocka_unit_test(test_sides),       cmocka_unit_test(test_bad_films),
      cmocka_unit_test(test_plate),       cmocka_unit_test(test_looks),
      cmocka_unit_test(test_lost_frames), cmocka_unit_test(test_errors),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
