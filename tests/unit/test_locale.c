/* In a program whose locale writes 0,5 for a half, the library reads and writes 0.5. Where the
 * system can make no such locale, all is passed over. */
#include <locale.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "eventmill/plot.h"
#include "eventmill/view.h"
#include "eventmill/xdmf.h"
#include "run_digest.h"

static bool made;

static int make_locale(void **state) {
  (void)state;
  char command[512];
  snprintf(command, sizeof command, "localedef -i de_DE -f UTF-8 %s/de_DE.UTF-8 2>/dev/null",
           digest_folder());
  if (system(command) != 0) return 0;
  setenv("LOCPATH", digest_folder(), 1);
  made = setlocale(LC_ALL, "de_DE.UTF-8") && *localeconv()->decimal_point == ',';
  setlocale(LC_ALL, "C");
  return 0;
}

static int remove_folder(void **state) {
  (void)state;
  digest_folder_remove();
  return 0;
}

static void with_comma(bool comma) {
  setlocale(LC_ALL, comma ? "de_DE.UTF-8" : "C");
}

/* The library leaves the locale as it is. */
static void is_comma(bool comma) {
  assert_int_equal(*localeconv()->decimal_point, comma ? ',' : '.');
}

static char *text_of(const char *path) {
  char *text = calloc(1, 1 << 22);
  FILE *in = fopen(path, "r");
  assert_true(text && in);
  assert_true(fread(text, 1, (1 << 22) - 1, in) > 0);
  fclose(in);
  return text;
}

static void scenes_are_read_and_printed_alike(void **state) {
  (void)state;
  if (!made) skip();
  const char *overrides[] = {"contact.normal=0.85", "rotor.rpm=1300.5"};
  char *text[2];
  for (int k = 0; k < 2; k++) {
    struct em_scene *scene = NULL;
    struct em_error err = {0};
    with_comma(k);
    if (em_scene_read(&scene, "geometries/simoloyer-2l.cfg", 2, overrides, &err))
      fail_msg("%s", err.text);
    text[k] = em_scene_text(scene);
    is_comma(k);
    em_scene_free(scene);
  }
  with_comma(false);
  assert_string_equal(text[0], text[1]);
  free(text[0]);
  free(text[1]);
}

static void errors_and_targets_have_points(void **state) {
  (void)state;
  if (!made) skip();
  struct em_precision_target target[EM_PRECISION_TARGETS];
  struct em_error err = {0};
  size_t count;
  char name[64];
  with_comma(true);
  assert_int_equal(em_precision_read(target, &count, "rate(vn>2.5)=0.5%", &err), EM_OK);
  assert_true(target[0].above == 2.5 && target[0].wanted == 0.005);
  em_precision_name(target, name, sizeof name);
  em_error_set(&err, EM_INPUT, NULL, 0, "%g", 0.5);
  is_comma(true);
  with_comma(false);
  assert_string_equal(name, "rate(vn>2.5)");
  assert_string_equal(err.text, "error: 0.5");
}

/* A run that is recorded, and gone on with, in one locale is that of the other. */
static void runs_are_recorded_alike(void **state) {
  (void)state;
  if (!made) skip();
  uint64_t digest[2] = {0, 0};
  static const char *const length[] = {"duration=0.0125", "duration=0.0225"};
  for (int k = 0; k < 4; k++) {
    const struct em_recorder_options options = {
        .path = digest_path(k < 2 ? "point.h5" : "comma.h5"), .resume = true};
    struct em_error err = {0};
    with_comma(k >= 2);
    struct em_scene *scene = digest_scene(SMALL_MILL, 1, &length[k % 2]);
    if (em_recorder_run(scene, &options, NULL, NULL, &err)) fail_msg("%s", err.text);
    em_scene_free(scene);
    if (digest_run(options.path, &digest[k / 2], &err)) fail_msg("%s", err.text);
    is_comma(k >= 2);
  }
  with_comma(false);
  assert_true(digest[0] == digest[1]);
}

static void draw(const struct em_run_file *run, int what, const char *path) {
  static const double x[] = {0.5, 1.5, 2.5}, y[] = {0.25, 0.75, 0.5};
  const struct em_plot_series line = {
      .name = "a", .style = EM_PLOT_LINE, .count = 3, .x = x, .y = y};
  const struct em_plot plot = {.title = "t", .series_count = 1, .series = &line};
  const struct em_view_options view = {.from = NAN, .to = NAN, .step = NAN, .high = 1.5};
  struct em_error err = {0};
  enum em_status status = EM_OK;
  if (what == 0) status = em_plot_draw(&plot, path, &err);
  if (what == 1) status = em_xdmf_write(run, path, EM_XDMF_HYPERSLAB, &err);
  if (what == 2) status = em_view_write(run, &view, path, NULL, &err);
  if (status) fail_msg("%s", err.text);
}

static void texts_for_other_programs_are_alike(void **state) {
  (void)state;
  if (!made) skip();
  static const char *const name[] = {"plot.gp", "run.xmf", "view.html"};
  struct em_run_file *run = NULL;
  struct em_error err = {0};
  if (em_run_file_open(&run, digest_path("point.h5"), &err)) fail_msg("%s", err.text);
  for (int what = 0; what < 3; what++) {
    char *text[2];
    for (int k = 0; k < 2; k++) {
      const char *path = digest_path(name[what]);
      with_comma(k);
      draw(run, what, path);
      is_comma(k);
      text[k] = text_of(path);
    }
    with_comma(false);
    assert_string_equal(text[0], text[1]);
    free(text[0]);
    free(text[1]);
  }
  em_run_file_close(run);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(scenes_are_read_and_printed_alike),
      cmocka_unit_test(errors_and_targets_have_points),
      cmocka_unit_test(runs_are_recorded_alike),
      cmocka_unit_test(texts_for_other_programs_are_alike),
  };
  return cmocka_run_group_tests(tests, make_locale, remove_folder);
}
