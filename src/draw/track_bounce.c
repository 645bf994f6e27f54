/* Two parabolas of one curvature, s = a₁ + v₁ t + ½ g t² before and s = a₂ + v₂ t + ½ g t² after
 * the impact: linear least squares in (a₁, v₁, a₂, v₂, g). They meet at t* = (a₂ − a₁)/(v₁ − v₂),
 * whatever g is; the speeds are those at t*. Errors come from the covariance. Where the frames
 * cannot tell g to better than standard gravity, straight lines are fitted, and the speeds' errors
 * contain what gravity changes from the middle of each line to the impact. */
#include "draw/track_bounce.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit.h>
#include <math.h>
#include <stdlib.h>

enum { LEAST = 3, CURVED = 12, LINES = 4, MOST_PARAMETERS = 5 };

/* Above it, what was fitted is no impact; errors of measurement alone may lead above 1. */
static const double MOST_RESTITUTION = 1.5;

/* Of the centres about the curves, in radii; pixels if that is more. Above it, they are no curves.
 */
static const double WORST_SIGMA = 0.1;

static const double STANDARD_GRAVITY = 9.80665; /* m/s² */

struct bounce {
  int parameters;
  double p[MOST_PARAMETERS]; /* a1, v1, a2, v2, g */
  double cov[MOST_PARAMETERS][MOST_PARAMETERS];
  double residual;
  size_t n;
  double middle[2]; /* mean time of either side, s */
};

struct space {
  gsl_matrix *x, *cov;
  gsl_vector *y, *c;
  gsl_multifit_linear_workspace *work;
};

static void release(struct space *s) {
  if (s->x) gsl_matrix_free(s->x);
  if (s->cov) gsl_matrix_free(s->cov);
  if (s->y) gsl_vector_free(s->y);
  if (s->c) gsl_vector_free(s->c);
  if (s->work) gsl_multifit_linear_free(s->work);
}

/* t, s: n of each; the first `split` are before the impact; m: parameters. */
static enum em_status fit_with(struct bounce *b, const double *t, const double *s, size_t n,
                               size_t split, size_t m) {
  struct space w = {gsl_matrix_calloc(n, m), gsl_matrix_alloc(m, m), gsl_vector_alloc(n),
                    gsl_vector_alloc(m), gsl_multifit_linear_alloc(n, m)};
  *b = (struct bounce){.parameters = (int)m, .n = n};
  int code = GSL_ENOMEM;
  if (w.x && w.cov && w.y && w.c && w.work) {
    for (size_t k = 0; k < n; k++) {
      const size_t side = k < split ? 0 : 2;
      gsl_matrix_set(w.x, k, side, 1.0);
      gsl_matrix_set(w.x, k, side + 1, t[k]);
      if (m > LINES) gsl_matrix_set(w.x, k, LINES, 0.5 * t[k] * t[k]);
      gsl_vector_set(w.y, k, s[k]);
      b->middle[side / 2] += t[k] / (double)(k < split ? split : n - split);
    }
    code = gsl_multifit_linear(w.x, w.y, w.c, w.cov, &b->residual, w.work);
  }
  for (size_t i = 0; i < m && code == GSL_SUCCESS; i++) {
    b->p[i] = gsl_vector_get(w.c, i);
    for (size_t j = 0; j < m; j++)
      b->cov[i][j] = gsl_matrix_get(w.cov, i, j);
  }
  release(&w);
  return code == GSL_SUCCESS ? EM_OK : code == GSL_ENOMEM ? EM_MEMORY : EM_NUMERIC;
}

/* Parabolas, if their curvature can be told; else straight lines. */
static enum em_status fit(struct bounce *b, const double *t, const double *s, size_t n,
                          size_t split) {
  if (n < CURVED) return fit_with(b, t, s, n, split, LINES);
  const enum em_status status = fit_with(b, t, s, n, split, MOST_PARAMETERS);
  if (status != EM_OK || sqrt(b->cov[LINES][LINES]) < STANDARD_GRAVITY) return status;
  return fit_with(b, t, s, n, split, LINES);
}

/* Speeds at the moment of the impact, and the ratio of what leaves to what came. */
enum figure { IMPACT, BEFORE, AFTER, RATIO };

static double figure_of(const struct bounce *b, enum figure which, double at) {
  const double *p = b->p;
  const double t = isnan(at) ? (p[2] - p[0]) / (p[1] - p[3]) : at;
  const double before = p[1] + p[4] * t, after = p[3] + p[4] * t;
  return which == IMPACT ? t : which == BEFORE ? before : which == AFTER ? after : -after / before;
}

/* The split with the smallest residual of both sides together, at which the ball comes back and the
 * curves meet in between. EM_INPUT: there is none. */
static enum em_status best_split(const double *t, const double *s, size_t n, size_t *split) {
  const size_t m = n < CURVED ? LINES : MOST_PARAMETERS;
  double least = INFINITY;
  for (size_t k = LEAST; k + LEAST <= n; k++) {
    struct bounce b;
    const enum em_status status = fit_with(&b, t, s, n, k, m);
    if (status != EM_OK) return status;
    const double at = figure_of(&b, IMPACT, NAN), slack = 0.5 * (t[k] - t[k - 1]);
    const bool between = at > t[k - 1] - slack && at < t[k] + slack;
    if (between && figure_of(&b, RATIO, NAN) > 0.0 && b.residual < least) {
      least = b.residual;
      *split = k;
    }
  }
  return isfinite(least) ? EM_OK : EM_INPUT;
}

/* What gravity may have changed that straight lines do not know of, in either speed. */
static double unseen(const struct bounce *b, enum figure which, double at) {
  if (b->parameters > LINES || which == IMPACT) return 0.0;
  const double t = isnan(at) ? figure_of(b, IMPACT, NAN) : at;
  const double before = STANDARD_GRAVITY * (t - b->middle[0]),
               after = STANDARD_GRAVITY * (t - b->middle[1]);
  return which == BEFORE  ? before
         : which == AFTER ? after
                          : -after / b->p[1] + b->p[3] * before / (b->p[1] * b->p[1]);
}

/* With the error that the covariance of the parameters passes on. at: the impact, if it is known.
 */
static struct em_track_value value_of(const struct bounce *b, enum figure which, double at) {
  double slope[MOST_PARAMETERS] = {0.0}, square = 0.0;
  const double value = figure_of(b, which, at);
  for (int k = 0; k < b->parameters; k++) {
    struct bounce moved = *b;
    const double step = 1e-3 * sqrt(b->cov[k][k]);
    if (!(step > 0.0)) continue;
    moved.p[k] += step;
    slope[k] = (figure_of(&moved, which, at) - value) / step;
  }
  for (int i = 0; i < b->parameters; i++)
    for (int j = 0; j < b->parameters; j++)
      square += slope[i] * slope[j] * b->cov[i][j];
  return (struct em_track_value){value, hypot(sqrt(fmax(square, 0.0)), unseen(b, which, at))};
}

/* Places in m have the scale's error in common. */
static struct em_track_value scaled(struct em_track_value v, struct em_track_value scale) {
  v.error = hypot(v.error, v.value * scale.error / scale.value);
  return v;
}

static struct em_track_value turned(struct em_track_value v) {
  v.value = -v.value;
  return v;
}

/* The side towards which the ball flew before its velocity changed. */
static enum em_status choose_plate(enum em_track_plate *plate, const double *t, const double *x,
                                   const double *y, size_t n) {
  struct bounce bx, by;
  size_t split = 0;
  if (*plate != EM_TRACK_AUTO) return EM_OK;
  /* The coordinate that comes back; of two, the one that changes more. */
  const enum em_status sx = best_split(t, x, n, &split);
  const bool x_returns = sx == EM_OK && fit(&bx, t, x, n, split) == EM_OK;
  const double change_x = x_returns ? fabs(bx.p[3] - bx.p[1]) : 0.0;
  const enum em_status sy = best_split(t, y, n, &split);
  const bool y_returns = sy == EM_OK && fit(&by, t, y, n, split) == EM_OK;
  const double change_y = y_returns ? fabs(by.p[3] - by.p[1]) : 0.0;
  if (!x_returns && !y_returns) return sy;
  if (x_returns && (!y_returns || change_x >= change_y))
    *plate = bx.p[1] > 0.0 ? EM_TRACK_RIGHT : EM_TRACK_LEFT;
  else
    *plate = by.p[1] > 0.0 ? EM_TRACK_BOTTOM : EM_TRACK_TOP;
  return EM_OK;
}

static enum em_status analyse(struct em_track *track, double fps, const double *t, const double *x,
                              const double *y) {
  const size_t n = track->count;
  const bool level = track->plate == EM_TRACK_LEFT || track->plate == EM_TRACK_RIGHT;
  const bool negative = track->plate == EM_TRACK_LEFT || track->plate == EM_TRACK_TOP;
  const double *s = level ? x : y, *along = level ? y : x;
  struct bounce normal, tangent;
  size_t split = 0;
  enum em_status status = best_split(t, s, n, &split);
  if (status == EM_OK) status = fit(&normal, t, s, n, split);
  if (status == EM_OK) status = fit(&tangent, t, along, n, split);
  if (status != EM_OK) return status;
  const double at = figure_of(&normal, IMPACT, NAN);
  const struct em_track_value before = scaled(value_of(&normal, BEFORE, NAN), track->scale);
  const struct em_track_value after = scaled(value_of(&normal, AFTER, NAN), track->scale);
  track->before = split;
  track->after = n - split;
  track->impact = at + (double)track->spot[0].frame / fps;
  track->approach = negative ? turned(before) : before;
  track->departure = negative ? after : turned(after);
  track->restitution = value_of(&normal, RATIO, NAN);
  track->tangent_before = scaled(value_of(&tangent, BEFORE, at), track->scale);
  track->tangent_after = scaled(value_of(&tangent, AFTER, at), track->scale);
  track->gravity = negative ? -normal.p[4] : normal.p[4];
  track->sigma =
      sqrt(normal.residual / (double)(n - (size_t)normal.parameters)) / track->scale.value;
  return EM_OK;
}

/* Across more frames than are seen on a side, a curve is a guess. */
static enum em_status judge_gap(const struct em_track *track, const char *film,
                                struct em_error *err) {
  const struct em_track_spot *next = track->spot + track->before;
  const size_t gap = next->frame - next[-1].frame - 1;
  const size_t least = track->before < track->after ? track->before : track->after;
  if (gap <= least) return EM_OK;
  return em_error_set(err, EM_INPUT, film, 0,
                      "the ball is lost in the %zu frames about the impact, from %zu to %zu; it is "
                      "found in %zu before and %zu after them: too few to tell the speeds",
                      gap, next[-1].frame + 1, next->frame - 1, track->before, track->after);
}

/* What was found must be an impact on the plate. */
static enum em_status judge(const struct em_track *track, enum em_status status, const char *film,
                            struct em_error *err) {
  const struct em_track_value *e = &track->restitution;
  const double worst = fmax(WORST_SIGMA * track->radius.value, 1.0);
  if (status == EM_MEMORY) return em_error_set(err, status, film, 0, "no memory for a fit");
  if (status == EM_INPUT)
    return em_error_set(err, status, film, 0,
                        "the ball does not come back: no impact is to be seen");
  if (status != EM_OK)
    return em_error_set(err, status, film, 0, "no curve can be fitted to the centres");
  if (!(track->approach.value > 0.0 && track->departure.value > 0.0))
    return em_error_set(err, EM_INPUT, film, 0,
                        "the ball does not fly towards the plate at the side '%s' and back",
                        em_track_plate_name(track->plate));
  if (track->sigma > worst)
    return em_error_set(err, EM_INPUT, film, 0,
                        "the ball's centres scatter by %.2g pixels about two parabolas, at most "
                        "%.2g are possible: frames are missing or out of order, or it is no ball",
                        track->sigma, worst);
  if (e->value <= MOST_RESTITUTION) return judge_gap(track, film, err);
  return em_error_set(err, EM_INPUT, film, 0,
                      "no impact on a plate: the ball would leave it at %.3g ± %.2g of the speed "
                      "with which it came, at most %g is possible",
                      e->value, e->error, MOST_RESTITUTION);
}

enum em_status em_track_bounce(struct em_track *track, double fps, enum em_track_plate plate,
                               const char *film, struct em_error *err) {
  const size_t n = track->count;
  if (n < 2 * LEAST + 1)
    return em_error_set(err, EM_INPUT, film, 0,
                        "the ball is found in %zu of %zu frames; %d are needed", n, track->frames,
                        2 * LEAST + 1);
  double *t = calloc(3 * n, sizeof *t);
  if (t == NULL) return em_error_set(err, EM_MEMORY, film, 0, "no memory for the places of a ball");
  double *x = t + n, *y = x + n;
  for (size_t k = 0; k < n; k++) {
    t[k] = (double)(track->spot[k].frame - track->spot[0].frame) / fps;
    x[k] = track->spot[k].x * track->scale.value;
    y[k] = track->spot[k].y * track->scale.value;
  }
  track->plate = plate;
  enum em_status status = choose_plate(&track->plate, t, x, y, n);
  if (status == EM_OK) status = analyse(track, fps, t, x, y);
  free(t);
  return judge(track, status, film, err);
}
