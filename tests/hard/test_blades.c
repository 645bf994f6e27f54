/* The search for contacts with blades, where it is hard, against brute force with a certified
 * bound. */
#define CASES 2000
int unit_main(void);
#define main unit_main
#include "unit/test_surface_blade.c"
#undef main

#include "support/trial.h"

/* open: the share of flights on which brute force may lose its patience. */
static void try(const char *name, const char *hard, uint64_t tries, struct flight (*make)(int n),
                double open) {
  struct tally tally = {0};
  for (uint64_t n = 0; (uint64_t)tally.cases < tries; n++) {
    const struct flight f = make((int)(n % 1000003));
    if (f.blade.tip != EM_TIP_NONE && overlaps(&f)) continue;
    compare(&f, 0, &tally);
  }
  hard_row(name, hard, (double)tries, "none missed, none invented, against brute force",
           "gap %.1e m; %ld hits, %ld grazing, %ld open; %.1f steps, at most %ld", tally.worst,
           tally.hits, tally.grazes, tally.open, (double)tally.steps / (double)tally.cases,
           tally.most);
  assert_true(tally.hits > 0 && (double)tally.open <= open * (double)tally.cases);
}

/* Without an end of the bar: there a hair decides whether a touch counts. */
static struct flight grazes_closed(int n) {
  for (;;) {
    const struct flight f = grazes(n);
    if (f.blade.tip != EM_TIP_NONE) return f;
    n++;
  }
}

/* Through the gap between two blades that turn against each other: contacts with the one and the
 * other are searched on their own; here with the one that comes. */
static struct flight through_gap(int n) {
  struct flight f = machine(n, sign() * spread(10.0, 300.0));
  const double room = f.blade.radius + f.radius + spread(1e-9, 1e-3);
  put(&f, f.blade.reach * uniform(0.2, 1.1), n % 2 ? room : -room);
  const struct em_vec side = across(f.blade.axis);
  f.v =
      em_vec_axpy(em_vec_scale(spread(0.1, 10.0), side), sign() * spread(1e-9, 1e-1), f.blade.axis);
  return f;
}

static void flights(void **state) {
  (void)state;
  srand48(201);
  const uint64_t many = TRIES(3000, 1e8), few = TRIES(600, 1e5);
  try("blade: very fast", "1e3…1e6 rad/s, both ways", few, very_fast, 0.01);
  try("blade: at rest", "0 and 1e-12…1e-2 rad/s", few, at_rest, 0.01);
  try("blade: many turns", "balls at 1e-9…1e-2 m/s beside the blade", few, many_turns, 0.01);
  try("blade: overtaking", "ball just ahead at (1 ± 1e-9…0.1) of its speed", few, overtaken, 0.01);
  try("blade: along the bar", "flight parallel to the bar, close to it", few, along, 0.01);
  try("blade: tip and rim", "flat, round and open ends from outside", few, tip, 0.01);
  try("blade: near the shaft", "1e-12…1e-2 m from the axis", few, near_axis, 0.01);
  try("blade: at the reach", "open tip, contact within 1e-8…1e-5 m of its end", few, at_the_reach,
      0.01);
  try("blade: through the gap", "passes at 1e-9…1e-3 m", few, through_gap, 0.01);
  try("blade: grazing", "touches up to 1e-16…1e-12 of the ball's radius", few, grazes_closed, 0.04);
  try("blade: random flights", "any of three tips, 1…1000 rad/s", many, in_a_mill, 0.01);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(flights),
      cmocka_unit_test(touched),
      cmocka_unit_test(overlapping),
      cmocka_unit_test(grazing),
  };
  hard_choose();
  return cmocka_run_group_tests(tests, NULL, NULL);
}
