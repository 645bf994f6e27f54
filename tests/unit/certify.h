/* Certificates that a time is the first contact to 1 ulp: the gap's signs at the neighbouring
 * doubles and how far the root is, in 60 digits (MPFR); that none is earlier, by a bound that owes
 * nothing to the searches. */
#ifndef EVENTMILL_TESTS_CERTIFY_H
#define EVENTMILL_TESTS_CERTIFY_H

#include <math.h>
#include <mpfr.h>
#include <stdbool.h>

enum { CERTIFY_BITS = 200, CERTIFY_DEGREE = 4, CERTIFY_DEPTH = 400 };

struct certify {
  mpfr_t a[CERTIFY_DEGREE + 1]; /* of the polynomial: negative before a contact */
  mpfr_t b[CERTIFY_DEGREE + 1]; /* Bernstein's coefficients */
  mpfr_t x, y, term;
  int degree;
  double origin; /* s: the polynomial's time 0 */
};

static inline void certify_init(struct certify *c) {
  for (int k = 0; k <= CERTIFY_DEGREE; k++)
    mpfr_inits2(CERTIFY_BITS, c->a[k], c->b[k], (mpfr_ptr)0);
  mpfr_inits2(CERTIFY_BITS, c->x, c->y, c->term, (mpfr_ptr)0);
}

static inline void certify_clear(struct certify *c) {
  for (int k = 0; k <= CERTIFY_DEGREE; k++)
    mpfr_clears(c->a[k], c->b[k], (mpfr_ptr)0);
  mpfr_clears(c->x, c->y, c->term, (mpfr_ptr)0);
}

static inline void certify_begin(struct certify *c, int degree) {
  c->degree = degree;
  c->origin = 0.0;
  for (int k = 0; k <= CERTIFY_DEGREE; k++)
    mpfr_set_zero(c->a[k], 1);
}

/* a[k] += x y, of which the product is exact. */
static inline void certify_add(struct certify *c, int k, double x, double y) {
  mpfr_set_d(c->x, x, MPFR_RNDN);
  mpfr_mul_d(c->x, c->x, y, MPFR_RNDN);
  mpfr_add(c->a[k], c->a[k], c->x, MPFR_RNDN);
}

/* y = the polynomial at the time t. */
static inline void certify_value(struct certify *c, double t) {
  mpfr_set_d(c->x, t, MPFR_RNDN);
  mpfr_sub_d(c->x, c->x, c->origin, MPFR_RNDN);
  mpfr_set(c->y, c->a[c->degree], MPFR_RNDN);
  for (int k = c->degree - 1; k >= 0; k--) {
    mpfr_mul(c->y, c->y, c->x, MPFR_RNDN);
    mpfr_add(c->y, c->y, c->a[k], MPFR_RNDN);
  }
}

/* b = Bernstein's coefficients on [0, x]: Σ over i ≤ k of C(k, i) / C(n, i) a_i xⁱ. */
static inline void certify_bernstein(struct certify *c) {
  const int n = c->degree;
  mpfr_set_ui(c->y, 1, MPFR_RNDN);
  for (int k = 0; k <= n; k++)
    mpfr_set_zero(c->b[k], 1);
  unsigned long choose_n = 1;
  for (int i = 0; i <= n; i++) {
    unsigned long choose_k = 1;
    for (int k = i; k <= n; k++) {
      mpfr_mul(c->term, c->a[i], c->y, MPFR_RNDN);
      mpfr_mul_ui(c->term, c->term, choose_k, MPFR_RNDN);
      mpfr_div_ui(c->term, c->term, choose_n, MPFR_RNDN);
      mpfr_add(c->b[k], c->b[k], c->term, MPFR_RNDN);
      choose_k = choose_k * (unsigned long)(k + 1) / (unsigned long)(k + 1 - i);
    }
    mpfr_mul(c->y, c->y, c->x, MPFR_RNDN);
    choose_n = choose_n * (unsigned long)(n - i) / (unsigned long)(i + 1);
  }
}

/* Is the polynomial negative on all of [origin, t]? It lies in the hull of Bernstein's
 * coefficients; where these have both signs, the interval's first half is shown and cut off. */
static inline bool certify_is_clear(struct certify *c, double t) {
  const int n = c->degree;
  mpfr_set_d(c->x, t, MPFR_RNDN);
  mpfr_sub_d(c->x, c->x, c->origin, MPFR_RNDN);
  certify_bernstein(c);
  mpfr_t stack[CERTIFY_DEPTH][CERTIFY_DEGREE + 1];
  int depth = 0, work = 0;
  bool clear = true;
  for (;;) {
    bool below = true;
    for (int k = 0; k <= n; k++)
      below = below && mpfr_sgn(c->b[k]) < 0;
    if (mpfr_sgn(c->b[0]) >= 0 || mpfr_sgn(c->b[n]) >= 0) clear = false;
    if (!below && (depth == CERTIFY_DEPTH || ++work > 10000)) clear = false;
    if (!clear || (below && depth == 0)) break;
    if (below) { /* this half is done: on to the one that waits */
      depth--;
      for (int k = 0; k <= n; k++) {
        mpfr_set(c->b[k], stack[depth][k], MPFR_RNDN);
        mpfr_clear(stack[depth][k]);
      }
      continue;
    }
    for (int k = 0; k <= n; k++) { /* de Casteljau: the second half waits */
      mpfr_init2(stack[depth][n - k], CERTIFY_BITS);
      mpfr_set(stack[depth][n - k], c->b[n], MPFR_RNDN);
      for (int j = n; j > k; j--) {
        mpfr_add(c->b[j], c->b[j], c->b[j - 1], MPFR_RNDN);
        mpfr_div_2ui(c->b[j], c->b[j], 1, MPFR_RNDN);
      }
    }
    depth++;
  }
  while (depth-- > 0)
    for (int k = 0; k <= n; k++)
      mpfr_clear(stack[depth][k]);
  return clear;
}

/* How many ulp the time t is away from the root between its neighbours, given the gaps there (of
 * which the first and the last differ in sign): by the secant. */
static inline double certify_ulps(double low, double here, double high, double t) {
  const double left = t - nextafter(t, -INFINITY), right = nextafter(t, INFINITY) - t;
  const double slope = (high - low) / (left + right);
  return fabs(here / slope) / right;
}

#endif
