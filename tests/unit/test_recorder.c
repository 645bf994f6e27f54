/* The recorder as another program calls it: beside its file, with a scene of its own. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <sys/resource.h>

#include <cmocka.h>

#include "run_digest.h"

static void record(const struct em_scene *scene, const struct em_recorder_options *options,
                   struct em_summary *summary) {
  struct em_error err = {0};
  if (em_recorder_run(scene, options, summary, NULL, &err)) fail_msg("%s", err.text);
}

static void count(void *self, const struct em_contact *contact) {
  (void)contact;
  ++*(uint64_t *)self;
}

/* With and without a file, and with a table of collisions, which has an observer of its own. */
static void observers_see_what_is_recorded(void **state) {
  (void)state;
  struct em_scene *scene = digest_scene(SMALL_MILL, 0, NULL);
  for (int k = 0; k < 2; k++) {
    uint64_t seen = 0;
    struct em_summary summary;
    const struct em_observer observer = {&seen, count};
    const struct em_recorder_options options = {.path = k ? digest_path("seen.h5") : NULL,
                                                .observer = &observer};
    record(scene, &options, &summary);
    assert_true(seen > 1000);
    assert_int_equal(seen, summary.collisions);
  }
  em_scene_free(scene);
}

/* Targets steer a run although nobody asks what was found. */
static void targets_need_no_room_for_findings(void **state) {
  (void)state;
  struct em_scene *scene = digest_scene(SMALL_MILL, 0, NULL);
  struct em_precision_target target[EM_PRECISION_TARGETS];
  struct em_error err = {0};
  size_t targets;
  assert_int_equal(em_precision_read(target, &targets, "median(vn)=50%", &err), EM_OK);
  record(scene, &(struct em_recorder_options){.target_count = targets, .target = target}, NULL);
  em_scene_free(scene);
}

/* Balls that start from a run meet the blades where these stood then, in the caller's scene as it
 * was read; which stays as it is. */
static void blades_begin_where_they_stood(void **state) {
  (void)state;
  const char *first = digest_path("first.h5"), *part = "duration=0.05";
  struct em_scene *scene = digest_scene(SMALL_MILL, 1, &part);
  record(scene, &(struct em_recorder_options){.path = first}, NULL);
  em_scene_free(scene);
  char from[300];
  snprintf(from, sizeof from, "balls.from=%s", first);
  const char *more[] = {"balls.start=run", from, "duration=0.02"};
  uint64_t digest[2];
  struct em_error err = {0};
  for (int k = 0; k < 2; k++) {
    const char *path = digest_path(k ? "by-hand.h5" : "as-read.h5");
    scene = digest_scene(SMALL_MILL, 3, more);
    if (k) assert_int_equal(em_run_file_turn(scene, &err), EM_OK);
    record(scene, &(struct em_recorder_options){.path = path}, NULL);
    assert_true((scene->rotor[0].blade[0].angle == 0.0) == (k == 0));
    em_scene_free(scene);
    assert_int_equal(digest_run(path, &digest[k], &err), EM_OK);
  }
  assert_true(digest[0] == digest[1]);
}

static struct rlimit room;

/* From now on no file grows. */
static void fill_disk(void *self, const struct em_recorder_progress *progress) {
  (void)self, (void)progress;
  setrlimit(RLIMIT_FSIZE, &(struct rlimit){1, room.rlim_max});
}

static void what_ended_a_run_is_told_before_a_full_disk(void **state) {
  (void)state;
  static const char text[] =
      "duration = 1.0; chamber = { shape = \"box\"; size = [0.05, 0.05, 0.05]; };\n"
      "balls = { count = 1; diameter = 0.01; };\n"
      "contact = { rule = \"smooth\"; normal = 0.5; };\n"
      "record = { frames = 0.0; observables = 0.0; histograms = 0.0; checkpoint = 1e6; };";
  struct em_scene *scene = digest_scene(text, 0, NULL);
  const struct em_recorder_options options = {.path = digest_path("full.h5"),
                                              .progress = fill_disk};
  struct em_error err = {0};
  struct em_summary summary;
  bool created = false;
  signal(SIGXFSZ, SIG_IGN);
  assert_int_equal(getrlimit(RLIMIT_FSIZE, &room), 0);
  const enum em_status status = em_recorder_run(scene, &options, &summary, &created, &err);
  setrlimit(RLIMIT_FSIZE, &room);
  em_scene_free(scene);
  assert_int_equal(status, EM_COLLAPSE);
  assert_int_equal(err.code, EM_COLLAPSE);
  assert_non_null(strstr(err.text, "remedy.elastic_below"));
  assert_non_null(strstr(err.text, "\nerror: nor is the end in the run file:\n"));
  assert_non_null(strstr(err.text, "full.h5: error: "));
  assert_true(created && summary.begun);
}

static void a_run_that_cannot_begin_says_so(void **state) {
  (void)state;
  struct em_scene *scene = digest_scene(SMALL_MILL, 0, NULL);
  struct em_summary summary = {.begun = true, .collisions = 7};
  struct em_error err = {0};
  const struct em_recorder_options options = {.path = "/nowhere/at/all.h5"};
  assert_int_equal(em_recorder_run(scene, &options, &summary, NULL, &err), EM_FILE);
  assert_true(!summary.begun && summary.collisions == 0);
  em_scene_free(scene);
}

/* A rate may not be a double, nor k / rate: 21 / 2.8 is more than 7.5, 42 / 2.8 more than 15, by
 * their last bit. What is due at the end is there, and a longer run goes on from it. */
static void what_is_due_at_the_end_is_recorded(void **state) {
  (void)state;
  static const char text[] =
      "duration = 7.5; gravity = \"none\"; chamber = { shape = \"box\"; size = [1, 1, 1]; };\n"
      "balls = { count = 5; diameter = 0.05; };\n"
      "record = { frames = 2.8; observables = 5.6; histograms = 2.8; };";
  uint64_t digest[2] = {0};
  struct em_error err = {0};
  for (int k = 0; k < 3; k++) {
    const char *path = digest_path(k == 0 ? "at-once.h5" : "in-two.h5"), *longer = "duration=15";
    struct em_scene *scene = digest_scene(text, k != 1, &longer);
    struct em_summary summary;
    record(scene, &(struct em_recorder_options){.path = path, .resume = true}, &summary);
    assert_int_equal(summary.end, EM_END_DONE);
    assert_true(fabs(summary.simulated_time - scene->duration) < 1e-14);
    struct em_run_file *file = NULL;
    struct em_series *speed = NULL;
    assert_int_equal(em_run_file_open(&file, path, &err), EM_OK);
    assert_int_equal(em_run_file_series(file, "mean_speed", &speed, &err), EM_OK);
    assert_int_equal(em_run_file_frame_count(file), k == 1 ? 22 : 43);
    assert_int_equal(em_run_file_block_count(file), k == 1 ? 21 : 42);
    assert_int_equal(speed->count, k == 1 ? 43 : 85);
    em_run_file_series_free(speed);
    em_run_file_close(file);
    record(scene, &(struct em_recorder_options){.path = path, .resume = true}, &summary);
    assert_int_equal(summary.end, EM_END_DONE);
    em_scene_free(scene);
    assert_int_equal(digest_run(path, &digest[k > 0], &err), EM_OK);
  }
  assert_true(digest[0] == digest[1]);
}

static int remove_folder(void **state) {
  (void)state;
  digest_folder_remove();
  return 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(observers_see_what_is_recorded),
      cmocka_unit_test(targets_need_no_room_for_findings),
      cmocka_unit_test(blades_begin_where_they_stood),
      cmocka_unit_test(what_ended_a_run_is_told_before_a_full_disk),
      cmocka_unit_test(a_run_that_cannot_begin_says_so),
      cmocka_unit_test(what_is_due_at_the_end_is_recorded),
  };
  return cmocka_run_group_tests(tests, NULL, remove_folder);
}
