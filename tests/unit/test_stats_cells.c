/* Cells: they fill the drum, have the volumes they claim, and every point is in its own. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>
#include <gsl/gsl_rng.h>

#include "eventmill/cells.h"

#define assert_near(a, b, tolerance) assert_true(fabs((a) - (b)) <= (tolerance))

static const double R = 0.073, L = 0.135;

static void fills_the_drum(const struct em_cells *cells) {
  double sum = 0.0;
  for (size_t k = 0; k < cells->count; k++) {
    assert_true(em_cells_volume(cells, k) > 0.0);
    sum += em_cells_volume(cells, k);
  }
  assert_near(sum / (M_PI * R * R * L), 1.0, 1e-12);
}

static void points_are_in_their_cells(const struct em_cells *cells) {
  gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
  for (int i = 0; i < 100000; i++) {
    const double x = (2.0 * gsl_rng_uniform(rng) - 1.0) * R, y = gsl_rng_uniform(rng) * L;
    const double z = (2.0 * gsl_rng_uniform(rng) - 1.0) * R, r = hypot(x, z);
    const size_t k = em_cells_find(cells, x, y, z);
    if (r > R * (1.0 + 1e-6)) {
      assert_int_equal(k, cells->count);
      continue;
    }
    double low[3], high[3], angle = atan2(z, x);
    if (angle < 0.0) angle += 2.0 * M_PI;
    em_cells_bounds(cells, k, low, high);
    assert_true(low[0] <= r && r <= high[0] * (1.0 + 1e-6));
    assert_true(low[1] - 1e-12 <= angle && angle <= high[1] + 1e-12);
    assert_true(low[2] - 1e-15 <= y && y <= high[2] + 1e-15);
  }
  gsl_rng_free(rng);
}

static void sectors_have_equal_volumes(void **state) {
  (void)state;
  struct em_cells *cells = em_cells_sectors(R, L, 25, 2500, 3);
  assert_int_equal(cells->count, 7500);
  for (size_t k = 0; k < cells->count; k++)
    assert_near(em_cells_volume(cells, k) * 7500 / (M_PI * R * R * L), 1.0, 1e-11);
  for (size_t t = 0; t < 25; t++) /* tubes nearly of one width */
    assert_near((cells->edge[t + 1] - cells->edge[t]) * 25.0 / R, 1.0, 0.02);
  /* the outermost of 25 tubes holds 7.84 % of the volume */
  assert_near((double)cells->in_tube[24] / 2500.0, 0.0784, 1e-12);
  fills_the_drum(cells);
  points_are_in_their_cells(cells);
  em_cells_free(cells);
  for (size_t tubes = 1; tubes <= 8; tubes++) {
    cells = em_cells_sectors(R, L, tubes, tubes, 1);
    assert_non_null(cells);
    fills_the_drum(cells);
    points_are_in_their_cells(cells);
    em_cells_free(cells);
  }
  assert_null(em_cells_sectors(R, L, 10, 9, 1));
}

/* The source's 2000 became 33 × 61 = 2013. */
static void rings_are_square(void **state) {
  (void)state;
  struct em_cells *cells = em_cells_rings(R, L, 2000);
  assert_int_equal(cells->tubes, 33);
  assert_int_equal(cells->columns, 61);
  assert_int_equal(cells->count, 2013);
  fills_the_drum(cells);
  points_are_in_their_cells(cells);
  em_cells_free(cells);
  cells = em_cells_rings(R, L, 1);
  assert_true(cells->count >= 1);
  fills_the_drum(cells);
  em_cells_free(cells);
  assert_null(em_cells_rings(R, L, 0));
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(sectors_have_equal_volumes),
                                     cmocka_unit_test(rings_are_square)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
