/* Extreme mixtures, packings and lengths of time; and walls, again and again. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "support/trial.h"

#define BOX "gravity=\"none\";contact={rule=\"smooth\";normal=1.0;};"

/* Runs an elastic scene; the relative error of its energy. */
static double run(const char *scene, const char *overrides, uint64_t collisions, double smallest,
                  double *time) {
  struct trial t;
  trial_open(&t, scene, "%s", overrides);
  const double energy = trial_energy(&t);
  for (int k = 0; k < 20; k++) {
    trial_collide(&t, collisions / 20);
    trial_valid(&t, 1e-12 * smallest);
  }
  const double error = fabs(trial_energy(&t) - energy) / energy;
  if (time) *time = em_world_time(t.world);
  trial_free(&t);
  return error;
}

static void sizes(void **state) {
  (void)state;
  const uint64_t n = TRIES(60000, 5e6);
  const double error = run(BOX "chamber={shape=\"box\";size=[0.06,0.06,0.06];};"
                               "balls=({name=\"large\";count=4;diameter=0.02;},"
                               "{name=\"small\";count=2000;diameter=0.0004;});",
                           "", n, 0.0004, NULL);
  assert_true(error < 1e-12);
  hard_row("diameters 1:50", "4 large and 2000 small balls", (double)n,
           "no overlap above 1e-12 of the small diameter", "energy %.1e", error);
}

static void masses(void **state) {
  (void)state;
  const uint64_t n = TRIES(60000, 5e6);
  const double error = run(BOX "chamber={shape=\"box\";size=[0.06,0.06,0.06];};"
                               "balls=({name=\"heavy\";count=20;diameter=0.004;density=1e9;},"
                               "{name=\"light\";count=500;diameter=0.004;density=1.0;});",
                           "", n, 0.04, NULL);
  assert_true(error < 1e-12);
  hard_row("masses 1:1e9", "20 heavy and 500 light balls, these at up to 3e4 the speed", (double)n,
           "no overlap above 1e-11 d", "energy %.1e", error);
}

/* The same scene in units of 2^a m, 2^b s, 2^c kg: not a bit differs but in the exponents. */
static uint64_t in_units(int a, int b, int c, double *lost) {
  const double l = exp2(a), v = exp2(a - b), f = exp2(-b);
  char text[2048];
  snprintf(text, sizeof text,
           "gravity=[0.0,0.0,%.17g];chamber={shape=\"drum\";diameter=%.17g;length=%.17g;};"
           "rotor={rpm=%.17g;radius=%.17g;reach=%.17g;blades=({y=%.17g;},{y=%.17g;angle_deg=90.0;"
           "});};balls={count=200;diameter=%.17g;density=%.17g;speed=%.17g;};"
           "contact={rule=\"rough\";normal=0.9;};remedy={jam_within=%.17g;};",
           -9.5 * v * f, 0.125 * l, 0.125 * l, 1300.0 * f, 0.0078125 * l, 0.046875 * l, 0.03125 * l,
           0.09375 * l, 0.0078125 * l, 7850.0 * exp2(c) / l / l / l, v, 1e-8 / f);
  struct trial t;
  trial_open(&t, text, "%s", "");
  trial_run(&t, 0.05 / f);
  trial_valid(&t, 1e-12 * 0.0078125 * l);
  *lost = em_world_tally(t.world)->lost[EM_CLASS_BALL] / (exp2(c) * v * v);
  const uint64_t count = em_world_collisions(t.world);
  trial_free(&t);
  return count;
}

static void units(void **state) {
  (void)state;
  static const int unit[][3] = {{170, 170, 480}, {-170, -170, -480}, {235, 0, 0},
                                {-225, 0, 0},    {330, 330, 0},      {-330, -330, 0},
                                {0, 200, 0},     {0, -220, 0},       {0, 0, 450},
                                {0, 0, -450},    {200, 180, 100},    {-200, -240, 100}};
  enum { UNITS = sizeof unit / sizeof *unit };
  double lost, scaled;
  const uint64_t count = in_units(0, 0, 0, &lost);
  assert_true(count > 1000);
  for (int k = 0; k < UNITS; k++) {
    assert_int_equal(in_units(unit[k][0], unit[k][1], unit[k][2], &scaled), count);
    assert_true(scaled == lost);
  }
  hard_row("units", "the mill in units of 2^±330 m, 2^±330 s, 2^±480 kg", UNITS,
           "the same collisions, to the bit", "%.0f differ", 0.0);
}

static void few(void **state) {
  (void)state;
  struct trial t;
  trial_open(&t, "geometries/simoloyer-2l.cfg", "balls.count=0");
  trial_run(&t, 10.0);
  assert_int_equal(em_world_collisions(t.world), 0);
  trial_free(&t);
  trial_open(&t, "geometries/simoloyer-2l.cfg", "balls.count=1 remedy.tc=1e-5");
  const double energy = trial_energy(&t);
  trial_run(&t, 10.0);
  trial_valid(&t, 1e-12 * 0.005);
  const double books = fabs(trial_books(&t, energy));
  assert_true(books < 1e-12);
  hard_row("no ball, one ball",
           "the mill for 10 s, with TC: a lone ball comes to glide along the drum", 2,
           "runs; energy + lost − work", "%.1e", books);
  trial_free(&t);
}

static void just_fits(void **state) {
  (void)state;
  double worst = 0.0;
  const uint64_t n = TRIES(20000, 1e6);
  for (int k = 0; k < 4; k++) {
    static const double spare[] = {1e-4, 1e-8, 1e-12, 1e-15};
    char overrides[128];
    snprintf(overrides, sizeof overrides, "chamber.length=%.17g", 0.005 + spare[k]);
    worst =
        fmax(worst, run(BOX "chamber={shape=\"drum\";diameter=0.1;length=0.006;};"
                            "balls={diameter=0.005;start=\"table\";table=((0.0,"
                            "0.0025,0.0,1.0,1e-6,0.3),(0.02,0.0025,0.0,-0.2,1e-6,0.3));};"
                            "remedy={collapse_after=2000000000;};", /* they do touch that often */
                        overrides, n, 0.005, NULL));
  }
  assert_true(worst < 1e-11);
  hard_row("balls just fit", "1e-15…1e-4 m of play between the end walls", 4.0 * (double)n,
           "no overlap above 1e-12 d", "energy %.1e", worst);
}

static void crystal(void **state) {
  (void)state;
  const uint64_t n = TRIES(100000, 1e7);
  double time;
  const double d = 0.005, cell = cbrt(4.0 * M_PI / 6.0 * d * d * d / 0.70);
  struct trial t;
  trial_scene(&t,
              BOX "chamber={shape=\"box\";size=[0.1,0.1,0.1];periodic=true;};"
                  "balls={count=1372;diameter=0.005;start=\"lattice\";};",
              "chamber.size=[%.17g,%.17g,%.17g]", 7.0 * cell, 7.0 * cell, 7.0 * cell);
  t.balls = em_start_new(1372);
  uint64_t seed = 9;
  for (size_t i = 0; i < 1372; i++) {
    static const double part[4][3] = {{0, 0, 0}, {0.5, 0.5, 0}, {0.5, 0, 0.5}, {0, 0.5, 0.5}};
    const size_t c = i / 4;
    t.balls->position[i] = em_vec_make(((double)(c % 7) + part[i % 4][0] + 0.25) * cell,
                                       ((double)(c / 7 % 7) + part[i % 4][1] + 0.25) * cell,
                                       ((double)(c / 49) + part[i % 4][2] + 0.25) * cell);
    t.balls->velocity[i] = dice_direction(&seed);
    t.balls->radius[i] = 0.5 * d;
    t.balls->mass[i] = em_start_mass(&t.scene->species[0]);
  }
  trial_world(&t);
  const double energy = trial_energy(&t);
  for (int k = 0; k < 20; k++) {
    trial_collide(&t, n / 20);
    trial_valid(&t, 1e-12 * d);
  }
  const double error = fabs(trial_energy(&t) - energy) / energy;
  time = em_world_time(t.world);
  trial_free(&t);
  assert_true(error < 1e-12);
  hard_row("crystal", "packing 0.70 (fcc, periodic)", (double)n, "no overlap above 1e-12 d",
           "energy %.1e, %.3g s", error, time);
}

/* Says in the log of a long form how far it is. */
static void progress(const char *what, uint64_t done, double error) {
#ifdef LONG_FORM
  printf("  %s: %.3e, energy %.1e\n", what, (double)done, error);
  fflush(stdout);
#else
  (void)what, (void)done, (void)error;
#endif
}

/* How far from its wall a ball's surface was when it hit it: a ball that is inside the wall, or has
 * not reached it, was corrected, is lost, or hit nothing. */
struct watch {
  double rho, length, worst;
  uint64_t contacts;
};

static void at_wall(void *self, const struct em_contact *c) {
  struct watch *w = self;
  if (c->cls == EM_CLASS_BALL) return;
  const double off = c->cls == EM_CLASS_DRUM
                         ? sqrt(c->place.x * c->place.x + c->place.z * c->place.z) - w->rho
                     : c->partner & 1 ? c->place.y - w->length
                                      : c->place.y;
  w->worst = fmax(w->worst, fabs(off));
  w->contacts++;
}

/* `contacts` with walls, of 10 balls in a drum; each of them is looked at. */
static double hit_walls(const char *overrides, uint64_t contacts, double *off) {
  struct trial t;
  struct watch watch = {0.073, 0.135, 0.0, 0};
  const struct em_observer observer = {&watch, at_wall};
  const uint64_t part = contacts / 100;
  trial_open(&t,
             "gravity=\"none\";contact={rule=\"smooth\";normal=1.0;};"
             "chamber={shape=\"drum\";diameter=0.146;length=0.135;};"
             "balls={count=10;diameter=0.005;};",
             "%s", overrides);
  assert_int_equal(em_world_observe(t.world, &observer), EM_OK);
  const double energy = trial_energy(&t);
  double error = 0.0;
  while (watch.contacts < contacts) {
    trial_collide(&t, part);
    trial_valid(&t, 1e-12 * 0.005);
    assert_true(watch.worst <= 1e-12 * 0.005);
    error = fabs(trial_energy(&t) - energy) / energy;
    progress("contacts with walls", watch.contacts, error);
  }
  const struct em_tally *tally = em_world_tally(t.world);
  assert_int_equal(tally->collisions[EM_CLASS_DRUM] + tally->collisions[EM_CLASS_END],
                   watch.contacts);
  *off = fmax(*off, watch.worst / 0.005);
  trial_free(&t);
  /* Each contact of a ball costs it at most a rounding of its energy. */
  assert_true(error < 2.3e-16 * (double)contacts / 10.0);
  return error;
}

static void walls(void **state) {
  (void)state;
  const uint64_t n = TRIES(1000000, 1e9);
  double off = 0.0;
  const double without = hit_walls("", n / 2, &off);
  const double with = hit_walls("gravity=[0.0,0.0,-9.81] balls.speed=3", n / 2, &off);
  hard_row("walls", "10 balls in a drum, with and without gravity", (double)n,
           "each at its wall; balls outside: 0; overlaps above 1e-12 d: 0; no place corrected",
           "%.1e d off the wall; energy %.1e without, %.1e with gravity", off, without, with);
}

static const char gas_box[] =
    "contact={rule=\"smooth\";normal=1.0;};chamber={shape=\"box\";size=[0.08,0.08,0.08];};"
    "balls={count=1000;diameter=0.005;};";

/* The error of the energy after so many collisions of a gas of 1000 balls. */
static double gas(const char *overrides, uint64_t collisions) {
  struct trial t;
  trial_open(&t, gas_box, "%s", overrides);
  const double energy = trial_energy(&t), bytes = em_world_bytes_per_ball(t.world);
  double error = 0.0;
  for (int k = 0; k < 100; k++) {
    trial_collide(&t, collisions / 100);
    trial_valid(&t, 1e-12 * 0.005);
    error = fabs(trial_energy(&t) - energy) / energy;
    progress("collisions of a gas", em_world_collisions(t.world), error);
  }
  assert_true(em_world_bytes_per_ball(t.world) < 2.0 * bytes);
  trial_free(&t);
  return error;
}

static void gas_falling(void **state) {
  (void)state;
  const uint64_t n = TRIES(200000, 1e8);
  const double error = gas("gravity=[0.0,0.0,-9.81]", n);
  assert_true(error < 1e-11);
  hard_row("gas under gravity", "1000 elastic balls in a box", (double)n,
           "no overlap above 1e-12 d; energy within 1e-11; list sizes bounded", "energy %.1e",
           error);
}

static void gas_long(void **state) {
  (void)state;
  const uint64_t n = TRIES(200000, 1e9);
  const double error = gas("gravity=\"none\"", n);
  assert_true(error < 1e-11);
  hard_row("gas", "1000 elastic balls in a box", (double)n,
           "no overlap above 1e-12 d; list sizes bounded", "energy %.1e", error);
}

/* What a world holds and shows, `shift` epochs later. */
static void same_later(const struct em_world *one, const struct em_world *two, uint64_t shift) {
  struct em_snapshot *a, *b;
  struct em_error err;
  assert_int_equal(em_world_snapshot(one, &a, &err), EM_OK);
  assert_int_equal(em_world_snapshot(two, &b, &err), EM_OK);
  assert_true(b->epoch == a->epoch + shift && a->clock == b->clock);
  assert_memory_equal(a->position, b->position, a->count * sizeof *a->position);
  assert_memory_equal(a->velocity, b->velocity, a->count * sizeof *a->velocity);
  assert_memory_equal(a->spin, b->spin, a->count * sizeof *a->spin);
  assert_memory_equal(a->time, b->time, a->count * sizeof *a->time);
  assert_memory_equal(a->blade_angle, b->blade_angle, a->blade_count * sizeof *a->blade_angle);
  em_world_snapshot_free(a);
  em_world_snapshot_free(b);
}

/* A mill that has run for 2^24 s (half a year) or 2^30 s (34 years): nothing depends on absolute
 * time. Times that are asked for are multiples of 2^-16 s, which doubles of that size hold. */
static void late(void **state) {
  (void)state;
  const int parts = (int)TRIES(20, 1000);
  uint64_t collisions = 0;
  for (int k = 0; k < 2; k++) {
    struct trial t;
    struct em_snapshot *s;
    struct em_world *later;
    trial_open(&t, "geometries/simoloyer-2l.cfg", "balls.count=300 rotor.rpm=1300");
    trial_run(&t, 0.0625);
    assert_int_equal(em_world_snapshot(t.world, &s, &t.err), EM_OK);
    assert_true(s->epoch > 0);
    const double past = k ? 0x1p30 : 0x1p24;
    const double length = (em_world_time(t.world) - s->clock) / (double)s->epoch;
    const uint64_t shift = (uint64_t)(past / length);
    assert_true((double)shift * length == past);
    s->epoch += shift;
    assert_int_equal(em_world_resume(&later, t.scene, s, &t.err), EM_OK);
    em_world_snapshot_free(s);
    struct em_balls *shown = em_start_new(300);
    for (int part = 1; part <= parts; part++) {
      const double until = 0.0625 + part * 0x1p-10 + 0x1p-16 * part;
      trial_run(&t, until);
      assert_int_equal(em_world_run(later, past + until, NULL, &t.err), EM_OK);
      same_later(t.world, later, shift);
      em_world_state(t.world, until, t.balls);
      em_world_state(later, past + until, shown);
      assert_memory_equal(shown->position, t.balls->position, 300 * sizeof *shown->position);
    }
    collisions += em_world_collisions(t.world);
    em_start_free(shown);
    em_world_free(later);
    trial_free(&t);
  }
  hard_row("late", "the mill after 2^24 and 2^30 s (34 years); collisions:", (double)collisions,
           "all that the engine holds and shows is that of an early mill, to the bit", "0");
}

/* Much simulated time: the error must not grow with absolute time. */
static void long_time(void **state) {
  (void)state;
  const double until = (double)TRIES(60, 3600);
  struct trial t;
  trial_open(&t,
             "gravity=[0.0,0.0,-9.81];contact={rule=\"smooth\";normal=1.0;};"
             "chamber={shape=\"drum\";diameter=0.146;length=0.135;};"
             "balls={count=20;diameter=0.005;speed=2.0;};",
             "%s", "");
  const double energy = trial_energy(&t), bytes = em_world_bytes_per_ball(t.world);
  double first = 0.0, last = 0.0, before = energy;
  for (int k = 1; k <= 20; k++) {
    trial_run(&t, until * k / 20.0);
    trial_valid(&t, 1e-12 * 0.005);
    const double now = trial_energy(&t), step = fabs(now - before) / energy;
    if (k <= 5) first = fmax(first, step);
    if (k > 15) last = fmax(last, step);
    before = now;
  }
  assert_true(fabs(before - energy) / energy < 1e-10);
  assert_true(last < 10.0 * first + 1e-13);
  assert_true(em_world_bytes_per_ball(t.world) < 2.0 * bytes);
  hard_row("long time", "20 balls in the drum under gravity; simulated seconds:", until,
           "energy, places and list sizes stay bounded",
           "energy %.1e in all, %.1e in the first parts, %.1e in the last ones",
           fabs(before - energy) / energy, first, last);
  trial_free(&t);
}

#ifdef LONG_FORM
static void million(void **state) {
  (void)state;
  const double error = run(BOX "chamber={shape=\"box\";size=[1.0,1.0,1.0];};"
                               "balls={count=1000000;diameter=0.005;start=\"lattice\";};",
                           "", 3000000, 0.005, NULL);
  assert_true(error < 1e-12);
  hard_row("10⁶ balls", "elastic gas in a box", 3e6, "no overlap above 1e-12 d", "energy %.1e",
           error);
}
#endif

int main(void) {
  const struct CMUnitTest tests[] = {
#ifdef LONG_FORM
      cmocka_unit_test(million),
#endif
      cmocka_unit_test(sizes),     cmocka_unit_test(masses),      cmocka_unit_test(few),
      cmocka_unit_test(just_fits), cmocka_unit_test(crystal),     cmocka_unit_test(late),
      cmocka_unit_test(long_time), cmocka_unit_test(gas_falling), cmocka_unit_test(walls),
      cmocka_unit_test(gas_long),  cmocka_unit_test(units),
  };
  hard_choose();
  return cmocka_run_group_tests(tests, NULL, NULL);
}
