/* How balls start: free of each other, of walls and blades; uniform where they should be;
 * directions without preference; given places as given; errors where there is no room. Seeds are
 * fixed, so each χ² has one value; it must lie between the quantiles 0.001 and 0.999. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <gsl/gsl_cdf.h>

#include "eventmill/start.h"

#define MILL                                                                           \
  "chamber = { diameter = 0.146; length = 0.135; };"                                   \
  "rotor = { rpm = 1300; radius = 0.006; reach = 0.058; tip = \"%s\"; blades = ("      \
  "{ y = 0.0225; }, { y = 0.045; angle_deg = 60; }, { y = 0.0675; angle_deg = 120; }," \
  "{ y = 0.09; angle_deg = 180; }, { y = 0.1125; angle_deg = 240; }); };"

#define DRUM "chamber = { diameter = 0.146; length = 0.135; };"
#define BOX  "chamber = { shape = \"box\"; size = [1, 1, 1]; periodic = %s; };"

struct started {
  struct em_scene *scene;
  struct em_balls *balls;
};

static struct em_scene *parse(const char *text) {
  struct em_scene *scene;
  struct em_error err = {0};
  if (em_scene_parse(&scene, text, "t.cfg", 0, NULL, &err) != EM_OK) fail_msg("%s", err.text);
  return scene;
}

static struct started start(const char *text) {
  struct started s = {.scene = parse(text)};
  struct em_error err = {0};
  if (em_start_make(&s.balls, s.scene, NULL, NULL, &err) != EM_OK)
    fail_msg("%s\n%s", text, err.text);
  return s;
}

static void end(struct started *s) {
  em_start_free(s->balls);
  em_scene_free(s->scene);
}

static double shortest(double d, double length, bool periodic) {
  return periodic ? d - length * rint(d / length) : d;
}

/* Every pair, every wall, every blade, without the cells that placing used. */
static void assert_free(const struct started *s, double clearance) {
  const struct em_balls *b = s->balls;
  const struct em_chamber *c = &s->scene->chamber;
  bool drum = c->shape == EM_SHAPE_DRUM;
  struct em_vec low, high;
  em_scene_bounds(s->scene, &low, &high);
  for (size_t i = 0; i < b->count; ++i) {
    struct em_vec p = b->position[i];
    double room = 0.999 * clearance * b->radius[i], r = b->radius[i] + room;
    assert_true(drum             ? hypot(p.x, p.z) <= high.x - r
                : c->periodic[0] ? p.x >= 0 && p.x < high.x
                                 : p.x >= low.x + r && p.x <= high.x - r);
    assert_true(!drum && c->periodic[1] ? p.y >= 0 && p.y < high.y
                                        : p.y >= low.y + r && p.y <= high.y - r);
    assert_true(!drum && c->periodic[2] ? p.z >= 0 && p.z < high.z
                                        : drum || (p.z >= low.z + r && p.z <= high.z - r));
    for (size_t k = 0; k < s->scene->rotor_count; ++k)
      for (size_t j = 0; j < s->scene->rotor[k].blade_count; ++j) {
        struct em_blade blade = s->scene->rotor[k].blade[j];
        blade.tip = blade.tip == EM_TIP_NONE ? EM_TIP_FLAT : blade.tip;
        assert_true(em_surface_blade_gap(&blade, p, b->radius[i], blade.angle) >= room);
      }
    for (size_t j = 0; j < i; ++j) {
      struct em_vec d = em_vec_sub(p, b->position[j]);
      d.x = shortest(d.x, high.x - low.x, !drum && c->periodic[0]);
      d.y = shortest(d.y, high.y - low.y, !drum && c->periodic[1]);
      d.z = shortest(d.z, high.z - low.z, !drum && c->periodic[2]);
      double sigma = b->radius[i] + b->radius[j];
      assert_true(em_vec_norm(d) >= sigma * (1.0 + 0.999 * clearance));
    }
  }
}

static double packed_diameter(double share, double count, double volume) {
  return cbrt(share * volume * 6.0 / (M_PI * count));
}

static void nothing_overlaps(void **state) {
  (void)state;
  static const char *const tips[] = {"flat", "hemisphere", "none"};
  static const char *const starts[] = {"uniform", "half", "lattice"};
  for (int t = 0; t < 3; ++t)
    for (int k = 0; k < 3; ++k) {
      char text[1024];
      snprintf(text, sizeof text,
               MILL "balls = { count = 3500; diameter = 0.005; start = \"%s\"; };", tips[t],
               starts[k]);
      struct started s = start(text);
      assert_int_equal(s.balls->count, 3500);
      assert_free(&s, 1e-9);
      end(&s);
    }
}

static void dense_starts(void **state) {
  (void)state;
  static const struct {
    const char *periodic, *start;
    int count;
    double share;
  } cases[] = {{"true", "uniform", 2000, 0.36},  {"true", "uniform", 2000, 0.45},
               {"false", "uniform", 2000, 0.45}, {"[true, false, true]", "uniform", 1000, 0.48},
               {"false", "half", 1000, 0.2},     {"true", "lattice", 4000, 0.7},
               {"true", "lattice", 3500, 0.6},   {"false", "lattice", 3500, 0.5},
               {"true", "lattice", 2, 0.01},     {"false", "lattice", 1, 0.5}};
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
    char text[512];
    snprintf(text, sizeof text, BOX "balls = { count = %d; diameter = %.17g; start = \"%s\"; };",
             cases[k].periodic, cases[k].count,
             packed_diameter(cases[k].share, cases[k].count, 1.0), cases[k].start);
    struct started s = start(text);
    assert_free(&s, 1e-9);
    end(&s);
  }
  /* 5000 balls below the axis of the mill, and as many as are ever milled, on a lattice. */
  char text[1024];
  snprintf(text, sizeof text, MILL "balls = { count = 5000; diameter = 0.005; start = \"half\"; };",
           "flat");
  struct started s = start(text);
  assert_free(&s, 1e-9);
  for (size_t k = 0; k < s.balls->count; ++k)
    assert_true(s.balls->position[k].z <= 0.0);
  end(&s);
}

/* Several species of all kinds of start in one chamber. */
static void species_share_the_chamber(void **state) {
  (void)state;
  struct started s =
      start(DRUM "balls = ({ count = 300; diameter = 0.003; name = \"small\"; speed = 2; },"
                 "{ count = 200; diameter = 0.009; density = 1000; },"
                 "{ count = 150; diameter = 0.004; start = \"lattice\"; },"
                 "{ count = 150; diameter = 0.006; start = \"lattice\"; },"
                 "{ count = 50; diameter = 0.005; start = \"half\";"
                 "region = { low = [-0.05, 0.05, -0.06]; high = [0.05, 0.1, 0.01]; }; },"
                 "{ diameter = 0.005; start = \"table\";"
                 "table = ((0, 0.06, 0, 1, 2, 3), (0, 0.065, 0, -1, 0, 0, 4, 5, 6)); });");
  const struct em_balls *b = s.balls;
  assert_int_equal(b->count, 852);
  assert_free(&s, 0.0);
  static const size_t first[] = {0, 300, 500, 650, 800, 850, 852};
  for (size_t k = 0; k < 6; ++k)
    for (size_t i = first[k]; i < first[k + 1]; ++i) {
      const struct em_species *kind = &s.scene->species[k];
      assert_int_equal(b->species[i], k);
      assert_true(b->radius[i] == 0.5 * kind->diameter);
      double mass = kind->density * M_PI / 6.0 * pow(kind->diameter, 3);
      assert_true(fabs(b->mass[i] / mass - 1.0) < 1e-14);
      if (kind->start != EM_START_TABLE)
        assert_true(fabs(em_vec_norm(b->velocity[i]) - kind->speed) < 1e-12);
      assert_true(i == 851 || em_vec_norm2(b->spin[i]) == 0.0);
    }
  for (size_t i = 800; i < 850; ++i)
    assert_true(fabs(b->position[i].x) <= 0.05 && b->position[i].y >= 0.05 &&
                b->position[i].y <= 0.1 && b->position[i].z >= -0.06 && b->position[i].z <= 0.0);
  assert_true(b->position[851].y == 0.065 && b->velocity[850].z == 3.0 && b->spin[851].y == 5.0);
  /* The two lattices are mixed: neither keeps to one half of the drum. */
  for (size_t k = 2; k < 4; ++k) {
    int lower = 0;
    for (size_t i = first[k]; i < first[k + 1]; ++i)
      lower += b->position[i].y < 0.0675;
    assert_in_range(lower, 45, 105);
  }
  end(&s);
}

static void seeds(void **state) {
  (void)state;
  struct started a = start(DRUM "balls = { count = 500; diameter = 0.005; };");
  struct started b = start(DRUM "balls = { count = 500; diameter = 0.005; };");
  struct started c = start(DRUM "seed = 2; balls = { count = 500; diameter = 0.005; };");
  size_t size = 500 * sizeof(struct em_vec);
  assert_memory_equal(a.balls->position, b.balls->position, size);
  assert_memory_equal(a.balls->velocity, b.balls->velocity, size);
  assert_memory_not_equal(a.balls->position, c.balls->position, size);
  assert_memory_not_equal(a.balls->velocity, c.balls->velocity, size);
  end(&a);
  end(&b);
  end(&c);
}

/* ---- distributions */

/* χ² of counts in bins of equal expectation. */
static void assert_even(size_t bins, const size_t *count, size_t total) {
  double chi2 = 0.0, expected = (double)total / (double)bins;
  for (size_t k = 0; k < bins; ++k)
    chi2 += ((double)count[k] - expected) * ((double)count[k] - expected) / expected;
  double p = gsl_cdf_chisq_P(chi2, (double)bins - 1.0);
  if (p < 0.001 || p > 0.999) fail_msg("chi² %g of %zu bins: p %g", chi2, bins, p);
}

enum { BINS = 20 };

static void count_in(size_t *count, double u) {
  assert_true(u >= 0.0 && u <= 1.0);
  ++count[u < 1.0 ? (size_t)(u * BINS) : BINS - 1];
}

/* Small balls hardly hinder each other: r²/ρ², the angle and y are uniform. */
static void uniform_in_the_drum(void **state) {
  (void)state;
  enum { N = 20000 };
  static const char *const starts[] = {"uniform", "half"};
  for (int k = 0; k < 2; ++k) {
    char text[512];
    snprintf(text, sizeof text, DRUM "balls = { count = %d; diameter = 0.0003; start = \"%s\"; };",
             N, starts[k]);
    struct started s = start(text);
    size_t r2[BINS] = {0}, angle[BINS] = {0}, y[BINS] = {0};
    double rho = 0.5 * (0.146 - 0.0003);
    for (size_t i = 0; i < N; ++i) {
      struct em_vec p = s.balls->position[i];
      double phi = atan2(p.x, p.z); /* 0: up */
      count_in(r2, (p.x * p.x + p.z * p.z) / (rho * rho));
      count_in(angle, k == 0 ? 0.5 + phi / (2.0 * M_PI) : (fabs(phi) - 0.5 * M_PI) / (0.5 * M_PI));
      count_in(y, (p.y - 0.00015) / (0.135 - 0.0003));
    }
    assert_even(BINS, r2, N);
    assert_even(BINS, angle, N);
    assert_even(BINS, y, N);
    end(&s);
  }
}

static void uniform_in_a_box(void **state) {
  (void)state;
  enum { N = 20000 };
  struct started s = start("chamber = { shape = \"box\"; size = [1, 2, 3]; };"
                           "balls = { count = 20000; diameter = 0.002; };");
  size_t bin[3][BINS] = {0};
  for (size_t i = 0; i < N; ++i) {
    struct em_vec p = s.balls->position[i];
    count_in(bin[0], (p.x - 0.001) / 0.998);
    count_in(bin[1], (p.y - 0.001) / 1.998);
    count_in(bin[2], (p.z - 0.001) / 2.998);
  }
  for (int k = 0; k < 3; ++k)
    assert_even(BINS, bin[k], N);
  end(&s);
}

/* Each component of an isotropic direction is uniform in [-1, 1]. */
static void directions_without_preference(void **state) {
  (void)state;
  enum { N = 20000 };
  struct started s = start("chamber = { shape = \"box\"; size = [1, 2, 3]; };"
                           "balls = { count = 20000; diameter = 0.002; speed = 2.5; };");
  size_t bin[3][BINS] = {0};
  for (size_t i = 0; i < N; ++i) {
    struct em_vec v = s.balls->velocity[i];
    assert_true(fabs(em_vec_norm(v) - 2.5) < 1e-14 * 2.5 * 8);
    count_in(bin[0], 0.5 + 0.2 * v.x);
    count_in(bin[1], 0.5 + 0.2 * v.y);
    count_in(bin[2], 0.5 + 0.2 * v.z);
  }
  for (int k = 0; k < 3; ++k)
    assert_even(BINS, bin[k], N);
  end(&s);
}

/* Balls that were pushed apart are spread evenly as well (coarsely: neighbours repel, so that
 * counts vary less than by chance; more would be a fault). */
static void dense_starts_are_even(void **state) {
  (void)state;
  char text[512];
  snprintf(text, sizeof text, BOX "balls = { count = 8000; diameter = %.17g; };", "true",
           packed_diameter(0.45, 8000, 1.0));
  struct started s = start(text);
  double chi2 = 0.0;
  size_t count[64] = {0};
  for (size_t i = 0; i < 8000; ++i) {
    struct em_vec p = s.balls->position[i];
    ++count[(size_t)(p.x * 4) + 4 * (size_t)(p.y * 4) + 16 * (size_t)(p.z * 4)];
  }
  for (int k = 0; k < 64; ++k)
    chi2 += ((double)count[k] - 125.0) * ((double)count[k] - 125.0) / 125.0;
  assert_true(gsl_cdf_chisq_P(chi2, 63.0) < 0.999);
  end(&s);
}

static void lattices_are_even(void **state) {
  (void)state;
  struct started s = start("chamber = { shape = \"box\"; size = [1, 1, 1]; periodic = true; };"
                           "balls = { count = 4000; diameter = 0.0694; start = \"lattice\"; };");
  size_t count[8] = {0};
  for (size_t i = 0; i < 4000; ++i) {
    struct em_vec p = s.balls->position[i];
    ++count[(p.x > 0.5) + 2 * (p.y > 0.5) + 4 * (p.z > 0.5)];
  }
  for (int k = 0; k < 8; ++k)
    assert_int_equal(count[k], 500);
  end(&s);
}

/* ---- momentum */

static struct em_vec momentum(const struct em_balls *b) {
  struct em_vec p = {0, 0, 0};
  for (size_t k = 0; k < b->count; ++k)
    p = em_vec_axpy(p, b->mass[k], b->velocity[k]);
  return p;
}

static void momentum_is_removed_where_nothing_takes_it_up(void **state) {
  (void)state;
  static const char *const periodic[] = {"true", "[true, true, false]", "[false, false, true]"};
  for (int k = 0; k < 3; ++k) {
    char text[512];
    snprintf(text, sizeof text,
             BOX "balls = ({ count = 100; diameter = 0.05; speed = 3; },"
                 "{ count = 50; diameter = 0.03; }, { diameter = 0.02; start = \"table\";"
                 "table = ((0.5, 0.5, 0.5, 9, 0, 0)); });",
             periodic[k]);
    struct started s = start(text);
    struct em_balls *b = s.balls;
    struct em_vec given = em_vec_scale(b->mass[150], b->velocity[150]);
    const struct em_vec p = em_vec_sub(momentum(b), given);
    double energy = 0.0, asked = 0.0;
    for (size_t i = 0; i < 150; ++i) {
      energy += b->mass[i] * em_vec_norm2(b->velocity[i]);
      asked += b->mass[i] * (i < 100 ? 9.0 : 1.0);
    }
    assert_true(b->velocity[150].x == 9.0);
    assert_true(fabs(energy / asked - 1.0) < 1e-12);
    assert_true((fabs(p.x) < 1e-13 * asked) == (k < 2));
    assert_true((fabs(p.y) < 1e-13 * asked) == (k < 2));
    assert_true((fabs(p.z) < 1e-13 * asked) == (k != 1));
    end(&s);
  }
}

/* ---- runs that go on */

static void the_last_frame_of_a_run(void **state) {
  (void)state;
  struct started old = start(DRUM "balls = ({ count = 40; diameter = 0.005; },"
                                  "{ count = 30; diameter = 0.004; });");
  old.balls->spin[41] = em_vec_make(1, 2, 3);
  struct em_scene *scene =
      parse(DRUM "balls = ({ count = 10; diameter = 0.005; start = \"run\"; from = \"old.h5\"; },"
                 "{ count = 30; diameter = 0.004; start = \"run\"; from = \"old.h5\"; },"
                 "{ count = 5; diameter = 0.006; });");
  struct em_balls *b;
  struct em_error err = {0};
  assert_int_equal(em_start_make(&b, scene, old.balls, NULL, &err), EM_OK);
  assert_memory_equal(b->position, old.balls->position, 10 * sizeof *b->position);
  assert_memory_equal(b->velocity + 10, old.balls->velocity + 40, 30 * sizeof *b->velocity);
  assert_true(b->spin[11].y == 2.0);
  em_start_free(b);
  assert_int_equal(em_start_make(&b, scene, NULL, NULL, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "/old.h5 holds 0 balls of this species, expected 10"));
  assert_null(b);
  scene->species[1].count = 31;
  assert_int_equal(em_start_make(&b, scene, old.balls, NULL, &err), EM_INPUT);
  assert_non_null(strstr(err.text, "/old.h5 holds 30 balls of this species, expected 31"));
  em_scene_free(scene);
  end(&old);
}

/* ---- stopping */

static void placing_stops_on_request(void **state) {
  (void)state;
  static const volatile sig_atomic_t stop = 1;
  static const char *const text[] = {
      DRUM "balls = { count = 100; diameter = 0.005; };",
      DRUM "balls = { count = 100; diameter = 0.005; start = \"lattice\"; };",
      ("chamber = { shape = \"box\"; size = [1, 1, 1]; };"
       "balls = { count = 500; diameter = 0.12; };"), /* pushed apart */
  };
  for (size_t k = 0; k < sizeof text / sizeof *text; k++) {
    struct em_scene *scene = parse(text[k]);
    struct em_balls *b;
    struct em_error err = {0};
    assert_int_equal(em_start_make(&b, scene, NULL, &stop, &err), EM_STOPPED);
    assert_null(b);
    em_scene_free(scene);
  }
}

/* ---- no room */

static void no_room(const char *text, const char *message) {
  struct em_scene *scene = parse(text);
  struct em_balls *b;
  struct em_error err = {0};
  assert_int_equal(em_start_make(&b, scene, NULL, NULL, &err), EM_INPUT);
  assert_null(b);
  if (!strstr(err.text, message)) fail_msg("%s lacks %s", err.text, message);
  em_scene_free(scene);
}

static void errors_where_there_is_no_room(void **state) {
  (void)state;
  no_room("chamber = { shape = \"box\"; size = [1, 1, 1]; };"
          "balls = { count = 500; diameter = 0.136; };", /* 0.66 */
          "t.cfg: error: balls: only ");
  no_room("chamber = { shape = \"box\"; size = [1, 1, 1]; };"
          "balls = { count = 500; diameter = 0.138; start = \"lattice\"; };",
          "no lattice of 500 balls of 0.138 m fits");
  no_room(DRUM "balls = { diameter = 0.005; start = \"table\";"
               "table = ((0, 0.05, 0, 0, 0, 0), (0, 0.054, 0, 0, 0, 0)); };",
          "balls.0: ball 1 at (0, 0.054, 0) overlaps");
  no_room(DRUM
          "balls = { diameter = 0.005; start = \"table\"; table = ((0, 0.002, 0, 0, 0, 0)); };",
          "balls.0: ball 0 at (0, 0.002, 0) overlaps a wall");
  no_room(DRUM
          "rotor = { blades = ({ y = 0.06; radius = 0.006; reach = 0.058; }); };"
          "balls = { diameter = 0.005; start = \"table\"; table = ((0, 0.06, 0.06, 0, 0, 0)); };",
          "balls.0: ball 0 at (0, 0.06, 0.06) overlaps a wall, a blade");
}

/* They take no part, however large: neither in the lattice's width nor in its order. */
static void species_without_balls(void **state) {
  (void)state;
  static const char *const none[] = {"{ count = 0; diameter = 0.3; start = \"lattice\"; }",
                                     "{ count = 0; diameter = 0.3; }"};
  static const char some[] = "{ count = 1000; diameter = 0.05; start = \"lattice\"; }";
  const char *const box = "chamber = { shape = \"box\"; size = [1, 1, 1]; };";
  char text[400];
  snprintf(text, sizeof text, "%s balls = (%s);", box, some);
  struct started alone = start(text);
  for (int k = 0; k < 4; ++k) {
    const char *empty = none[k / 2];
    snprintf(text, sizeof text, "%s balls = (%s, %s);", box, k & 1 ? empty : some,
             k & 1 ? some : empty);
    struct started s = start(text);
    assert_int_equal(s.balls->count, 1000);
    assert_memory_equal(s.balls->position, alone.balls->position, 1000 * sizeof *s.balls->position);
    end(&s);
  }
  end(&alone);
}

static void no_balls(void **state) {
  (void)state;
  struct started s = start(DRUM "balls = ();");
  assert_int_equal(s.balls->count, 0);
  end(&s);
  s = start(DRUM "balls = { count = 0; diameter = 0.005; };");
  assert_int_equal(s.balls->count, 0);
  end(&s);
  em_start_free(NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(nothing_overlaps),
      cmocka_unit_test(dense_starts),
      cmocka_unit_test(species_share_the_chamber),
      cmocka_unit_test(seeds),
      cmocka_unit_test(uniform_in_the_drum),
      cmocka_unit_test(uniform_in_a_box),
      cmocka_unit_test(directions_without_preference),
      cmocka_unit_test(dense_starts_are_even),
      cmocka_unit_test(lattices_are_even),
      cmocka_unit_test(momentum_is_removed_where_nothing_takes_it_up),
      cmocka_unit_test(the_last_frame_of_a_run),
      cmocka_unit_test(placing_stops_on_request),
      cmocka_unit_test(errors_where_there_is_no_room),
      cmocka_unit_test(species_without_balls),
      cmocka_unit_test(no_balls),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
