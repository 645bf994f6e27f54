/* Hard first contacts of pairs and with the drum, against 60 digits: grazing, multiple roots,
 * gravity over many orders of magnitude and down to none. */
int unit_main(void);
#define main unit_main
#include "unit/test_surface.c"
#undef main

#include "support/trial.h"

static void row(const char *name, const char *hard, double tries, const struct tally *tally) {
  hard_row(name, hard, tries, "none missed, none invented, against 60 digits",
           "%.1f ε of the place; %ld within rounding of a miss", tally->worst_place, tally->grazes);
}

static void grazing_pairs(void **state) {
  (void)state;
  srand48(101);
  struct tally tally = {0};
  const uint64_t tries = TRIES(40000, 1e7);
  for (uint64_t n = 0; n < tries; n++) {
    pair_make(1.0 + (n % 16 == 0 ? 0.0 : sign() * spread(1e-16, 1e-9)));
    pair_reference();
    verify(em_surface_pair(pair_r, pair_v, pair_sigma), pair_size, 0, &tally);
  }
  row("grazing pairs", "impact parameter 1 ± 1e-16…1e-9", (double)tries, &tally);
}

/* Contacts in the world itself: pairs far from each other, all nearly tangent. */
static struct em_vec world_r, world_v;

struct meeting {
  double *time;
};

static void met(void *self, const struct em_contact *c) {
  struct meeting *m = self;
  if (c->cls == EM_CLASS_BALL && m->time[c->ball / 2] == INFINITY) m->time[c->ball / 2] = c->time;
}

enum { EDGE = 12, PAIRS = EDGE * EDGE * EDGE };

static void place_pairs(struct em_balls *b, double d) {
  for (int k = 0; k < PAIRS; k++) {
    const double at[3] = {k % EDGE, k / EDGE % EDGE, k / EDGE / EDGE};
    struct em_vec middle = {(at[0] + 0.5) * 8.0 * d, (at[1] + 0.5) * 8.0 * d,
                            (at[2] + 0.5) * 8.0 * d};
    const struct em_vec e = direction(), other = em_vec_cross(e, direction());
    const struct em_vec side = em_vec_scale(1.0 / em_vec_norm(other), other);
    const double impact = 1.0 + sign() * spread(1e-16, 1e-6);
    const struct em_vec half =
        em_vec_axpy(em_vec_scale(-uniform(0.4, 1.2) * d, e), 0.5 * impact * d, side);
    b->position[2 * k] = em_vec_sub(middle, half);
    b->position[2 * k + 1] = em_vec_add(middle, half);
    const double speed = spread(0.1, 1.0);
    b->velocity[2 * k] = em_vec_scale(-0.5 * speed, e);
    b->velocity[2 * k + 1] = em_vec_scale(0.5 * speed, e);
  }
}

static void grazing_in_world(void **state) {
  (void)state;
  srand48(102);
  const double d = 0.01;
  const int rounds = (int)TRIES(4, 100);
  static double time[PAIRS];
  struct tally tally = {0};
  for (int round = 0; round < rounds; round++) {
    struct trial t;
    struct meeting meeting = {time};
    const struct em_observer observer = {&meeting, met};
    trial_scene(&t,
                "gravity=\"none\";chamber={shape=\"box\";size=[0.96,0.96,0.96];};"
                "contact={rule=\"smooth\";normal=1.0;};balls={count=3456;diameter=0.01;};",
                "gravity=[0.0,0.0,%s] engine.simd=%s", round & 1 ? "-9.81" : "0.0",
                round & 2 ? "false" : "true");
    trial_balls(&t);
    place_pairs(t.balls, d);
    for (int k = 0; k < PAIRS; k++)
      time[k] = INFINITY;
    trial_world(&t);
    assert_int_equal(em_world_observe(t.world, &observer), EM_OK);
    trial_run(&t, 0.03);
    for (int k = 0; k < PAIRS; k++) {
      const struct em_balls *b = t.balls;
      world_r = em_vec_sub(b->position[2 * k + 1], b->position[2 * k]);
      world_v = em_vec_sub(b->velocity[2 * k + 1], b->velocity[2 * k]);
      pair_r = world_r, pair_v = world_v, pair_sigma = d;
      pair_reference();
      double at = time[k];
      if (ref.rises && mpfr_get_d(ref.rise, MPFR_RNDN) > 0.02) continue; /* beyond the run */
      verify(at, pair_size, 0, &tally);
    }
    trial_free(&t);
  }
  row("grazing pairs in a world", "impact parameter 1 ± 1e-16…1e-6, with and without gravity",
      (double)rounds * PAIRS, &tally);
}

static void worst_of(struct tally *worst, const struct tally *each) {
  for (int k = 0; k < EM_QUARTIC_SURE; k++) {
    worst->worst_place = fmax(worst->worst_place, each[k].worst_place);
    worst->grazes += each[k].grazes;
  }
}

/* An apex at the top of the drum, 1 ± 1e-16…1e-9 of its radius; where v² = g ρ, the root is
 * fourfold. */
static void touching_apex(void **state) {
  (void)state;
  srand48(103);
  struct tally each[EM_QUARTIC_SURE] = {0}, worst = {0};
  const uint64_t tries = TRIES(5000, 1e6);
  for (uint64_t n = 0; n < tries; n++) {
    drum = (struct drum){.rho = spread(1e-2, 1.0)};
    const double fall = spread(1e-2, 1e2);
    const double share = n % 3 == 0 ? 1.0 : n % 3 == 1 ? 1.0 - spread(1e-16, 1e-6) : drand48();
    const double along = sqrt(share * fall * drum.rho);
    const double before = uniform(0.01, 0.5) * sqrt(drum.rho / fall);
    const double height = drum.rho * (1.0 + (n % 5 == 0 ? 0.0 : sign() * spread(1e-16, 1e-9)));
    drum.gz = -fall;
    drum.vx = along;
    drum.vz = fall * before;
    drum.px = -along * before;
    drum.pz = height - 0.5 * fall * before * before;
    if (hypot(drum.px, drum.pz) >= drum.rho) continue;
    drum_check(each);
  }
  worst_of(&worst, each);
  row("apex at the drum", "double to fourfold roots, three solvers", (double)tries, &worst);
}

static void many_orders(void **state) {
  (void)state;
  srand48(104);
  struct tally each[EM_QUARTIC_SURE] = {0}, worst = {0};
  const uint64_t tries = TRIES(5000, 1e6);
  for (uint64_t n = 0; n < tries; n++) {
    drum = (struct drum){.rho = spread(1e-6, 1e6)};
    place(n % 3 ? sqrt(drand48()) * 0.999 : 1.0 - spread(1e-15, 1e-3));
    aim(spread(1e-9, 1e6), spread(1e-12, 1e6));
    if (hypot(drum.px, drum.pz) >= drum.rho) continue;
    drum_check(each);
  }
  worst_of(&worst, each);
  row("quartic over many orders", "radius 1e-6…1e6 m, speed 1e-9…1e6, gravity 1e-12…1e6",
      (double)tries, &worst);
}

/* The contact with little gravity goes over into that with none. */
static void weightless_limit(void **state) {
  (void)state;
  srand48(105);
  double worst = 0.0;
  const uint64_t tries = TRIES(20000, 1e6);
  for (uint64_t n = 0; n < tries; n++) {
    drum = (struct drum){.rho = 0.07};
    place(sqrt(drand48()) * 0.99);
    const double speed = spread(1e-2, 10.0);
    aim(speed, 0.0);
    const double t0 = drum_time(EM_QUARTIC_SAFE, INFINITY);
    for (double fall = 1e-2; fall > 1e-300; fall *= 1e-3) {
      if (fall * t0 * t0 > 1e-3 * drum.rho) continue;
      drum.gx = 0.6 * fall;
      drum.gz = -0.8 * fall;
      const double t = drum_time(EM_QUARTIC_SAFE, INFINITY);
      /* At the wall the ball moves outwards at ≥ v √(1 − 0.99²), and ½ g t² displaces it. */
      const double out = speed * sqrt(1.0 - 0.99 * 0.99);
      const double bound = fall * t0 * t0 / out + 64.0 * DBL_EPSILON * t0 * speed / out;
      assert_true(fabs(t - t0) <= bound);
      if (fall < 1e-18) worst = fmax(worst, fabs(t - t0) / t0);
    }
  }
  hard_row("weightless limit", "gravity 1e-2 down to 1e-300", (double)tries,
           "the contact goes over into that of a straight path", "time %.1e", worst);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(grazing_pairs),    cmocka_unit_test(grazing_in_world),
      cmocka_unit_test(touching_apex),    cmocka_unit_test(many_orders),
      cmocka_unit_test(weightless_limit),
  };
  hard_choose();
  reference_init(&ref);
  const int failed = cmocka_run_group_tests(tests, NULL, NULL);
  reference_clear(&ref);
  return failed;
}
