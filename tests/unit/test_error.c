/* Error reports: form, several lines, truncation, absent report. */
#include <limits.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "eventmill/error.h"

static void set_fills_code_place_and_text(void **state) {
  (void)state;
  struct em_error err;
  memset(&err, 'x', sizeof err); /* set does not need a clean report */
  enum em_status status = em_error_set(&err, EM_INPUT, "a.cfg", 7, "%d balls, %s", 3, "expected 2");
  assert_int_equal(status, EM_INPUT);
  assert_int_equal(err.code, EM_INPUT);
  assert_int_equal(err.line, 7);
  assert_string_equal(err.file, "a.cfg");
  assert_string_equal(err.text, "a.cfg:7: error: 3 balls, expected 2");
}

static void set_replaces_what_was_there(void **state) {
  (void)state;
  struct em_error err;
  em_error_set(&err, EM_INPUT, "a.cfg", 7, "first");
  em_error_set(&err, EM_MEMORY, NULL, 0, "second");
  assert_int_equal(err.code, EM_MEMORY);
  assert_int_equal(err.line, 0);
  assert_string_equal(err.file, "");
  assert_string_equal(err.text, "error: second");
}

static void place_is_optional(void **state) {
  (void)state;
  struct em_error err;
  em_error_set(&err, EM_FILE, "run.h5", 0, "disk full");
  assert_string_equal(err.text, "run.h5: error: disk full");
  em_error_set(&err, EM_FILE, NULL, 3, "no file, no line");
  assert_string_equal(err.text, "error: no file, no line");
}

static void add_appends_lines_and_keeps_first_code(void **state) {
  (void)state;
  struct em_error err = {.code = EM_OK};
  assert_int_equal(em_error_add(&err, EM_INPUT, "a.cfg", 2, "one"), EM_INPUT);
  assert_int_equal(em_error_add(&err, EM_MEMORY, "a.cfg", 5, "two"), EM_MEMORY);
  assert_int_equal(err.code, EM_INPUT);
  assert_int_equal(err.line, 2);
  assert_string_equal(err.text, "a.cfg:2: error: one\na.cfg:5: error: two");
}

static void long_texts_are_cut(void **state) {
  (void)state;
  static char text[2 * EM_ERROR_TEXT];
  memset(text, 'a', sizeof text - 1);
  struct {
    struct em_error err;
    char guard[16];
  } box;
  memset(box.guard, 'g', sizeof box.guard);
  em_error_set(&box.err, EM_INPUT, text, 1, "%s", text);
  assert_int_equal(strlen(box.err.file), EM_ERROR_FILE - 1);
  assert_int_equal(strlen(box.err.text), EM_ERROR_TEXT - 1);
  for (int i = 0; i < 3; ++i)
    em_error_add(&box.err, EM_INPUT, "b.cfg", i, "more");
  assert_int_equal(strlen(box.err.text), EM_ERROR_TEXT - 1);
  for (size_t i = 0; i < sizeof box.guard; ++i)
    assert_int_equal(box.guard[i], 'g');
}

static void many_lines_fill_up_to_the_end(void **state) {
  (void)state;
  struct em_error err = {.code = EM_OK};
  for (int i = 1; i <= 1000; ++i)
    em_error_add(&err, EM_INPUT, "a.cfg", i, "entry %d", i);
  assert_int_equal(strlen(err.text), EM_ERROR_TEXT - 1);
  assert_non_null(strstr(err.text, "a.cfg:100: error: entry 100\n"));
}

static void report_may_be_absent(void **state) {
  (void)state;
  assert_int_equal(em_error_set(NULL, EM_JAM, "a", 1, "text"), EM_JAM);
  assert_int_equal(em_error_add(NULL, EM_COLLAPSE, NULL, 0, "text"), EM_COLLAPSE);
}

static void every_status_has_its_own_text(void **state) {
  (void)state;
  for (int i = 0; i < EM_STATUS_COUNT; ++i) {
    assert_true(strlen(em_error_text((enum em_status)i)) > 0);
    for (int k = 0; k < i; ++k)
      assert_string_not_equal(em_error_text((enum em_status)i), em_error_text((enum em_status)k));
  }
  assert_string_equal(em_error_text(EM_OK), "done");
  assert_string_equal(em_error_text(EM_JAM), "jam without exit");
  assert_string_equal(em_error_text(EM_STATUS_COUNT), "unknown status");
  assert_string_equal(em_error_text((enum em_status)INT_MAX), "unknown status");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(set_fills_code_place_and_text),
      cmocka_unit_test(set_replaces_what_was_there),
      cmocka_unit_test(place_is_optional),
      cmocka_unit_test(add_appends_lines_and_keeps_first_code),
      cmocka_unit_test(long_texts_are_cut),
      cmocka_unit_test(many_lines_fill_up_to_the_end),
      cmocka_unit_test(report_may_be_absent),
      cmocka_unit_test(every_status_has_its_own_text),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
