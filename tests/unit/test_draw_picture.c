/* Pictures of a mill, and the paths between the frames of a run. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "draw_mill.h"
#include "eventmill/motion.h"
#include "eventmill/recorder.h"
#include "eventmill/show.h"

enum { WIDTH = 320, HEIGHT = 180, BYTES = 4 * WIDTH * HEIGHT };

static struct em_picture_options options_for(const struct em_scene *scene,
                                             const struct em_balls *balls) {
  struct em_picture_options o = em_picture_default(scene, balls);
  o.width = WIDTH;
  o.height = HEIGHT;
  return o;
}

static void draw(const struct em_scene *scene, const struct em_picture_options *o,
                 const struct em_balls *balls, uint8_t *rgba) {
  static const double angle[] = {0.3, 1.2};
  struct em_picture *picture;
  struct em_error err = {0};
  const struct em_picture_state state = {.balls = balls, .time = 0.5, .blade_angle = angle};
  if (em_picture_new(&picture, scene, o, &err) != EM_OK) fail_msg("%s", err.text);
  assert_int_equal(em_picture_draw(picture, &state, rgba, &err), EM_OK);
  em_picture_free(picture);
}

/* How many pixels differ clearly. */
static int difference(const uint8_t *a, const uint8_t *b) {
  int count = 0;
  for (int k = 0; k < BYTES; k += 4)
    count += abs(a[k] - b[k]) + abs(a[k + 1] - b[k + 1]) + abs(a[k + 2] - b[k + 2]) > 24;
  return count;
}

static void every_option_shows(void **state) {
  (void)state;
  struct em_scene *scene = draw_scene(DRAW_MILL, 0, NULL);
  struct em_balls *balls = draw_start(scene);
  static uint8_t plain[BYTES], other[BYTES];
  struct em_picture_options o = options_for(scene, balls);
  draw(scene, &o, balls, plain);
  draw(scene, &o, balls, other);
  assert_memory_equal(plain, other, BYTES); /* the same state, the same picture */
  for (int kind = 0; kind < 14; kind++) {
    o = options_for(scene, balls);
    switch (kind) {
    case 0:
      o.hide_balls = true;
      break;
    case 1:
      o.hide_rotor = true;
      break;
    case 2:
      o.hide_drum = true;
      break;
    case 3:
      o.hide_legend = true;
      break;
    case 4:
      o.histogram = false;
      break;
    case 5:
      o.dark = true;
      break;
    case 6:
      o.camera = em_camera_make(EM_CAMERA_AXIAL);
      break;
    case 7:
      o.camera = em_camera_make(EM_CAMERA_SIDE);
      break;
    case 8:
      o.by = EM_PICTURE_SPECIES;
      break;
    case 9:
      o.map = EM_COLOUR_EMBER;
      break;
    case 10:
      o.limit = 20;
      break;
    case 11:
      o.show_low = 2.5;
      break; /* faster than any */
    case 12:
      o.camera.fov = 0.0;
      break;
    default:
      o.high *= 0.3;
    }
    draw(scene, &o, balls, other);
    assert_true(difference(plain, other) > (kind == 4 ? 20 : 100));
  }
  em_start_free(balls);
  em_scene_free(scene);
}

/* The legend lies on the mill: the colour bar looks the same with balls behind it. */
static void the_legend_is_on_top(void **state) {
  (void)state;
  struct em_scene *scene = draw_scene(DRAW_MILL, 0, NULL);
  struct em_balls *balls = draw_start(scene);
  static uint8_t far[BYTES], near[BYTES];
  struct em_picture_options o = options_for(scene, balls);
  o.histogram = false;
  draw(scene, &o, balls, far);
  o.camera.zoom = 4.0;
  draw(scene, &o, balls, near);
  assert_true(difference(far, near) > BYTES / 16);
  const double scale = 0.62, x = WIDTH - scale * 89.0; /* amid the bar */
  for (int y = HEIGHT / 3; y < HEIGHT * 3 / 4; y++)
    for (int c = 0; c < 3; c++) {
      const int at = 4 * (WIDTH * y + (int)x) + c;
      assert_true(abs(far[at] - near[at]) <= 2);
    }
  em_start_free(balls);
  em_scene_free(scene);
}

/* A title that is no UTF-8 takes nothing but its own letters away. */
static void titles_in_another_coding_are_drawn(void **state) {
  static const char *const title[] = {"title=M\xfchle", "title=M?hle"};
  static uint8_t rgba[2][BYTES];
  (void)state;
  for (int k = 0; k < 2; k++) {
    struct em_scene *scene = draw_scene(DRAW_MILL, 1, &title[k]);
    struct em_balls *balls = draw_start(scene);
    const struct em_picture_options o = options_for(scene, balls);
    draw(scene, &o, balls, rgba[k]);
    em_start_free(balls);
    em_scene_free(scene);
  }
  assert_memory_equal(rgba[0], rgba[1], BYTES);
}

/* The legend alone, against the ground: does it leave these pixels free? */
static bool is_free(const struct em_scene *scene, const struct em_balls *balls,
                    struct em_picture_options o, int left, int low) {
  static uint8_t with[BYTES], without[BYTES];
  o.hide_balls = o.hide_rotor = o.hide_drum = true;
  o.histogram = false;
  draw(scene, &o, balls, with);
  o.hide_legend = true;
  draw(scene, &o, balls, without);
  assert_true(difference(with, without) > 100);
  for (int y = 0; y < low; y++)
    for (int k = 4 * (WIDTH * y + left); k < 4 * WIDTH * (y + 1); k++)
      if (abs(with[k] - without[k]) > 4) return false; /* panels are the ground, nearly */
  return true;
}

/* However many kinds of balls there are, whatever their names, and whatever the scale. */
static void the_legend_stays_on_the_picture(void **state) {
  char kinds[8192] = "chamber = { shape = \"box\"; size = [1.0, 1.0, 1.0]; }; balls = (";
  (void)state;
  for (int k = 0; k < 40; k++)
    snprintf(kinds + strlen(kinds), sizeof kinds - strlen(kinds),
             "%s{ name = \"a name of balls that is long: %d\"; count = 1; diameter = 0.01; "
             "density = 1.0; }",
             k ? ", " : "", k);
  strcat(kinds, ");");
  struct em_scene *scene = draw_scene(kinds, 0, NULL);
  struct em_balls *balls = draw_start(scene);
  struct em_picture_options o = options_for(scene, balls);
  o.by = EM_PICTURE_SPECIES;
  assert_true(is_free(scene, balls, o, WIDTH - 5, HEIGHT));
  assert_true(is_free(scene, balls, o, 2 * WIDTH / 3, 8));
  o.by = EM_PICTURE_SPEED;
  for (double high = 1e-30; high < 1e31; high *= 8e4) {
    o.high = high;
    assert_true(is_free(scene, balls, o, WIDTH - 2, HEIGHT));
  }
  o.low = 1.0; /* steps that a double cannot make come to an end */
  o.high = nextafter(1.0, 2.0);
  assert_true(is_free(scene, balls, o, 2 * WIDTH / 3, 8));
  em_start_free(balls);
  em_scene_free(scene);
}

/* Moments of a run of a microsecond can be told apart. */
static void short_times_are_told(void **state) {
  static const char *const brief[] = {"duration=1e-6"};
  static const double angle[2];
  static uint8_t rgba[2][BYTES];
  struct em_picture *picture;
  struct em_error err = {0};
  (void)state;
  struct em_scene *scene = draw_scene(DRAW_MILL, 1, brief);
  struct em_balls *balls = draw_start(scene);
  const struct em_picture_options o = options_for(scene, balls);
  assert_int_equal(em_picture_new(&picture, scene, &o, &err), EM_OK);
  for (int k = 0; k < 2; k++) {
    const struct em_picture_state s = {
        .balls = balls, .time = 1e-7 + 1e-9 * k, .blade_angle = angle};
    assert_int_equal(em_picture_draw(picture, &s, rgba[k], &err), EM_OK);
  }
  assert_true(difference(rgba[0], rgba[1]) > 2);
  em_picture_free(picture);
  em_start_free(balls);
  em_scene_free(scene);
}

/* A picture of some of the balls says so: it differs even where none is in sight. */
static void a_choice_is_told(void **state) {
  (void)state;
  struct em_scene *scene = draw_scene(DRAW_MILL, 0, NULL);
  struct em_balls *balls = draw_start(scene);
  static uint8_t all[BYTES], some[BYTES];
  struct em_picture_options o = options_for(scene, balls);
  for (int kind = 0; kind < 2; kind++) {
    o = options_for(scene, balls);
    o.camera.zoom = 1e-3;
    draw(scene, &o, balls, all);
    o.limit = kind == 0 ? 20 : 0;
    o.show_low = kind == 0 ? 0.0 : 0.1;
    o.show_high = kind == 0 ? 0.0 : 100.0;
    draw(scene, &o, balls, some);
    assert_true(difference(all, some) > 50);
  }
  em_start_free(balls);
  em_scene_free(scene);
}

static void a_smoother_picture_is_the_same_picture(void **state) {
  (void)state;
  struct em_scene *scene = draw_scene(DRAW_MILL, 0, NULL);
  struct em_balls *balls = draw_start(scene);
  static uint8_t once[BYTES], thrice[BYTES];
  struct em_picture_options o = options_for(scene, balls);
  o.smooth = 1;
  draw(scene, &o, balls, once);
  o.smooth = 3;
  draw(scene, &o, balls, thrice);
  double sum = 0.0;
  for (int k = 0; k < BYTES; k++)
    sum += abs(once[k] - thrice[k]);
  assert_true(sum / BYTES < 4.0);
  em_start_free(balls);
  em_scene_free(scene);
}

/* What rests is grey in a triple, what moves is coloured. */
static void a_triple_shows_motion(void **state) {
  (void)state;
  struct em_scene *scene = draw_scene(DRAW_MILL, 0, NULL);
  struct em_balls *balls = draw_start(scene), *moved = draw_start(scene);
  static uint8_t rgba[BYTES];
  static const double angle[] = {0.3, 1.2};
  struct em_error err = {0};
  struct em_picture *picture;
  struct em_picture_options o = options_for(scene, balls);
  o.by = EM_PICTURE_PLAIN;
  assert_int_equal(em_picture_new(&picture, scene, &o, &err), EM_OK);
  for (int moves = 0; moves < 2; moves++) {
    struct em_picture_state three[3];
    for (int k = 0; k < 3; k++)
      three[k] = (struct em_picture_state){.balls = k == 1 ? moved : balls, .blade_angle = angle};
    if (moves) moved->position[0].z = -moved->position[0].z;
    assert_int_equal(em_picture_triple(picture, three, rgba, &err), EM_OK);
    int coloured = 0;
    for (int k = 0; k < BYTES; k += 4)
      coloured += abs(rgba[k] - rgba[k + 1]) > 8 || abs(rgba[k + 1] - rgba[k + 2]) > 8;
    assert_true(moves ? coloured > 10 : coloured == 0);
  }
  em_picture_free(picture);
  em_start_free(balls);
  em_start_free(moved);
  em_scene_free(scene);
}

static void bad_pictures_are_refused(void **state) {
  (void)state;
  struct em_scene *scene = draw_scene(DRAW_MILL, 0, NULL);
  struct em_balls *balls = draw_start(scene);
  static uint8_t rgba[BYTES];
  struct em_error err = {0};
  struct em_picture *picture;
  for (int kind = 0; kind < 5; kind++) {
    struct em_picture_options o = options_for(scene, balls);
    if (kind == 0) o.width = 0;
    if (kind == 1) o.height = 100000;
    if (kind == 2) o.smooth = 5;
    if (kind == 3) o.high = NAN;
    if (kind == 4) o.low = o.high;
    assert_int_equal(em_picture_new(&picture, scene, &o, &err), EM_INPUT);
    assert_null(picture);
  }
  const struct em_picture_options o = options_for(scene, balls);
  const double angle[2] = {0, 0};
  const struct em_picture_state s = {.balls = balls, .blade_angle = angle};
  assert_int_equal(em_picture_new(&picture, scene, &o, &err), EM_OK);
  balls->position[3].x = INFINITY;
  assert_int_equal(em_picture_draw(picture, &s, rgba, &err), EM_INPUT);
  em_picture_free(picture);
  assert_int_equal(em_picture_save("/nowhere/x.png", rgba, WIDTH, HEIGHT, &err), EM_FILE);
  assert_int_equal(em_picture_save(draw_path("x.jpg"), rgba, WIDTH, HEIGHT, &err), EM_INPUT);
  em_start_free(balls);
  em_scene_free(scene);
}

static void record_of(const char *text, const char *path, size_t count,
                      const char *const *overrides) {
  struct em_scene *scene = draw_scene(text, count, overrides);
  const struct em_recorder_options o = {.path = path, .force = true, .command = "test"};
  struct em_error err = {0};
  if (em_recorder_run(scene, &o, NULL, NULL, &err) != EM_OK) fail_msg("%s", err.text);
  em_scene_free(scene);
}

static void record(const char *path, size_t count, const char *const *overrides) {
  record_of(DRAW_MILL, path, count, overrides);
}

/* The furthest that the paths of a run in a box of this edge, periodic along all directions, are
 * from the frames of another. */
static double furthest(const char *sparse, const char *dense, double edge) {
  struct em_run_file *a, *b;
  struct em_error err = {0};
  struct em_motion *motion;
  struct em_balls *frame;
  double worst = 0.0;
  assert_int_equal(em_run_file_open(&a, sparse, &err), EM_OK);
  assert_int_equal(em_run_file_open(&b, dense, &err), EM_OK);
  assert_int_equal(em_motion_new(&motion, a, 0.0, &err), EM_OK);
  assert_int_equal(em_run_file_balls(b, &frame, &err), EM_OK);
  for (size_t k = 0; k < em_run_file_frame_count(b); k++) {
    assert_int_equal(em_run_file_frame(b, k, frame, &err), EM_OK);
    assert_int_equal(em_motion_seek(motion, em_run_file_frame_time(b, k), &err), EM_OK);
    const struct em_balls *balls = em_motion_balls(motion);
    for (size_t n = 0; n < frame->count; n++)
      for (int x = 0; x < 3; x++)
        worst = fmax(worst, fabs(remainder(em_vec_component(balls->position[n], x) -
                                               em_vec_component(frame->position[n], x),
                                           edge)));
  }
  em_motion_free(motion);
  em_start_free(frame);
  em_run_file_close(a);
  em_run_file_close(b);
  return worst;
}

/* Between two contacts, or two frames, a ball goes through a periodic box more than once. */
static void paths_through_periodic_boxes_are_exact(void **state) {
  static const char box[] =
      "duration = 1.0; gravity = \"none\"; chamber = { shape = \"box\"; size = [0.1, 0.1, 0.1];\n"
      "periodic = true; }; balls = { count = 30; diameter = 0.01; density = 1000.0; speed = 2.0; "
      "};\n"
      "contact = { rule = \"rough\"; normal = 0.95; tangential = 0.5; };";
  static const char *const few[] = {"record.frames=1", "record.collisions=true"};
  static const char *const many[] = {"record.frames=500"};
  static const char *const alone[] = {"record.frames=10", "balls.count=1", "balls.start=table",
                                      "balls.table=([0.05, 0.05, 0.05, 1.0, -2.0, 3.7])"};
  (void)state;
  const char *sparse = draw_path("few.h5"), *dense = draw_path("many.h5");
  record_of(box, sparse, 2, few);
  record_of(box, dense, 1, many);
  assert_true(furthest(sparse, dense, 0.1) < 5e-8);
  record_of(box, sparse, 4, alone); /* without a table */
  static const char *const often[] = {"record.frames=500", "balls.count=1", "balls.start=table",
                                      "balls.table=([0.05, 0.05, 0.05, 1.0, -2.0, 3.7])"};
  record_of(box, dense, 4, often);
  assert_true(furthest(sparse, dense, 0.1) < 1e-9);
}

/* Paths from few frames and the collision table, against the many frames of the same run. */
static void paths_between_frames_are_exact(void **state) {
  static const char *const few[] = {"record.frames=100"}, *const many[] = {"record.frames=2100"};
  (void)state;
  const char *sparse = draw_path("sparse.h5"), *dense = draw_path("dense.h5");
  record(sparse, 1, few);
  record(dense, 1, many);
  struct em_run_file *a, *b;
  struct em_error err = {0};
  struct em_motion *motion;
  struct em_balls *frame;
  assert_int_equal(em_run_file_open(&a, sparse, &err), EM_OK);
  assert_int_equal(em_run_file_open(&b, dense, &err), EM_OK);
  assert_int_equal(em_motion_new(&motion, a, 0.002, &err), EM_OK);
  assert_true(em_motion_is_exact(motion));
  assert_int_equal(em_run_file_balls(b, &frame, &err), EM_OK);
  double worst = 0.0, moved = 0.0;
  for (size_t k = 0; k < em_run_file_frame_count(b); k++) {
    assert_int_equal(em_run_file_frame(b, k, frame, &err), EM_OK);
    assert_int_equal(em_motion_seek(motion, em_run_file_frame_time(b, k), &err), EM_OK);
    const struct em_balls *balls = em_motion_balls(motion);
    for (size_t n = 0; n < frame->count; n++) {
      worst = fmax(worst, em_vec_norm(em_vec_sub(balls->position[n], frame->position[n])));
      moved = fmax(moved, em_vec_norm(frame->position[n]));
    }
  }
  assert_true(moved > 0.01);
  assert_true(worst < 5e-8); /* places are stored as 32-bit floats */
  struct em_picture_bead bead[64];
  const size_t marks = em_motion_marks(motion, bead, 64, 0.001);
  assert_true(marks > 0 && marks <= 64);
  assert_true(hypot(bead[0].place.x, bead[0].place.z) <= 0.03 + 1e-6);
  const uint8_t *cls = em_motion_classes(motion);
  size_t known = 0;
  for (size_t n = 0; n < frame->count; n++)
    known += cls[n] < EM_CLASS_COUNT;
  assert_true(known > frame->count / 2);
  /* Who jumps there knows the same as who came step by step. */
  struct em_motion *jump;
  assert_int_equal(em_motion_new(&jump, a, 0.0, &err), EM_OK);
  assert_int_equal(em_motion_seek(jump, em_motion_last(motion), &err), EM_OK);
  assert_memory_equal(em_motion_classes(jump), cls, frame->count);
  em_motion_free(jump);
  em_motion_free(motion);
  em_start_free(frame);
  em_run_file_close(a);
  em_run_file_close(b);
}

/* Trails are closed lines over all the time there is; marks are the latest, and the others counted.
 */
static void trails_and_marks_are_complete(void **state) {
  (void)state;
  const char *path = draw_path("trails.h5");
  static const char *const many[] = {"balls.count=400", "gravity=[0.0, 0.0, 0.0]"};
  record(path, 2, many);
  struct em_run_file *run;
  struct em_error err = {0};
  struct em_show *show;
  struct em_picture_state s;
  const struct em_show_options trail = {.trail_count = 1, .trail = {7}, .trail_time = 10.0};
  const struct em_show_options marks = {.mark_time = 1.0};
  assert_int_equal(em_run_file_open(&run, path, &err), EM_OK);
  assert_int_equal(em_show_new(&show, run, &trail, &err), EM_OK);
  assert_int_equal(em_show_at(show, 0.05, &s, &err), EM_OK);
  double longest = 0.0, length = 0.0;
  for (size_t k = 1; k < s.bead_count; k++) {
    const double step = em_vec_norm(em_vec_sub(s.bead[k].place, s.bead[k - 1].place));
    longest = fmax(longest, step);
    length += step;
  }
  assert_true(length > 0.02);
  assert_true(longest < 0.5 * 0.002);
  em_show_free(show);
  const struct em_show_options none = {.trail_count = 1, .trail = {7}, .trail_time = 5e-17};
  assert_int_equal(em_show_new(&show, run, &none, &err), EM_OK);
  assert_int_equal(em_show_at(show, 0.05, &s, &err), EM_OK); /* comes to an end */
  em_show_free(show);
  assert_int_equal(em_show_new(&show, run, &marks, &err), EM_OK);
  assert_int_equal(em_show_at(show, 0.05, &s, &err), EM_OK);
  assert_int_equal(s.bead_count, EM_SHOW_MARKS);
  assert_true(s.unmarked > 0 && s.bead[0].disc);
  em_show_free(show);
  em_run_file_close(run);
}

/* Without a table: through the frames, inside the drum, and steady. */
static void paths_without_a_table_stay_inside(void **state) {
  static const char *const plain[] = {"record.collisions=false", "record.frames=100"};
  (void)state;
  const char *path = draw_path("plain.h5");
  record(path, 2, plain);
  struct em_run_file *run;
  struct em_error err = {0};
  struct em_motion *motion;
  struct em_balls *frame;
  assert_int_equal(em_run_file_open(&run, path, &err), EM_OK);
  assert_int_equal(em_motion_new(&motion, run, 0.0, &err), EM_OK);
  assert_false(em_motion_is_exact(motion));
  assert_null(em_motion_classes(motion));
  assert_int_equal(em_run_file_balls(run, &frame, &err), EM_OK);
  for (size_t k = 0; k < em_run_file_frame_count(run); k++) {
    const double t = em_run_file_frame_time(run, k);
    assert_int_equal(em_run_file_frame(run, k, frame, &err), EM_OK);
    for (int side = -1; side <= 1; side++) {
      assert_int_equal(em_motion_seek(motion, t + 1e-7 * side, &err), EM_OK);
      const struct em_balls *balls = em_motion_balls(motion);
      for (size_t n = 0; n < frame->count; n++)
        assert_true(em_vec_norm(em_vec_sub(balls->position[n], frame->position[n])) < 5e-6);
    }
    assert_int_equal(em_motion_seek(motion, t + 0.0037, &err), EM_OK);
    const struct em_balls *balls = em_motion_balls(motion);
    for (size_t n = 0; n < frame->count; n++) {
      assert_true(hypot(balls->position[n].x, balls->position[n].z) <= 0.028 + 1e-9);
      assert_true(balls->position[n].y >= 0.002 - 1e-9 && balls->position[n].y <= 0.048 + 1e-9);
    }
  }
  em_motion_free(motion);
  em_start_free(frame);
  em_run_file_close(run);
}

/* Balls are shown where the run has them, in the corners of facets as well, with and without a
 * table. */
static void corners_of_facets_are_shown(void **state) {
  static const char *const with[] = {"chamber.facets=3", "record.frames=500"};
  static const char *const without[] = {"chamber.facets=3", "record.frames=500",
                                        "record.collisions=false"};
  (void)state;
  for (int table = 0; table < 2; table++) {
    const char *path = draw_path("facets.h5");
    record(path, table ? 2 : 3, table ? with : without);
    struct em_run_file *run;
    struct em_error err = {0};
    struct em_motion *motion;
    struct em_balls *frame;
    assert_int_equal(em_run_file_open(&run, path, &err), EM_OK);
    assert_int_equal(em_motion_new(&motion, run, 0.0, &err), EM_OK);
    assert_int_equal(em_motion_is_exact(motion), table);
    assert_int_equal(em_run_file_balls(run, &frame, &err), EM_OK);
    double worst = 0.0, farthest = 0.0, out = 0.0;
    for (size_t k = 0; k < em_run_file_frame_count(run); k++) {
      const double t = em_run_file_frame_time(run, k);
      assert_int_equal(em_run_file_frame(run, k, frame, &err), EM_OK);
      assert_int_equal(em_motion_seek(motion, t, &err), EM_OK);
      const struct em_balls *balls = em_motion_balls(motion);
      for (size_t n = 0; n < frame->count; n++) {
        const struct em_vec p = balls->position[n];
        worst = fmax(worst, em_vec_norm(em_vec_sub(p, frame->position[n])));
        farthest = fmax(farthest, hypot(p.x, p.z));
      }
      assert_int_equal(em_motion_seek(motion, t + 0.001, &err), EM_OK);
      balls = em_motion_balls(motion);
      for (size_t n = 0; n < frame->count; n++) {
        const struct em_vec p = balls->position[n];
        const double side = 0.5 * sqrt(3.0) * fabs(p.x) - 0.5 * p.z;
        out = fmax(out, fmax(p.z, side) - 0.028);
      }
    }
    assert_true(worst < 5e-8); /* places are stored as 32-bit floats */
    assert_true(farthest > 0.04);
    assert_true(out < 1e-8);
    em_motion_free(motion);
    em_start_free(frame);
    em_run_file_close(run);
  }
}

static void facets_are_drawn(void **state) {
  static const char *const round[] = {"balls.count=0"},
                           *const flat[] = {"balls.count=0", "chamber.facets=4"},
                           *const many[] = {"balls.count=0", "chamber.facets=20000"};
  (void)state;
  static uint8_t rgba[3][BYTES];
  for (int kind = 0; kind < 3; kind++) {
    struct em_scene *scene = draw_scene(DRAW_MILL, kind ? 2 : 1,
                                        kind == 0   ? round
                                        : kind == 1 ? flat
                                                    : many);
    struct em_balls *balls = draw_start(scene);
    const struct em_picture_options o = options_for(scene, balls);
    draw(scene, &o, balls, rgba[kind]);
    em_start_free(balls);
    em_scene_free(scene);
  }
  assert_true(difference(rgba[0], rgba[1]) > 1000);
  assert_true(difference(rgba[0], rgba[2]) == 0);
}

static int clean(void **state) {
  (void)state;
  draw_clean();
  return 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_option_shows),
      cmocka_unit_test(the_legend_is_on_top),
      cmocka_unit_test(titles_in_another_coding_are_drawn),
      cmocka_unit_test(the_legend_stays_on_the_picture),
      cmocka_unit_test(short_times_are_told),
      cmocka_unit_test(a_choice_is_told),
      cmocka_unit_test(a_smoother_picture_is_the_same_picture),
      cmocka_unit_test(a_triple_shows_motion),
      cmocka_unit_test(bad_pictures_are_refused),
      cmocka_unit_test(paths_between_frames_are_exact),
      cmocka_unit_test(paths_through_periodic_boxes_are_exact),
      cmocka_unit_test(trails_and_marks_are_complete),
      cmocka_unit_test(paths_without_a_table_stay_inside),
      cmocka_unit_test(corners_of_facets_are_shown),
      cmocka_unit_test(facets_are_drawn),
  };
  return cmocka_run_group_tests(tests, NULL, clean);
}
