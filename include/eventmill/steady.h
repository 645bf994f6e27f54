/* When is a series stationary? MSER (White 1997; batches as in White, Cobb & Spratt 2000) and
 * Geweke's test (1992). */
#ifndef EVENTMILL_STEADY_H
#define EVENTMILL_STEADY_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

enum em_steady_found {
  EM_STEADY_NONE,  /* MSER cuts as much as it may, half of the series */
  EM_STEADY_BRIEF, /* the rest has fewer than ten independent values: too short to tell */
  EM_STEADY_YES
};

struct em_steady {
  size_t start; /* index of the first value to use */
  enum em_steady_found found;
  double geweke; /* z of the means of the first 10 % and last 50 % after `start`; NAN: too short */
  double p;      /* its two-sided probability when the series is stationary */
};

/* How many leading values to leave out, half of them at most, so that the standard error of the
 * rest is least; values are averaged in batches first (5, fewer when the series is short). n when
 * memory is short. */
size_t em_steady_mser(const double *x, size_t n);

/* z of the difference of the means of the first 10 % and the last 50 % of x, with errors that
 * respect correlation; NAN when a part has fewer than 4 values. */
double em_steady_geweke(const double *x, size_t n);

struct em_steady em_steady_find(const double *x, size_t n);

#ifdef __cplusplus
}
#endif

#endif
