/* The canvas, and spheres on it: silhouettes to the pixel, depths to the rounding of the shader. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "draw/canvas.h"
#include "draw/spheres.h"

enum { WIDTH = 320, HEIGHT = 200 };

static void a_canvas_is_drawn_on(void **state) {
  struct em_canvas *canvas;
  struct em_error err = {0};
  (void)state;
  assert_int_equal(em_canvas_new(&canvas, WIDTH, HEIGHT, &err), EM_OK);
  const struct em_gl *gl = em_canvas_current(canvas, &err);
  assert_non_null(gl);
  const struct em_canvas_size size = em_canvas_size(canvas);
  assert_int_equal(size.width, WIDTH);
  assert_int_equal(size.height, HEIGHT);
  assert_true(strlen(size.renderer) > 0);
  gl->ClearColor(1.0F, 0.5F, 0.0F, 1.0F);
  gl->Clear(GL_COLOR_BUFFER_BIT);
  const uint8_t *p = em_canvas_read(canvas);
  for (size_t k = 0; k < 4 * WIDTH * HEIGHT; k += 4) {
    assert_int_equal(p[k], 0); /* B, G, R, A */
    assert_in_range(p[k + 1], 127, 128);
    assert_int_equal(p[k + 2], 255);
    assert_int_equal(p[k + 3], 255);
  }
  em_canvas_free(canvas);
  em_canvas_free(NULL);
}

static void impossible_sizes_are_refused(void **state) {
  static const int bad[][2] = {{0, 10}, {10, 0}, {-1, 5}, {5, EM_CANVAS_LARGEST + 1}};
  (void)state;
  for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
    struct em_canvas *canvas;
    struct em_error err = {0};
    assert_int_equal(em_canvas_new(&canvas, bad[k][0], bad[k][1], &err), EM_INPUT);
    assert_null(canvas);
  }
}

/* Where the ray through a pixel's middle meets the sphere: its depth, or NAN when it misses; *miss:
 * how far the ray passes from the silhouette, in radii. All in double precision, by another formula
 * than the shader's. */
static double ray_depth(const struct em_camera_aim *aim, const struct em_sphere *s, int x, int y,
                        double *miss) {
  const float *v = aim->view, *q = aim->projection;
  double c[3];
  for (int k = 0; k < 3; k++)
    c[k] = (double)v[k] * (double)s->place[0] + (double)v[4 + k] * (double)s->place[1] +
           (double)v[8 + k] * (double)s->place[2] + (double)v[12 + k];
  const double r = (double)s->radius;
  const double nx = 2.0 * (x + 0.5) / aim->width - 1.0, ny = 1.0 - 2.0 * (y + 0.5) / aim->height;
  double o[3] = {0, 0, 0}, d[3] = {0, 0, -1};
  if (aim->parallel) {
    o[0] = (nx - (double)q[12]) / (double)q[0];
    o[1] = (ny - (double)q[13]) / (double)q[5];
  } else {
    d[0] = (nx + (double)q[8]) / (double)q[0];
    d[1] = (ny + (double)q[9]) / (double)q[5];
    const double l = sqrt(d[0] * d[0] + d[1] * d[1] + 1.0);
    for (int k = 0; k < 3; k++)
      d[k] /= l;
  }
  double along = 0.0, away2 = 0.0;
  for (int k = 0; k < 3; k++)
    along += (c[k] - o[k]) * d[k];
  for (int k = 0; k < 3; k++) {
    const double a = c[k] - o[k] - along * d[k];
    away2 += a * a;
  }
  *miss = sqrt(away2) / r - 1.0;
  if (away2 > r * r) return NAN;
  const double z = o[2] + (along - sqrt(r * r - away2)) * d[2];
  const double w = aim->parallel ? 1.0 : -z;
  return 0.5 + 0.5 * ((double)q[10] * z + (double)q[14]) / w;
}

/* Where a point appears: pixels from the picture's left. */
static double across(const struct em_camera_aim *aim, struct em_vec p) {
  const float *v = aim->view, *q = aim->projection;
  double eye[3];
  for (int k = 0; k < 3; k++)
    eye[k] =
        (double)v[k] * p.x + (double)v[4 + k] * p.y + (double)v[8 + k] * p.z + (double)v[12 + k];
  const double x = (double)q[0] * eye[0] + (double)q[8] * eye[2] + (double)q[12];
  const double w = (double)q[11] * eye[2] + (double)q[15];
  return 0.5 * aim->width * (1.0 + x / w);
}

static void check_sphere(double fov, struct em_vec place, double radius) {
  struct em_canvas *canvas;
  struct em_error err = {0};
  struct em_spheres spheres;
  struct em_camera_aim aim;
  struct em_camera camera = em_camera_make(EM_CAMERA_THREE_QUARTER);
  camera.fov = fov;
  camera.right = 0.2;
  const struct em_vec low = {-0.1, -0.1, -0.1}, high = {0.1, 0.1, 0.1}, point[] = {low, high};
  em_camera_aim(&camera, low, high, point, 2, WIDTH, HEIGHT, &aim);
  assert_int_equal(em_canvas_new(&canvas, WIDTH, HEIGHT, &err), EM_OK);
  const struct em_gl *gl = em_canvas_current(canvas, &err);
  assert_int_equal(em_spheres_make(&spheres, gl, &err), EM_OK);
  const struct em_sphere s = {.place = {(float)place.x, (float)place.y, (float)place.z},
                              .radius = (float)radius,
                              .rgba = {200, 200, 200, 255}};
  gl->Viewport(0, 0, WIDTH, HEIGHT);
  gl->Enable(GL_DEPTH_TEST);
  gl->ClearColor(0, 0, 0, 0);
  gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  em_spheres_draw(&spheres, gl, &aim, &s, 1);
  float *depth = malloc(WIDTH * HEIGHT * sizeof *depth);
  gl->ReadPixels(0, 0, WIDTH, HEIGHT, GL_DEPTH_COMPONENT, GL_FLOAT, depth);
  const uint8_t *pixel = em_canvas_read(canvas);
  const struct em_vec right = {(double)aim.view[0], (double)aim.view[4], 0.0};
  const double pixels = /* the radius, roughly */
      across(&aim, em_vec_axpy(place, radius, right)) - across(&aim, place);
  assert_true(pixels > 8.0);
  int covered = 0;
  for (int py = 0; py < HEIGHT; py++)
    for (int px = 0; px < WIDTH; px++) {
      double miss;
      const double want = ray_depth(&aim, &s, px, py, &miss);
      const int alpha = pixel[4 * (py * WIDTH + px) + 3];
      const double got = (double)depth[(HEIGHT - 1 - py) * WIDTH + px];
      if (miss * pixels > 0.75) assert_int_equal(alpha, 0);
      if (miss * pixels < -0.75) {
        assert_int_equal(alpha, 255);
        assert_true(fabs(got - want) < 3e-6);
        covered++;
      }
    }
  assert_true(covered > 0.8 * M_PI * (pixels - 1) * (pixels - 1));
  free(depth);
  em_spheres_clear(&spheres, gl);
  em_canvas_free(canvas);
}

static void spheres_are_exact(void **state) {
  (void)state;
  for (int parallel = 0; parallel < 2; parallel++) {
    const double fov = parallel ? 0.0 : 0.6;
    check_sphere(fov, em_vec_make(0, 0, 0), 0.03);
    check_sphere(fov, em_vec_make(0.06, -0.05, 0.04), 0.02);
    check_sphere(fov, em_vec_make(-0.05, 0.06, -0.06), 0.025);
  }
}

/* Smaller than a pixel, wherever between pixels' middles. */
static void the_smallest_spheres_are_seen(void **state) {
  const struct em_vec low = {-0.1, -0.1, -0.1}, high = {0.1, 0.1, 0.1}, point[] = {low, high};
  struct em_canvas *canvas;
  struct em_error err = {0};
  struct em_spheres spheres;
  (void)state;
  assert_int_equal(em_canvas_new(&canvas, WIDTH, HEIGHT, &err), EM_OK);
  const struct em_gl *gl = em_canvas_current(canvas, &err);
  assert_int_equal(em_spheres_make(&spheres, gl, &err), EM_OK);
  gl->Viewport(0, 0, WIDTH, HEIGHT);
  gl->Enable(GL_DEPTH_TEST);
  gl->ClearColor(0, 0, 0, 0);
  for (int k = 0; k < 200; k++) {
    struct em_camera camera = em_camera_make(EM_CAMERA_THREE_QUARTER);
    struct em_camera_aim aim;
    if (k % 2) camera.fov = 0.0;
    em_camera_aim(&camera, low, high, point, 2, WIDTH, HEIGHT, &aim);
    const float u = (float)fmod(0.0618 * k, 0.08), v = (float)fmod(0.0414 * k, 0.08);
    const struct em_sphere s = {.place = {u - 0.04F, v - 0.04F, 0.04F - u},
                                .radius = 1e-4F, /* a pixel is about 1e-3 */
                                .rgba = {200, 200, 200, 255}};
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    em_spheres_draw(&spheres, gl, &aim, &s, 1);
    const uint8_t *pixel = em_canvas_read(canvas);
    int alpha = 0;
    for (size_t n = 3; n < 4 * WIDTH * HEIGHT; n += 4)
      alpha += pixel[n];
    assert_true(alpha > 230 && alpha < 320); /* about one pixel */
  }
  em_spheres_clear(&spheres, gl);
  em_canvas_free(canvas);
}

/* The near one hides the far one, whichever is drawn first. */
static void the_nearer_sphere_is_seen(void **state) {
  (void)state;
  for (int order = 0; order < 2; order++) {
    struct em_canvas *canvas;
    struct em_error err = {0};
    struct em_spheres spheres;
    struct em_camera_aim aim;
    const struct em_camera camera = em_camera_make(EM_CAMERA_AXIAL); /* looks along +y */
    const struct em_vec low = {-0.1, -0.1, -0.1}, high = {0.1, 0.1, 0.1}, point[] = {low, high};
    em_camera_aim(&camera, low, high, point, 2, WIDTH, HEIGHT, &aim);
    assert_int_equal(em_canvas_new(&canvas, WIDTH, HEIGHT, &err), EM_OK);
    const struct em_gl *gl = em_canvas_current(canvas, &err);
    assert_int_equal(em_spheres_make(&spheres, gl, &err), EM_OK);
    struct em_sphere s[2] = {{.place = {0, -0.05F, 0}, .radius = 0.02F, .rgba = {255, 0, 0, 255}},
                             {.place = {0, 0.05F, 0}, .radius = 0.02F, .rgba = {0, 0, 255, 255}}};
    if (order) {
      const struct em_sphere swap = s[0];
      s[0] = s[1];
      s[1] = swap;
    }
    gl->Viewport(0, 0, WIDTH, HEIGHT);
    gl->Enable(GL_DEPTH_TEST);
    gl->ClearColor(0, 0, 0, 0);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    em_spheres_draw(&spheres, gl, &aim, s, 2);
    const uint8_t *p = em_canvas_read(canvas) + 4 * (HEIGHT / 2 * WIDTH + WIDTH / 2);
    assert_true(p[2] > p[0] + 80); /* red, not blue */
    em_spheres_clear(&spheres, gl);
    em_canvas_free(canvas);
  }
}

/* Neighbours beyond two diameters take no light, however wide the scene is. */
static void only_neighbours_take_light(void **state) {
  struct em_sphere s[] = {{.place = {0, 0, 0}, .radius = 1e-3F},
                          {.place = {0.0041F, 0, 0}, .radius = 1e-3F},
                          {.place = {1, 1, 0}, .radius = 1e-3F},
                          {.place = {1, 1, 0.0039F}, .radius = 1e-3F}};
  struct em_occlusion space = {0};
  (void)state;
  assert_true(em_occlusion_fill(&space, s, 4));
  for (int k = 0; k < 4; k++) {
    const double share = k < 2 ? 0.0 : 0.25 / (3.9 * 3.9);
    assert_true(fabs((double)s[k].occlusion[3] - share) < 1e-6);
    assert_true(fabs((double)s[k].occlusion[2] - (k == 2 ? 2.0 : -2.0) * share) < 1e-6);
  }
  em_occlusion_clear(&space);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_canvas_is_drawn_on),
      cmocka_unit_test(only_neighbours_take_light),
      cmocka_unit_test(impossible_sizes_are_refused),
      cmocka_unit_test(the_smallest_spheres_are_seen),
      cmocka_unit_test(spheres_are_exact),
      cmocka_unit_test(the_nearer_sphere_is_seen),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
