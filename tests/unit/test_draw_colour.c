/* Colour maps: even to the eye, and lighter all the way. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "eventmill/colour.h"

static double linear(uint8_t v) {
  const double u = v / 255.0;
  return u <= 0.04045 ? u / 12.92 : pow((u + 0.055) / 1.055, 2.4);
}

/* CIE 1976 L*, a*, b* under D65, by the standard's own numbers: not the space the maps are made in.
 */
static void to_lab(const uint8_t *c, double lab[3]) {
  static const double m[3][3] = {{0.4124564, 0.3575761, 0.1804375},
                                 {0.2126729, 0.7151522, 0.0721750},
                                 {0.0193339, 0.1191920, 0.9503041}};
  static const double white[3] = {0.95047, 1.0, 1.08883};
  double f[3];
  for (int k = 0; k < 3; k++) {
    const double t =
        (m[k][0] * linear(c[0]) + m[k][1] * linear(c[1]) + m[k][2] * linear(c[2])) / white[k];
    f[k] = t > 0.008856 ? cbrt(t) : 7.787 * t + 16.0 / 116.0;
  }
  lab[0] = 116.0 * f[1] - 16.0;
  lab[1] = 500.0 * (f[0] - f[1]);
  lab[2] = 200.0 * (f[1] - f[2]);
}

static void lightness_rises(void **state) {
  static const enum em_colour rising[] = {EM_COLOUR_LAGOON, EM_COLOUR_EMBER, EM_COLOUR_GREY};
  (void)state;
  for (size_t n = 0; n < 3; n++) {
    struct em_colour_map map;
    double first[3], last[3], before = -1.0;
    em_colour_make(rising[n], &map);
    for (int k = 0; k < EM_COLOUR_STEPS; k++) {
      double lab[3];
      to_lab(map.rgb[k], lab);
      /* 8 bits per channel leave an uncertainty of a quarter of a unit. */
      assert_true(lab[0] > before - 0.25);
      before = lab[0];
    }
    to_lab(map.rgb[0], first);
    to_lab(map.rgb[EM_COLOUR_STEPS - 1], last);
    assert_true(last[0] - first[0] > 55.0);
  }
}

/* Stretches of 16 entries are about as long as each other, in a space other than the maps' own. */
static void steps_are_even(void **state) {
  (void)state;
  for (int which = 0; which < EM_COLOUR_COUNT; which++) {
    struct em_colour_map map;
    double least = INFINITY, most = 0.0;
    em_colour_make((enum em_colour)which, &map);
    for (int k = 0; k + 16 < EM_COLOUR_STEPS; k += 16) {
      double p[3], q[3];
      to_lab(map.rgb[k], p);
      to_lab(map.rgb[k + 16], q);
      const double d = sqrt((p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) +
                            (p[2] - q[2]) * (p[2] - q[2]));
      least = fmin(least, d);
      most = fmax(most, d);
    }
    assert_true(most < 3.2 * least);
  }
}

static void the_middle_of_a_difference_is_white(void **state) {
  struct em_colour_map map;
  double low[3], middle[3], high[3];
  (void)state;
  em_colour_make(EM_COLOUR_BALANCE, &map);
  to_lab(map.rgb[0], low);
  to_lab(em_colour_at(&map, 0.0, -1.0, 1.0), middle);
  to_lab(map.rgb[EM_COLOUR_STEPS - 1], high);
  assert_true(middle[0] > 92.0 && fabs(middle[1]) < 6.0 && fabs(middle[2]) < 6.0);
  assert_true(low[2] < -30.0 && high[1] > 40.0); /* blue, red */
  /* Both entries of the middle are without hue, and as far from their end. */
  for (int k = 127; k <= 128; k++) {
    to_lab(map.rgb[k], middle);
    assert_true(middle[0] > 92.0 && hypot(middle[1], middle[2]) < 0.5);
  }
}

static void values_find_their_entry(void **state) {
  struct em_colour_map map;
  (void)state;
  em_colour_make(EM_COLOUR_LAGOON, &map);
  assert_ptr_equal(em_colour_at(&map, -5.0, 0.0, 1.0), map.rgb[0]);
  assert_ptr_equal(em_colour_at(&map, NAN, 0.0, 1.0), map.rgb[0]);
  assert_ptr_equal(em_colour_at(&map, 0.5, 0.0, 1.0), map.rgb[128]);
  assert_ptr_equal(em_colour_at(&map, 1.0, 0.0, 1.0), map.rgb[255]);
  assert_ptr_equal(em_colour_at(&map, INFINITY, 0.0, 1.0), map.rgb[255]);
  assert_ptr_equal(em_colour_at(&map, 3.0, 2.0, 2.0), map.rgb[0]);
  for (int k = 0; k < EM_COLOUR_COUNT; k++)
    assert_int_equal(em_colour_find(em_colour_name((enum em_colour)k)), k);
  assert_int_equal(em_colour_find("mud"), -1);
  assert_memory_not_equal(em_colour_cycle(0), em_colour_cycle(1), 3);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(lightness_rises),
      cmocka_unit_test(steps_are_even),
      cmocka_unit_test(the_middle_of_a_difference_is_white),
      cmocka_unit_test(values_find_their_entry),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
