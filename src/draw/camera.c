/* The camera: looks at a box from a direction, as near as all of it can be seen. */
#include "eventmill/camera.h"

#include <string.h>

const char *em_camera_name(enum em_camera_view view) {
#define NAME(code, text) text,
  static const char *const name[] = {EM_CAMERA_LIST(NAME)};
#undef NAME
  return (unsigned)view < EM_CAMERA_VIEWS ? name[view] : "?";
}

int em_camera_find(const char *name) {
  for (int k = 0; k < EM_CAMERA_VIEWS; k++)
    if (strcmp(name, em_camera_name((enum em_camera_view)k)) == 0) return k;
  return -1;
}

struct em_camera em_camera_make(enum em_camera_view view) {
  static const double degree = M_PI / 180.0;
  struct em_camera camera = {.fov = 28.0 * degree, .zoom = 1.0};
  if (view == EM_CAMERA_SIDE) camera.azimuth = 90.0 * degree;
  if (view == EM_CAMERA_THREE_QUARTER) {
    camera.azimuth = 38.0 * degree;
    camera.elevation = 18.0 * degree;
  }
  return camera;
}

/* The eye's three directions: right, up, and back (from the scene to the eye). */
struct frame {
  struct em_vec right, up, back;
};

static struct frame frame_at(double azimuth, double elevation) {
  const double ca = cos(azimuth), sa = sin(azimuth), ce = cos(elevation), se = sin(elevation);
  return (struct frame){
      .right = {ca, sa, 0.0},
      .up = {-se * sa, se * ca, ce},
      .back = {ce * sa, -ce * ca, se},
  };
}

/* Half width and half height, in units of the distance, of the part of the picture that may be
 * used. */
struct window {
  double x, y;
};

/* The distance (perspective) or half height (parallel) at which all points are inside. */
static double fit(const struct frame *f, struct em_vec middle, const struct em_vec *point,
                  size_t count, struct window window, bool parallel) {
  double need = 0.0;
  for (size_t k = 0; k < count; k++) {
    const struct em_vec p = em_vec_sub(point[k], middle);
    const double x = fabs(em_vec_dot(p, f->right)), y = fabs(em_vec_dot(p, f->up));
    const double across = fmax(x / window.x, y / window.y);
    need = fmax(need, parallel ? across : across + em_vec_dot(p, f->back));
  }
  return need;
}

static void fill_view(struct em_camera_aim *aim, const struct frame *f, struct em_vec eye) {
  const struct em_vec row[3] = {f->right, f->up, f->back};
  for (int k = 0; k < 3; k++) {
    aim->view[k] = (float)row[k].x;
    aim->view[4 + k] = (float)row[k].y;
    aim->view[8 + k] = (float)row[k].z;
    aim->view[12 + k] = (float)-em_vec_dot(row[k], eye);
  }
  aim->view[15] = 1.0F;
}

void em_camera_aim(const struct em_camera *camera, struct em_vec low, struct em_vec high,
                   const struct em_vec *point, size_t count, int width, int height,
                   struct em_camera_aim *aim) {
  memset(aim, 0, sizeof *aim);
  aim->width = width;
  aim->height = height;
  aim->parallel = camera->fov <= 0.0;
  const double aspect = (double)width / (double)height;
  const double half = aim->parallel ? 1.0 : tan(0.5 * camera->fov);
  const double free_x = fmax(0.05, 1.0 - camera->left - camera->right);
  const double free_y = fmax(0.05, 1.0 - camera->top - camera->bottom);
  const struct window window = {half * aspect * free_x, half * free_y};
  const struct em_vec middle = em_vec_scale(0.5, em_vec_add(low, high));
  const double radius = 0.5 * em_vec_norm(em_vec_sub(high, low));
  struct frame f = frame_at(camera->azimuth, camera->elevation);
  double need = fit(&f, middle, point, count, window, aim->parallel);
  for (int k = 0; camera->orbits && k < 72; k++) {
    const struct frame other = frame_at(2.0 * M_PI * k / 72, camera->elevation);
    need = fmax(need, fit(&other, middle, point, count, window, aim->parallel));
  }
  /* Perspective: nearness magnifies; the lens does the rest, so that zoom never goes inside. */
  const double distance = aim->parallel ? 3.0 * radius : need;
  const double lens = (aim->parallel ? 1.0 / need : 1.0 / half) * camera->zoom;
  const double near = fmax(0.02 * distance, distance - 1.5 * radius);
  const double far = distance + 1.5 * radius;
  fill_view(aim, &f, em_vec_axpy(middle, distance, f.back));
  const double shift_x = camera->left - camera->right, shift_y = camera->bottom - camera->top;
  float *const p = aim->projection;
  p[0] = (float)(lens / aspect);
  p[5] = (float)lens;
  if (aim->parallel) {
    p[10] = (float)(-2.0 / (far - near));
    p[12] = (float)shift_x;
    p[13] = (float)shift_y;
    p[14] = (float)(-(far + near) / (far - near));
    p[15] = 1.0F;
  } else {
    p[8] = (float)-shift_x;
    p[9] = (float)-shift_y;
    p[10] = (float)(-(far + near) / (far - near));
    p[11] = -1.0F;
    p[14] = (float)(-2.0 * far * near / (far - near));
  }
}
