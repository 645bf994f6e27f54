/* Nonlinear least squares with GSL's Levenberg–Marquardt. */
#include "eventmill/fit.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_errno.h>
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

static void score(struct em_fit *fit) {
  const double n = (double)fit->n, k = fit->parameters;
  fit->sigma = sqrt(fit->residual / (n - k));
  fit->aic = n * log(fit->residual / n) + 2.0 * (k + 1.0);
}

/* Standard errors: the diagonal of σ² (JᵀJ)⁻¹. */
static void errors(struct em_fit *fit, gsl_multifit_nlinear_workspace *work) {
  const size_t k = (size_t)fit->parameters;
  gsl_matrix *covariance = gsl_matrix_alloc(k, k);
  if (!covariance) return;
  gsl_multifit_nlinear_covar(gsl_multifit_nlinear_jac(work), 0.0, covariance);
  for (size_t i = 0; i < k; i++)
    fit->error[i] = fit->sigma * sqrt(gsl_matrix_get(covariance, i, i));
  gsl_matrix_free(covariance);
}

enum em_status em_fit_curve(struct em_fit *fit, const struct em_fit_model *model, size_t n,
                            const double *x, const double *y, const double *p0,
                            struct em_error *err) {
  memset(fit, 0, sizeof *fit);
  fit->parameters = model->parameters;
  fit->n = n;
  const enum em_status status = check(model, n, x, y, p0, err);
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
  const gsl_vector_const_view start = gsl_vector_const_view_array(p0, count);
  int info = 0;
  int rc = gsl_multifit_nlinear_init(&start.vector, &fdf, work);
  if (rc == GSL_SUCCESS)
    rc = gsl_multifit_nlinear_driver(500, 1e-10, 1e-12, 0.0, NULL, NULL, &info, work);
  fit->iterations = (int)gsl_multifit_nlinear_niter(work);
  /* No further progress at a point where the last steps were accepted is a minimum, too. */
  fit->converged = rc == GSL_SUCCESS || (rc == GSL_ENOPROG && fit->iterations > 1);
  for (size_t k = 0; k < count; k++)
    fit->p[k] = gsl_vector_get(work->x, k);
  gsl_blas_ddot(work->f, work->f, &fit->residual);
  score(fit);
  errors(fit, work);
  gsl_multifit_nlinear_free(work);
  if (!fit->converged && fit->iterations <= 1)
    return em_error_set(err, EM_NUMERIC, NULL, 0, "the fit does not get away from its start: %s",
                        gsl_strerror(rc));
  return EM_OK;
}
