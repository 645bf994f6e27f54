/* Laws of restitution against their formulas, limits and fits; collision rules against the
 * conservation laws over random pairs. */
#include <float.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "eventmill/contact.h"

enum { PAIRS = 1000000 };

static double uniform(double low, double high) {
  return low + (high - low) * drand48();
}

static double spread(double low, double high) {
  return low * pow(high / low, drand48());
}

static struct em_vec vector(double size) {
  return em_vec_make(uniform(-size, size), uniform(-size, size), uniform(-size, size));
}

static struct em_vec direction(void) {
  for (;;) {
    const struct em_vec a = vector(1.0);
    const double n = em_vec_norm(a);
    if (n > 0.1 && n < 1.0) return em_vec_scale(1.0 / n, a);
  }
}

static double law_at(enum em_law law, const double *p, double v) {
  struct em_restitution e = {.law = law};
  memcpy(e.p, p, sizeof(e.p));
  return em_contact_restitution(&e, v);
}

static double standard(enum em_law law, double v) {
  const struct em_restitution e = em_contact_law_default(law);
  return em_contact_restitution(&e, v);
}

static void names(void **state) {
  (void)state;
  for (int i = 0; i < EM_LAW_COUNT; i++) {
    assert_int_equal(em_contact_law_find(em_contact_law_name((enum em_law)i)), i);
    const int size = em_contact_law_size((enum em_law)i);
    assert_in_range(size, 1, EM_LAW_PARAMETERS);
    for (int k = 0; k < size; k++)
      assert_non_null(em_contact_law_parameter((enum em_law)i, k));
    assert_null(em_contact_law_parameter((enum em_law)i, size));
    assert_null(em_contact_law_parameter((enum em_law)i, -1));
    assert_int_equal(em_contact_law_default((enum em_law)i).law, i);
  }
  for (int i = 0; i < EM_CLASS_COUNT; i++)
    assert_int_equal(em_contact_class_find(em_contact_class_name((enum em_class)i)), i);
  assert_int_equal(em_contact_law_find("spohn"), -1);
  assert_int_equal(em_contact_class_find("ball"), -1);
}

/* Values computed by hand (bc, 20 digits) from the formulas as printed. */
static void formulas(void **state) {
  (void)state;
  const double c[4] = {2.0};
  assert_true(law_at(EM_LAW_CONSTANT, (const double[4]){0.7}, 3.0) == 0.7);
  assert_true(fabs(law_at(EM_LAW_SALO, c, 6.0) - 0.25) < 1e-15);
  /* x = ½: √(−1/6 + √(5/6 − 5/144)) */
  assert_true(fabs(law_at(EM_LAW_ANDREWS, c, 4.0) - 0.85263343504910360) < 1e-14);
  assert_true(fabs(standard(EM_LAW_SPAHN, 1.0) - 0.81110121252710101) < 1e-15);
  assert_true(fabs(standard(EM_LAW_SPAHN, 0.0) - 0.99999655839956569) < 1e-15);
  assert_true(fabs(law_at(EM_LAW_POWER2, (const double[4]){0.5, 2.0}, 2.0) - 1.0 / 3.0) < 1e-15);
  assert_true(fabs(law_at(EM_LAW_POWER4, (const double[4]){0.75, 2.0, 0.5, 0.2}, 2.0) - 0.6) <
              1e-15);
  assert_true(fabs(law_at(EM_LAW_EXPONENTIAL, (const double[4]){0.5, 1.0, 0.25}, 2.0) -
                   (0.25 + 0.75 * exp(-1.0))) < 1e-15);
}

/* The Padé form must have the exact series 1 − C₁ β v^(1/5) + C₂ β² v^(2/5), C₁ = (2/5) (5/4)^(3/5)
 * √π Γ(3/5) / Γ(21/10) (docs/physics.md), C₂ = 3/5 C₁² (Schwager & Pöschel 1998). */
static void viscoelastic_series(void **state) {
  (void)state;
  const double c1 = 0.4 * pow(1.25, 0.6) * sqrt(M_PI) * tgamma(0.6) / tgamma(2.1);
  for (double y = 1e-6; y < 1e-3; y *= 2.0) { /* y = β v^(1/5) */
    const double e = law_at(EM_LAW_VISCOELASTIC, (const double[4]){y}, 1.0);
    const double series = 1.0 - c1 * y + 0.6 * c1 * c1 * y * y;
    assert_true(fabs(e - series) < 1e-5 * y + 3.0 * pow(y, 2.5));
  }
}

/* In [0, 1], falling, continuous, with the stated limits, for any parameters. */
static void shapes(void **state) {
  (void)state;
  srand48(1);
  for (int law = 0; law < EM_LAW_COUNT; law++)
    for (int try = 0; try < 200; try++) {
      struct em_restitution e = em_contact_law_default((enum em_law)law);
      if (try > 0)
        for (int k = 0; k < EM_LAW_PARAMETERS; k++)
          e.p[k] *= spread(0.3, 3.0);
      const double rest = em_contact_restitution(&e, 0.0);
      assert_true(rest >= 0.0 && rest <= 1.0);
      if (try == 0 && law != EM_LAW_CONSTANT) assert_true(rest > 0.99999 && rest <= 1.0);
      double before = rest;
      for (double v = 1e-12; v < 1e6; v *= 1.03) {
        const double here = em_contact_restitution(&e, v);
        assert_true(here >= 0.0 && here <= before + 1e-15);
        const double beside = em_contact_restitution(&e, v * (1.0 + 1e-9));
        assert_true(fabs(here - beside) < 1e-8);
        before = here;
      }
    }
  assert_true(standard(EM_LAW_SALO, INFINITY) == 0.0);
  const double c[4] = {1.5};
  assert_true(law_at(EM_LAW_ANDREWS, c, 1.5) == 1.0);
  assert_true(law_at(EM_LAW_ANDREWS, c, 1.5 * (1 + 1e-12)) > 1.0 - 1e-11);
  assert_true(standard(EM_LAW_SPAHN, NAN) == 0.0); /* bad input stays in range */
}

static double misfit(const struct em_restitution *e) {
  double sum = 0.0;
  for (int i = 0; i <= 500; i++) {
    const double d = em_contact_restitution(e, 0.1 * i) - standard(EM_LAW_SPAHN, 0.1 * i);
    sum += d * d;
  }
  return sum;
}

/* The defaults are what docs/physics.md says: least squares to the measured curve, 0 … 50 m/s. */
static void defaults_are_fits(void **state) {
  (void)state;
  const enum em_law fitted[] = {EM_LAW_SALO,        EM_LAW_ANDREWS, EM_LAW_POWER2,
                                EM_LAW_EXPONENTIAL, EM_LAW_POWER4,  EM_LAW_VISCOELASTIC};
  for (size_t i = 0; i < sizeof(fitted) / sizeof(fitted[0]); i++) {
    const struct em_restitution best = em_contact_law_default(fitted[i]);
    for (int k = 0; k < em_contact_law_size(fitted[i]); k++)
      for (int side = -1; side <= 1; side += 2) {
        struct em_restitution other = best;
        other.p[k] += side * 0.01 * (best.p[k] != 0.0 ? best.p[k] : 1.0);
        assert_true(misfit(&other) > misfit(&best));
      }
  }
}

/* Two balls at contact, and what a rule makes of them. */
struct pair {
  struct em_vec e, v[2], w[2];
  double m[2], r[2];
};

struct balance {
  struct em_vec p, l; /* momentum, angular momentum about the first centre */
  double energy;
};

static struct pair pair_random(void) {
  struct pair a = {.e = direction()};
  for (int k = 0; k < 2; k++) {
    a.m[k] = spread(1e-6, 1e-2);
    a.r[k] = spread(1e-3, 2e-2);
    a.v[k] = vector(5.0);
    a.w[k] = vector(500.0);
  }
  if (em_vec_dot(em_vec_sub(a.v[0], a.v[1]), a.e) > 0.0) a.e = em_vec_scale(-1.0, a.e);
  return a;
}

static struct em_vec slip(const struct pair *a) {
  const struct em_vec spin =
      em_vec_add(em_vec_scale(a->r[0], a->w[0]), em_vec_scale(a->r[1], a->w[1]));
  return em_vec_add(em_vec_sub(a->v[0], a->v[1]), em_vec_cross(a->e, spin));
}

static struct balance balance(const struct pair *a) {
  struct balance b = {0};
  const struct em_vec place[2] = {{0, 0, 0}, em_vec_scale(-(a->r[0] + a->r[1]), a->e)};
  for (int k = 0; k < 2; k++) {
    const double inertia = 0.4 * a->m[k] * a->r[k] * a->r[k];
    const struct em_vec p = em_vec_scale(a->m[k], a->v[k]);
    b.p = em_vec_add(b.p, p);
    b.l = em_vec_add(b.l, em_vec_axpy(em_vec_cross(place[k], p), inertia, a->w[k]));
    b.energy += 0.5 * em_vec_dot(p, a->v[k]) + 0.5 * inertia * em_vec_norm2(a->w[k]);
  }
  return b;
}

static struct em_impulse collide(struct pair *a, const struct em_contact_law *law,
                                 bool frictionless, bool elastic) {
  const double m_eff = a->m[0] * a->m[1] / (a->m[0] + a->m[1]);
  const struct em_impulse i = em_contact_impulse(law, m_eff, a->e, slip(a), frictionless, elastic);
  const struct em_vec total = em_vec_add(i.normal, i.tangential);
  const struct em_vec turn = em_vec_cross(a->e, i.tangential);
  for (int k = 0; k < 2; k++) {
    a->v[k] = em_vec_axpy(a->v[k], (k == 0 ? 1.0 : -1.0) / a->m[k], total);
    a->w[k] = em_vec_axpy(a->w[k], em_contact_spin_factor(law->rule, a->m[k], a->r[k]), turn);
  }
  return i;
}

static struct em_contact_law law_random(enum em_rule rule) {
  return (struct em_contact_law){
      rule, {EM_LAW_CONSTANT, {uniform(0.0, 1.0)}}, uniform(-1.0, 1.0), uniform(0.0, 0.5)};
}

static double size(const struct em_vec *a, double scale) {
  return em_vec_norm(*a) / scale;
}

/* Momentum always; angular momentum for the rules that claim it; the energy that a rule loses. */
static void conserves(enum em_rule rule, bool angular) {
  srand48(2 + (long)rule);
  for (int n = 0; n < PAIRS; n++) {
    const struct pair before = pair_random();
    struct pair after = before;
    const struct em_contact_law law = law_random(rule);
    const struct em_impulse i = collide(&after, &law, false, false);
    const struct balance a = balance(&before), b = balance(&after);
    const double m = before.m[0] + before.m[1], v = 10.0 + 500.0 * 0.02;
    const double momentum = m * v, arm = before.r[0] + before.r[1];
    struct em_vec d = em_vec_sub(b.p, a.p);
    assert_true(size(&d, momentum) < 1e-14);
    d = em_vec_sub(b.l, a.l);
    if (angular) assert_true(size(&d, momentum * arm) < 1e-14);
    const struct em_vec g = slip(&before), h = slip(&after);
    const double gn = em_vec_dot(g, before.e), hn = em_vec_dot(h, before.e);
    const double epsilon = law.normal.p[0];
    assert_true(fabs(hn + epsilon * gn) < 1e-12 * v);
    assert_true(fabs(i.vn + gn) < 1e-12 * v && i.vn >= 0.0);
    const struct em_vec gt = em_vec_axpy(g, -gn, before.e), ht = em_vec_axpy(h, -hn, before.e);
    assert_true(fabs(i.vt - em_vec_norm(gt)) < 1e-12 * v);
    const double m_eff = before.m[0] * before.m[1] / m, lost = a.energy - b.energy;
    const double normal = 0.5 * m_eff * (1.0 - epsilon * epsilon) * gn * gn;
    double kept = law.tangential;
    if (rule == EM_RULE_SMOOTH) kept = 1.0;
    if (rule == EM_RULE_FRICTION) {
      const double limit = law.friction * em_vec_norm(i.normal);
      assert_true(em_vec_norm(i.tangential) <= limit * (1.0 + 1e-14));
      kept = fmax(law.tangential, 1.0 - 3.5 * limit / (m_eff * i.vt));
      assert_true(lost > -1e-13 * m * v * v);
    }
    if (rule == EM_RULE_REICHARDT2005) continue;
    d = em_vec_axpy(ht, -kept, gt);
    assert_true(size(&d, v) < 2e-12);
    const double slid = m_eff / 7.0 * (1.0 - kept * kept) * i.vt * i.vt;
    assert_true(fabs(lost - normal - slid) < 1e-13 * (a.energy + m * v * v));
  }
}

static void rough(void **state) {
  (void)state;
  conserves(EM_RULE_ROUGH, true);
}

static void friction(void **state) {
  (void)state;
  conserves(EM_RULE_FRICTION, true);
}

static void smooth(void **state) {
  (void)state;
  conserves(EM_RULE_SMOOTH, true);
}

static void reichardt(void **state) {
  (void)state;
  conserves(EM_RULE_REICHARDT2005, false);
}

/* ε_n = 1 and ε_t = ±1: the rough rule keeps the energy. */
static void rough_elastic(void **state) {
  (void)state;
  srand48(7);
  for (int n = 0; n < PAIRS; n++) {
    struct pair a = pair_random();
    const double before = balance(&a).energy;
    const struct em_contact_law law = {
        EM_RULE_ROUGH, {EM_LAW_CONSTANT, {1.0}}, n % 2 ? 1.0 : -1.0, 0.0};
    collide(&a, &law, false, false);
    assert_true(fabs(balance(&a).energy - before) < 4e-14 * before);
  }
}

/* (9-7) and (9-16) as printed, up to their signs: no factor 2/7. */
static void reichardt_formula(void **state) {
  (void)state;
  srand48(8);
  for (int n = 0; n < 1000; n++) {
    struct pair a = pair_random();
    const struct pair before = a;
    const struct em_contact_law law = law_random(EM_RULE_REICHARDT2005);
    const struct em_vec g = slip(&a);
    const double gn = em_vec_dot(g, a.e);
    const struct em_vec gt = em_vec_axpy(g, -gn, a.e);
    collide(&a, &law, false, false);
    const double share = before.m[1] / (before.m[0] + before.m[1]);
    const struct em_vec change =
        em_vec_add(em_vec_scale((law.tangential - 1.0) * share, gt),
                   em_vec_scale(-(law.normal.p[0] + 1.0) * share * gn, a.e));
    const struct em_vec d = em_vec_sub(em_vec_sub(a.v[0], before.v[0]), change);
    assert_true(em_vec_norm(d) < 1e-13 * em_vec_norm(g));
    const struct em_vec turn =
        em_vec_scale(-before.r[0] * share * (law.tangential - 1.0), em_vec_cross(a.e, gt));
    const struct em_vec w = em_vec_sub(em_vec_sub(a.w[0], before.w[0]), turn);
    assert_true(em_vec_norm(w) < 1e-12 * em_vec_norm(before.w[0]));
  }
}

/* The remedies: without tangential part, and without loss; a parting contact pulls at nobody. */
static void remedies(void **state) {
  (void)state;
  srand48(9);
  for (int rule = 0; rule < EM_RULE_COUNT; rule++)
    for (int n = 0; n < 1000; n++) {
      const struct em_contact_law law = law_random((enum em_rule)rule);
      struct pair a = pair_random();
      struct em_vec g = slip(&a);
      const double m = 1.0, gn = em_vec_dot(g, a.e);
      struct em_impulse i = em_contact_impulse(&law, m, a.e, g, true, true);
      assert_true(em_vec_norm(i.tangential) == 0.0);
      assert_true(fabs(em_vec_dot(i.normal, a.e) + 2.0 * m * gn) < 1e-13 * fabs(gn) + 1e-13);
      g = em_vec_scale(-1.0, g);
      i = em_contact_impulse(&law, m, a.e, g, true, false);
      assert_true(em_vec_norm(i.normal) == 0.0 && i.vn == 0.0);
    }
  const struct em_contact_law slide = {EM_RULE_FRICTION, {EM_LAW_CONSTANT, {0.5}}, -0.5, 0.3};
  const struct em_impulse still =
      em_contact_impulse(&slide, 1.0, em_vec_make(0, 0, 1), em_vec_make(0, 0, -1), false, false);
  assert_true(em_vec_norm(still.tangential) == 0.0 && still.vt == 0.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(names),
      cmocka_unit_test(formulas),
      cmocka_unit_test(viscoelastic_series),
      cmocka_unit_test(shapes),
      cmocka_unit_test(defaults_are_fits),
      cmocka_unit_test(rough),
      cmocka_unit_test(friction),
      cmocka_unit_test(smooth),
      cmocka_unit_test(reichardt),
      cmocka_unit_test(rough_elastic),
      cmocka_unit_test(reichardt_formula),
      cmocka_unit_test(remedies),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
