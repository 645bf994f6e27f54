/* Files that appear complete or not at all, and places that must not be replaced. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "draw_mill.h"
#include "record/output.h"

static size_t length_of(const char *path) {
  struct stat there;
  return stat(path, &there) == 0 ? (size_t)there.st_size : SIZE_MAX;
}

static void a_file_is_there_when_it_is_complete(void **state) {
  (void)state;
  struct em_output output;
  struct em_error err = {0};
  const char *path = draw_path("whole.txt");
  for (int good = 1; good >= 0; good--) {
    assert_int_equal(em_output_begin(&output, path, EM_OUTPUT_FILE, &err), EM_OK);
    char *temporary = strdup(output.temporary);
    fputs(good ? "all of it" : "some", output.out);
    assert_int_equal(length_of(path), good ? SIZE_MAX : 9);
    assert_int_equal(em_output_end(&output, good ? EM_OK : EM_NUMERIC, &err),
                     good ? EM_OK : EM_NUMERIC);
    assert_int_equal(length_of(path), 9);
    assert_int_equal(length_of(temporary), SIZE_MAX);
    free(temporary);
  }
  assert_int_equal(em_output_begin(&output, "/nowhere/x", EM_OUTPUT_STREAM, &err), EM_FILE);
}

static void a_link_stays_a_link(void **state) {
  (void)state;
  struct em_output output;
  struct em_error err = {0};
  struct stat there;
  const char *file = draw_path("file.txt"), *link = draw_path("link.txt");
  fclose(fopen(file, "w"));
  assert_int_equal(symlink(file, link), 0);
  assert_int_equal(em_output_begin(&output, link, EM_OUTPUT_STREAM, &err), EM_OK);
  fputs("three", output.out);
  assert_int_equal(em_output_end(&output, EM_OK, &err), EM_OK);
  assert_int_equal(lstat(link, &there), 0);
  assert_true(S_ISLNK(there.st_mode));
  assert_int_equal(length_of(file), 5);
}

static void a_pipe_is_written_to_and_stays(void **state) {
  (void)state;
  struct em_output output;
  struct em_error err = {0};
  struct stat there;
  char text[16] = "";
  const char *path = draw_path("pipe");
  assert_int_equal(mkfifo(path, 0600), 0);
  const int reader = open(path, O_RDONLY | O_NONBLOCK);
  assert_int_equal(em_output_begin(&output, path, EM_OUTPUT_FILE, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "regular file"));
  for (int good = 0; good < 2; good++) {
    assert_int_equal(em_output_begin(&output, path, EM_OUTPUT_STREAM, &err), EM_OK);
    fputs("hello", output.out);
    assert_int_equal(em_output_end(&output, good ? EM_OK : EM_NUMERIC, &err),
                     good ? EM_OK : EM_NUMERIC);
    assert_int_equal(read(reader, text, sizeof text), 5);
    assert_int_equal(stat(path, &there), 0);
    assert_true(S_ISFIFO(there.st_mode));
  }
  close(reader);
}

static void names_get_tags_before_their_ending(void **state) {
  (void)state;
  char text[32];
  em_output_name(text, sizeof text, "a.b/map.png", "2", NULL);
  assert_string_equal(text, "a.b/map-2.png");
  em_output_name(text, sizeof text, "a.b/map", "0004", NULL);
  assert_string_equal(text, "a.b/map-0004");
  em_output_name(text, sizeof text, "run.pvd", "0004", ".vtp");
  assert_string_equal(text, "run-0004.vtp");
  assert_string_equal(em_output_ending("a.b/map"), "");
  assert_string_equal(em_output_ending("a.b/map.png"), ".png");
}

static int clean(void **state) {
  (void)state;
  draw_clean();
  return 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_file_is_there_when_it_is_complete),
      cmocka_unit_test(a_link_stays_a_link),
      cmocka_unit_test(a_pipe_is_written_to_and_stays),
      cmocka_unit_test(names_get_tags_before_their_ending),
  };
  return cmocka_run_group_tests(tests, NULL, clean);
}
