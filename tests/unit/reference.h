/* First contacts to 60 digits (MPFR), for the tests: the rising sign changes of a polynomial whose
 * coefficients are exact functions of the state. */
#ifndef EVENTMILL_TESTS_REFERENCE_H
#define EVENTMILL_TESTS_REFERENCE_H

#include <math.h>
#include <mpfr.h>
#include <stdbool.h>

enum { REFERENCE_BITS = 200, REFERENCE_DEGREE = 4 };

struct reference {
  mpfr_t a[REFERENCE_DEGREE + 1];
  mpfr_t turn[REFERENCE_DEGREE], height[REFERENCE_DEGREE]; /* extrema for t > 0 */
  mpfr_t rise;                                             /* the first */
  mpfr_t x, y, z, low, high, term;
  int degree, turns;
  bool rises;
};

static inline void reference_init(struct reference *r) {
  for (int k = 0; k <= REFERENCE_DEGREE; k++)
    mpfr_init2(r->a[k], REFERENCE_BITS);
  for (int k = 0; k < REFERENCE_DEGREE; k++)
    mpfr_inits2(REFERENCE_BITS, r->turn[k], r->height[k], (mpfr_ptr)0);
  mpfr_inits2(REFERENCE_BITS, r->rise, r->x, r->y, r->z, r->low, r->high, r->term, (mpfr_ptr)0);
}

static inline void reference_clear(struct reference *r) {
  for (int k = 0; k <= REFERENCE_DEGREE; k++)
    mpfr_clear(r->a[k]);
  for (int k = 0; k < REFERENCE_DEGREE; k++)
    mpfr_clears(r->turn[k], r->height[k], (mpfr_ptr)0);
  mpfr_clears(r->rise, r->x, r->y, r->z, r->low, r->high, r->term, (mpfr_ptr)0);
}

/* The value of derivative number `order` at x. */
static inline void reference_value(struct reference *r, int order, mpfr_t value, const mpfr_t x) {
  mpfr_set_zero(value, 1);
  for (int k = r->degree; k >= order; k--) {
    unsigned long factor = 1;
    for (int i = 0; i < order; i++)
      factor *= (unsigned long)(k - i);
    mpfr_mul(value, value, x, MPFR_RNDN);
    mpfr_mul_ui(r->term, r->a[k], factor, MPFR_RNDN);
    mpfr_add(value, value, r->term, MPFR_RNDN);
  }
}

static inline double reference_at(struct reference *r, int order, double t) {
  mpfr_set_d(r->x, t, MPFR_RNDN);
  reference_value(r, order, r->y, r->x);
  return mpfr_get_d(r->y, MPFR_RNDN);
}

/* The root of derivative `order` between low and high, where its signs differ: Newton inside the
 * bracket, every third step a bisection, until nothing changes in 180 bits. */
static inline void reference_root(struct reference *r, int order, mpfr_t root) {
  reference_value(r, order, r->y, r->high);
  const int up = mpfr_sgn(r->y);
  mpfr_add(root, r->low, r->high, MPFR_RNDN);
  mpfr_div_2ui(root, root, 1, MPFR_RNDN);
  for (int step = 0; step < 2000; step++) {
    reference_value(r, order, r->y, root);
    if (mpfr_sgn(r->y) == 0) return;
    mpfr_set(mpfr_sgn(r->y) == up ? r->high : r->low, root, MPFR_RNDN);
    reference_value(r, order + 1, r->z, root);
    mpfr_div(r->y, r->y, r->z, MPFR_RNDN);
    mpfr_sub(r->z, root, r->y, MPFR_RNDN);
    if (!mpfr_zero_p(r->y) && mpfr_number_p(r->y) && mpfr_get_exp(r->y) < mpfr_get_exp(root) - 180)
      return;
    const bool inside = mpfr_cmp(r->z, r->low) > 0 && mpfr_cmp(r->z, r->high) < 0;
    if (inside && step % 3 != 2) {
      mpfr_set(root, r->z, MPFR_RNDN);
    } else {
      mpfr_add(r->z, r->low, r->high, MPFR_RNDN);
      mpfr_div_2ui(r->z, r->z, 1, MPFR_RNDN);
      if (mpfr_equal_p(r->z, root)) return;
      mpfr_set(root, r->z, MPFR_RNDN);
    }
  }
}

/* The sign changes of derivative `order` in (0, far), given those of the next one in turn[]; both
 * in turn[]. */
static inline void reference_lift(struct reference *r, int order, const mpfr_t far) {
  mpfr_t found[REFERENCE_DEGREE], from;
  int count = 0;
  mpfr_init2(from, REFERENCE_BITS);
  mpfr_set_zero(from, 1);
  for (int k = 0; k <= r->turns; k++) {
    const mpfr_ptr to = k < r->turns ? r->turn[k] : (mpfr_ptr)far;
    reference_value(r, order, r->y, from);
    reference_value(r, order, r->z, to);
    if (mpfr_sgn(r->y) * mpfr_sgn(r->z) < 0 && count < REFERENCE_DEGREE) {
      mpfr_set(r->low, from, MPFR_RNDN);
      mpfr_set(r->high, to, MPFR_RNDN);
      mpfr_init2(found[count], REFERENCE_BITS);
      reference_root(r, order, found[count]);
      count++;
    }
    mpfr_set(from, to, MPFR_RNDN);
  }
  r->turns = count;
  for (int k = 0; k < count; k++) {
    mpfr_set(r->turn[k], found[k], MPFR_RNDN);
    mpfr_clear(found[k]);
  }
  mpfr_clear(from);
}

/* Fills turn, height, rise for the coefficients a[0 … degree] on (0, far). The rise is the first t
 * ≥ 0 at which the polynomial is ≥ 0 and rises. */
static inline void reference_solve(struct reference *r, int degree, double far) {
  r->degree = degree;
  r->turns = 0;
  mpfr_t end, here, next;
  mpfr_inits2(REFERENCE_BITS, end, here, next, (mpfr_ptr)0);
  mpfr_set_d(end, far, MPFR_RNDN);
  for (int order = degree - 1; order >= 1; order--)
    reference_lift(r, order, end);
  r->rises = false;
  mpfr_set_zero(r->rise, 1);
  mpfr_set_zero(r->low, 1);
  mpfr_set(here, r->a[0], MPFR_RNDN);
  for (int k = 0; k <= r->turns; k++) {
    const mpfr_ptr to = k < r->turns ? r->turn[k] : end;
    reference_value(r, 0, next, to);
    if (k < r->turns) mpfr_set(r->height[k], next, MPFR_RNDN);
    if (!r->rises && mpfr_cmp(next, here) > 0 && mpfr_sgn(next) > 0) {
      r->rises = true;
      mpfr_set(r->low, k > 0 ? r->turn[k - 1] : r->rise, MPFR_RNDN);
      mpfr_set(r->high, to, MPFR_RNDN);
      if (mpfr_sgn(here) < 0)
        reference_root(r, 0, r->rise);
      else
        mpfr_set(r->rise, r->low, MPFR_RNDN);
    }
    mpfr_set(here, next, MPFR_RNDN);
  }
  mpfr_clears(end, here, next, (mpfr_ptr)0);
}

#endif
