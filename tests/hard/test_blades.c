/* The search for contacts with blades, where it is hard, against brute force with a certified
 * bound. */
#define CASES 2000
int unit_main(void);
#define main unit_main
#include "unit/test_surface_blade.c"
#undef main

#include "support/trial.h"

static void try(const char *name, const char *hard, uint64_t tries, struct flight (*make)(int n)) {
  struct tally tally = {0};
  for (uint64_t n = 0; n < tries; n++) {
    const struct flight f = make((int)(n % 1000003));
    if (f.blade.tip != EM_TIP_NONE && overlaps(&f)) continue;
    compare(&f, 0, &tally);
  }
  hard_row(name, hard, (double)tries, "none missed, none invented, against brute force",
           "gap %.1e m, %.1f steps, at most %ld", tally.worst,
           (double)tally.steps / (double)tally.cases, tally.most);
  assert_true(tally.hits > 0 && tally.open * 100 <= tally.cases);
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
  const uint64_t many = TRIES(3000, 1e6), few = TRIES(600, 1e5);
  try("blade: random flights", "any of three tips, 1…1000 rad/s", many, in_a_mill);
  try("blade: very fast", "1e3…1e6 rad/s, both ways", few, very_fast);
  try("blade: at rest", "0 and 1e-12…1e-2 rad/s", few, at_rest);
  try("blade: many turns", "balls at 1e-9…1e-2 m/s beside the blade", few, many_turns);
  try("blade: overtaking", "ball just ahead at (1 ± 1e-9…0.1) of its speed", few, overtaken);
  try("blade: along the bar", "flight parallel to the bar, close to it", few, along);
  try("blade: tip and rim", "flat, round and open ends from outside", few, tip);
  try("blade: near the shaft", "1e-12…1e-2 m from the axis", few, near_axis);
  try("blade: at the reach", "open tip, contact within 1e-8…1e-5 m of its end", few, at_the_reach);
  try("blade: through the gap", "passes at 1e-9…1e-3 m", few, through_gap);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(flights),
      cmocka_unit_test(touched),
      cmocka_unit_test(overlapping),
      cmocka_unit_test(grazing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
