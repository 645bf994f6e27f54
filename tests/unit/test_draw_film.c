/* Films: as many frames as asked for, in order, of the size asked for; nothing is left of a film
 * that failed. No canvas may be made in this process before the films. */
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "draw_mill.h"
#include "eventmill/film.h"

struct reel {
  struct em_balls *balls;
  double angle[2];
  size_t fail_at, stop_at, asked;
};

static enum em_status state_at(void *self, size_t k, struct em_picture_state *state,
                               struct em_error *err) {
  struct reel *reel = self;
  assert_int_equal(k, reel->asked);
  reel->asked++;
  if (k == reel->fail_at) return em_error_set(err, EM_NUMERIC, NULL, 0, "no such state");
  /* The whole picture grows lighter: the order of frames can be seen. */
  reel->angle[0] = reel->angle[1] = 0.1 * (double)k;
  for (size_t b = 0; b < reel->balls->count; b++)
    reel->balls->velocity[b] = em_vec_make(0.1 * (double)k, 0, 0);
  *state = (struct em_picture_state){
      .balls = reel->balls, .time = 0.001 * (double)k, .blade_angle = reel->angle};
  return EM_OK;
}

static bool stops(void *self, size_t done, size_t frames) {
  const struct reel *reel = self;
  assert_true(done <= frames);
  return done != reel->stop_at;
}

static struct em_film_options options_for(const struct em_scene *scene, size_t frames) {
  struct em_film_options o = {
      .picture = em_picture_default(scene, NULL), .frames = frames, .fps = 25.0, .workers = 2};
  o.picture.width = 321; /* odd: rounded down */
  o.picture.height = 180;
  o.picture.smooth = 1;
  o.picture.high = 1.0;
  return o;
}

static enum em_status film(const char *path, struct reel *reel, const struct em_film_options *o,
                           const struct em_scene *scene, struct em_error *err) {
  return em_film_make(path, scene, o, state_at, reel, stops, reel, err);
}

/* What ffprobe says of a film, as "codec,width,height,pix_fmt,rate,frames". */
static void probe(const char *path, char *line, size_t size) {
  char command[512];
  snprintf(command, sizeof command,
           "ffprobe -v error -count_frames -select_streams v:0 -show_entries "
           "stream=codec_name,width,height,pix_fmt,r_frame_rate,nb_read_frames -of csv=p=0 '%s'",
           path);
  FILE *pipe = popen(command, "r");
  assert_non_null(pipe);
  assert_non_null(fgets(line, (int)size, pipe));
  line[strcspn(line, "\n")] = '\0';
  pclose(pipe);
}

/* Mean of the middle part of each frame of a film. */
static size_t read_greens(const char *path, double *mean, size_t most) {
  char command[512];
  snprintf(command, sizeof command,
           "ffmpeg -v error -i '%s' -vf scale=1:1:flags=area -f rawvideo -pix_fmt rgb24 -", path);
  FILE *pipe = popen(command, "r");
  unsigned char rgb[3];
  size_t count = 0;
  while (count < most && fread(rgb, 1, 3, pipe) == 3)
    mean[count++] = rgb[1];
  pclose(pipe);
  return count;
}

static void a_film_has_all_frames(void **state) {
  (void)state;
  struct em_scene *scene = draw_scene(DRAW_MILL, 0, NULL);
  for (int workers = 1; workers <= 3; workers++) {
    struct reel reel = {.balls = draw_start(scene), .fail_at = SIZE_MAX, .stop_at = SIZE_MAX};
    struct em_error err = {0};
    struct em_film_options o = options_for(scene, 11);
    char line[256];
    double mean[16];
    const char *path = draw_path("a film.mp4");
    o.workers = workers == 1 ? 2 : workers == 2 ? 3 : 1; /* the one without fork comes last */
    assert_int_equal(film(path, &reel, &o, scene, &err), EM_OK);
    assert_int_equal(reel.asked, 11);
    probe(path, line, sizeof line);
    assert_string_equal(line, "h264,320,180,yuv420p,25/1,11");
    assert_int_equal(read_greens(path, mean, 16), 11);
    for (int k = 1; k < 11; k++)
      assert_true(mean[k] >= mean[k - 1]);
    assert_true(mean[10] > mean[0] + 3.0);
    assert_int_not_equal(access(draw_path("a film.mp4.part"), F_OK), 0);
    em_start_free(reel.balls);
  }
  em_scene_free(scene);
}

static void nothing_is_left_of_a_failure(void **state) {
  (void)state;
  struct em_scene *scene = draw_scene(DRAW_MILL, 0, NULL);
  struct em_film_options o = options_for(scene, 9);
  const char *path = draw_path("failed.mp4");
  struct em_balls *balls = draw_start(scene);
  for (int kind = 0; kind < 3; kind++) {
    struct reel reel = {.balls = balls, .fail_at = SIZE_MAX, .stop_at = SIZE_MAX};
    struct em_error err = {0};
    if (kind == 0) reel.fail_at = 0;
    if (kind == 1) reel.fail_at = 6;
    if (kind == 2) reel.stop_at = 3;
    assert_int_equal(film(path, &reel, &o, scene, &err), kind == 2 ? EM_STOPPED : EM_NUMERIC);
    assert_int_not_equal(access(path, F_OK), 0);
    assert_int_not_equal(access(draw_path("failed.mp4.part"), F_OK), 0);
  }
  em_start_free(balls);
  em_scene_free(scene);
}

static void on_signal(int number) {
  (void)number;
}

static bool signals(void *self, size_t done, size_t frames) {
  (void)self;
  if (done == 3) {
    usleep(200000); /* until the workers wait for more */
    kill(0, SIGTERM);
    kill(0, SIGHUP);
  }
  return done <= frames;
}

/* A signal that all of a group get ends the film by the parent's will alone. */
static void workers_leave_signals_to_the_parent(void **state) {
  (void)state;
  struct em_scene *scene = draw_scene(DRAW_MILL, 0, NULL);
  const struct em_film_options o = options_for(scene, 12);
  struct reel reel = {.balls = draw_start(scene), .fail_at = SIZE_MAX};
  const struct sigaction action = {.sa_handler = on_signal};
  struct sigaction old[2];
  struct em_error err = {0};
  const pid_t group = getpgrp();
  assert_int_equal(setpgid(0, 0), 0);
  sigaction(SIGTERM, &action, &old[0]);
  sigaction(SIGHUP, &action, &old[1]);
  const enum em_status status =
      em_film_make(draw_path("group.mp4"), scene, &o, state_at, &reel, signals, NULL, &err);
  sigaction(SIGTERM, &old[0], NULL);
  sigaction(SIGHUP, &old[1], NULL);
  assert_int_equal(setpgid(0, group), 0);
  assert_string_equal(err.text, "");
  assert_int_equal(status, EM_OK);
  em_start_free(reel.balls);
  em_scene_free(scene);
}

static void bad_states_and_options_are_told(void **state) {
  (void)state;
  struct em_scene *scene = draw_scene(DRAW_MILL, 0, NULL);
  struct em_balls *balls = draw_start(scene);
  struct reel reel = {.balls = balls, .fail_at = SIZE_MAX, .stop_at = SIZE_MAX};
  struct em_error err = {0};
  const char *path = draw_path("bad.mp4");
  struct em_film_options o = options_for(scene, 0);
  assert_int_equal(film(path, &reel, &o, scene, &err), EM_INPUT);
  o = options_for(scene, 3);
  o.fps = NAN;
  assert_int_equal(film(path, &reel, &o, scene, &err), EM_INPUT);
  o = options_for(scene, 3);
  o.picture.low = o.picture.high; /* found out by the workers */
  assert_int_equal(film(path, &reel, &o, scene, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "scale"));
  o = options_for(scene, 3);
  reel.asked = 0;
  balls->position[7].y = NAN;
  assert_int_equal(film(path, &reel, &o, scene, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "ball 7"));
  reel.asked = 0;
  balls->position[7].y = 0.02;
  assert_int_equal(film("/nowhere/at/all.mp4", &reel, &o, scene, &err), EM_FILE);
  assert_int_equal(film(draw_path("bad.avi"), &reel, &o, scene, &err), EM_INPUT);
  assert_int_not_equal(access(path, F_OK), 0);
  em_start_free(balls);
  em_scene_free(scene);
}

static void a_missing_or_failing_ffmpeg_is_told(void **state) {
  (void)state;
  struct em_scene *scene = draw_scene(DRAW_MILL, 0, NULL);
  struct em_balls *balls = draw_start(scene);
  struct em_film_options o = options_for(scene, 40);
  char *old = strdup(getenv("PATH"));
  struct reel reel = {.balls = balls, .fail_at = SIZE_MAX, .stop_at = SIZE_MAX};
  struct em_error err = {0};
  setenv("PATH", "/nowhere", 1);
  assert_int_equal(film(draw_path("x.mp4"), &reel, &o, scene, &err), EM_PICTURE);
  assert_non_null(strstr(err.text, "ffmpeg"));
  /* One that dies at once: sending to it must not kill us. */
  const char *fake = draw_path("ffmpeg");
  FILE *script = fopen(fake, "w");
  fputs("#!/bin/sh\necho 'the film tore' >&2\nexit 3\n", script);
  fclose(script);
  char command[320], folder[256];
  snprintf(command, sizeof command, "/bin/chmod +x '%s'", fake);
  setenv("PATH", old, 1);
  assert_int_equal(system(command), 0);
  snprintf(folder, sizeof folder, "%.*s", (int)(strlen(fake) - strlen("/ffmpeg")), fake);
  setenv("PATH", folder, 1);
  reel.asked = 0;
  assert_int_equal(film(draw_path("x.mp4"), &reel, &o, scene, &err), EM_PICTURE);
  assert_non_null(strstr(err.text, "the film tore"));
  setenv("PATH", old, 1);
  assert_int_not_equal(access(draw_path("x.mp4"), F_OK), 0);
  free(old);
  em_start_free(balls);
  em_scene_free(scene);
}

static int clean(void **state) {
  (void)state;
  draw_clean();
  return 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(nothing_is_left_of_a_failure),
      cmocka_unit_test(workers_leave_signals_to_the_parent),
      cmocka_unit_test(bad_states_and_options_are_told),
      cmocka_unit_test(a_missing_or_failing_ffmpeg_is_told),
      cmocka_unit_test(a_film_has_all_frames),
  };
  return cmocka_run_group_tests(tests, NULL, clean);
}
