/* Nonlinear least squares with GSL's Levenberg–Marquardt. */
#include "eventmill/fit.h"

#include <float.h>
#include <gsl/gsl_blas.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <math.h>
#include <string.h>

struct table {
  const struct em_fit_model *model;
  size_t n;
  const double *x, *y;
};

static int residuals(const gsl_vector *p, void *self, gsl_vector *f) {
  const struct table *table = self;
  double q[EM_FIT_PARAMETERS];
  for (int k = 0; k < table->model->parameters; k++)
    q[k] = gsl_vector_get(p, (size_t)k);
  for (size_t i = 0; i < table->n; i++) {
    const double value = table->model->value(table->x[i], q, table->model->self);
    if (!isfinite(value)) return GSL_EDOM;
    gsl_vector_set(f, i, value - table->y[i]);
  }
  return GSL_SUCCESS;
}

static enum em_status check(const struct em_fit_model *model, size_t n, const double *x,
                            const double *y, const double *p0, struct em_error *err) {
  const int count = model->parameters;
  if (count < 1 || count > EM_FIT_PARAMETERS || n <= (size_t)count)
    return em_error_set(err, EM_INPUT, NULL, 0, "%d parameters need more than %zu points", count,
                        n);
  for (size_t i = 0; i < n; i++)
    if (!isfinite(x[i]) || !isfinite(y[i]))
      return em_error_set(err, EM_INPUT, NULL, 0, "point %zu is not finite", i + 1);
  for (size_t i = 0; i < n; i++)
    if (!isfinite(model->value(x[i], p0, model->self)))
      return em_error_set(err, EM_NUMERIC, NULL, 0, "the curve is not defined at the start values");
  return EM_OK;
}

/* Below the rounding of a curve about 1, no residual tells better from worse. */
static void score(struct em_fit *fit) {
  static const double ROUNDING = DBL_EPSILON * DBL_EPSILON;
  const double n = (double)fit->n, k = fit->parameters;
  fit->sigma = sqrt(fit->residual / (n - k));
  fit->aic = n * log(fmax(fit->residual / n, ROUNDING)) + 2.0 * (k + 1.0);
}

/* The columns of J, each of length 1; scale: their lengths, 1 for one that is 0. */
static void normalise(gsl_matrix *J, double *scale) {
  for (size_t k = 0; k < J->size2; k++) {
    gsl_vector_view column = gsl_matrix_column(J, k);
    const double length = gsl_blas_dnrm2(&column.vector);
    scale[k] = length > 0.0 ? length : 1.0;
    gsl_blas_dscal(1.0 / scale[k], &column.vector);
  }
}

/* Slopes by differences are wrong by some 1e-10 of themselves: what changes the curve less cannot
 * be seen, and what takes part in it by less is out of it. */
static const double NO_CHANGE = 1e-8, NO_PART = 1e-4;

/* Standard errors: the diagonal of σ² (JᵀJ)⁻¹ from J = U S Vᵀ. Along a direction without change the
 * parameters that take part in it are free. Returns whether all went well; J becomes U. */
static bool spread(struct em_fit *fit, gsl_matrix *J, gsl_matrix *V, gsl_matrix *room,
                   gsl_vector *S, gsl_vector *work) {
  double scale[EM_FIT_PARAMETERS] = {0.0};
  normalise(J, scale);
  if (gsl_linalg_SV_decomp_mod(J, room, V, S, work) != GSL_SUCCESS) return false;
  for (size_t i = 0; i < S->size; i++) {
    double sum = 0.0;
    for (size_t j = 0; j < S->size; j++) {
      const double s = gsl_vector_get(S, j), part = gsl_matrix_get(V, i, j);
      if (s > NO_CHANGE)
        sum += part * part / (s * s);
      else if (fabs(part) > NO_PART)
        sum = NAN;
    }
    fit->error[i] = fit->sigma * sqrt(sum) / scale[i];
  }
  return true;
}

static enum em_status errors(struct em_fit *fit, gsl_matrix *J, struct em_error *err) {
  gsl_matrix *V = gsl_matrix_alloc(J->size2, J->size2),
             *room = gsl_matrix_alloc(J->size2, J->size2);
  gsl_vector *S = gsl_vector_alloc(J->size2), *work = gsl_vector_alloc(J->size2);
  enum em_status status = EM_OK;
  if (!V || !room || !S || !work)
    status = em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a fit");
  else if (!spread(fit, J, V, room, S, work))
    status = em_error_set(err, EM_NUMERIC, NULL, 0, "the errors of a fit cannot be told");
  gsl_matrix_free(V);
  gsl_matrix_free(room);
  gsl_vector_free(S);
  gsl_vector_free(work);
  return status;
}

static enum em_status find_least(struct em_fit *fit, gsl_multifit_nlinear_fdf *fdf,
                                 gsl_multifit_nlinear_workspace *work, const double *p0,
                                 struct em_error *err) {
  const gsl_vector_const_view start = gsl_vector_const_view_array(p0, fdf->p);
  int info = 0;
  int rc = gsl_multifit_nlinear_init(&start.vector, fdf, work);
  if (rc == GSL_SUCCESS)
    rc = gsl_multifit_nlinear_driver(500, 1e-10, 1e-12, 0.0, NULL, NULL, &info, work);
  fit->iterations = (int)gsl_multifit_nlinear_niter(work);
  /* No further progress at a point where the last steps were accepted is a minimum, too. */
  fit->converged = rc == GSL_SUCCESS || (rc == GSL_ENOPROG && fit->iterations > 1);
  for (size_t k = 0; k < fdf->p; k++)
    fit->p[k] = gsl_vector_get(work->x, k);
  gsl_blas_ddot(work->f, work->f, &fit->residual);
  score(fit);
  if (!fit->converged && fit->iterations <= 1)
    return em_error_set(err, EM_NUMERIC, NULL, 0, "the fit does not get away from its start: %s",
                        gsl_strerror(rc));
  return errors(fit, gsl_multifit_nlinear_jac(work), err);
}

enum em_status em_fit_curve(struct em_fit *fit, const struct em_fit_model *model, size_t n,
                            const double *x, const double *y, const double *p0,
                            struct em_error *err) {
  memset(fit, 0, sizeof *fit);
  fit->parameters = model->parameters;
  fit->n = n;
  enum em_status status = check(model, n, x, y, p0, err);
  if (status != EM_OK) return status;
  const size_t count = (size_t)model->parameters;
  struct table table = {model, n, x, y};
  gsl_multifit_nlinear_fdf fdf = {.f = residuals, .n = n, .p = count, .params = &table};
  gsl_multifit_nlinear_parameters options = gsl_multifit_nlinear_default_parameters();
  options.fdtype = GSL_MULTIFIT_NLINEAR_CTRDIFF;
  options.h_df = 6e-6; /* third root of the rounding unit: best for central differences */
  gsl_multifit_nlinear_workspace *work =
      gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &options, n, count);
  if (!work) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a fit");
  status = find_least(fit, &fdf, work, p0, err);
  gsl_multifit_nlinear_free(work);
  return status;
}
