/* Real polynomials of low degree, coefficients in rising order: values, roots, first rise. */
#ifndef EVENTMILL_NUM_POLY_H
#define EVENTMILL_NUM_POLY_H

enum { EM_POLY_DEGREE = 4 };

/* a[0] + a[1] x + … + a[degree] x^degree, by Horner's scheme. */
double em_poly_value(const double *a, int degree, double x);

/* The real roots of a + b x + c x² in rising order without cancellation; returns how many (a double
 * root counts once, a vanishing polynomial has none). */
int em_poly_quadratic(double a, double b, double c, double root[2]);

/* Closed forms (Cardano and Viète; Ferrari) for the real roots, in no particular order; the leading
 * coefficient must not be 0. Fast, but good to half the digits only where roots lie close together
 * or are of very different size. Return the number of roots. */
int em_poly_cubic(const double a[4], double root[3]);
int em_poly_quartic(const double a[5], double root[4]);

/* The places in (low, high) where the polynomial changes its sign, rising, each as precise as
 * double allows: the roots of the derivatives bracket those of the polynomial. degree ≤
 * EM_POLY_DEGREE. Returns their number. */
int em_poly_changes(const double *a, int degree, double low, double high,
                    double root[EM_POLY_DEGREE]);

/* The first x ≥ 0 at which the polynomial is ≥ 0 and rises; INFINITY if there is none. */
double em_poly_first_rise(const double *a, int degree);

/* No root is larger (Fujiwara 1916); 0 for a constant. */
double em_poly_root_bound(const double *a, int degree);

#endif
