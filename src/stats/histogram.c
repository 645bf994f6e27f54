/* Histograms with equal bins, bins per octave, or given edges. */
#include "eventmill/histogram.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static struct em_histogram *allocate(size_t bins) {
  if (bins < 1 || bins > (size_t)1 << 28) return NULL;
  struct em_histogram *h = calloc(1, sizeof *h);
  if (!h) return NULL;
  h->bins = bins;
  h->edge = malloc((bins + 1) * sizeof *h->edge);
  h->count = calloc(bins, sizeof *h->count);
  if (h->edge && h->count) return h;
  em_histogram_free(h);
  return NULL;
}

struct em_histogram *em_histogram_new(size_t bins, double low, double high) {
  if (!(low < high) || !isfinite(low) || !isfinite(high)) return NULL;
  struct em_histogram *h = allocate(bins);
  if (!h) return NULL;
  h->width = (high - low) / (double)bins;
  for (size_t k = 0; k < bins; k++)
    h->edge[k] = low + (high - low) * ((double)k / (double)bins);
  h->edge[bins] = high;
  return h;
}

struct em_histogram *em_histogram_new_edges(size_t bins, const double *edge) {
  for (size_t k = 0; k < bins; k++)
    if (!(edge[k] < edge[k + 1])) return NULL;
  struct em_histogram *h = allocate(bins);
  if (h) memcpy(h->edge, edge, (bins + 1) * sizeof *edge);
  return h;
}

struct em_histogram *em_histogram_new_octaves(int per_octave, int lowest, int octaves,
                                              bool mirrored) {
  if (per_octave < 1 || octaves < 1) return NULL;
  const size_t half = (size_t)per_octave * (size_t)octaves;
  struct em_histogram *h = allocate(mirrored ? 2 * half : half);
  if (!h) return NULL;
  h->per_octave = per_octave;
  h->lowest = lowest;
  h->mirrored = mirrored;
  const size_t zero = mirrored ? half : 0;
  for (size_t k = 0; k <= half; k++) {
    const int octave = (int)(k / (size_t)per_octave);
    const double within = (double)(k % (size_t)per_octave) / per_octave;
    const double edge = k == 0 ? 0.0 : ldexp(1.0 + within, lowest + octave);
    h->edge[zero + k] = edge;
    if (mirrored && k > 0) h->edge[zero - k] = -edge;
  }
  return h;
}

struct em_histogram *em_histogram_new_like(const struct em_histogram *h) {
  struct em_histogram *copy = allocate(h->bins);
  if (!copy) return NULL;
  memcpy(copy->edge, h->edge, (h->bins + 1) * sizeof *h->edge);
  copy->width = h->width;
  copy->per_octave = h->per_octave;
  copy->lowest = h->lowest;
  copy->mirrored = h->mirrored;
  return copy;
}

void em_histogram_free(struct em_histogram *h) {
  if (!h) return;
  free(h->edge);
  free(h->count);
  free(h);
}

/* Bin of x ≥ 0 among the bins per octave of one sign; may lie beyond the last. */
static ptrdiff_t find_octave(const struct em_histogram *h, double x) {
  int exponent;
  const double mantissa = 2.0 * frexp(x, &exponent); /* [1, 2) */
  const ptrdiff_t octave = (ptrdiff_t)exponent - 1 - h->lowest;
  if (x <= 0.0 || octave < 0) return 0;
  const double *edge = h->mirrored ? h->edge + h->bins / 2 : h->edge;
  ptrdiff_t k = octave * h->per_octave + (ptrdiff_t)((mantissa - 1.0) * h->per_octave);
  if (x < edge[k]) k--; /* rounding: the edges decide */
  if (x >= edge[k + 1]) k++;
  return k;
}

static ptrdiff_t find_edge(const struct em_histogram *h, double x) {
  size_t low = 0, high = h->bins; /* edge[low] ≤ x < edge[high] */
  while (high - low > 1) {
    const size_t middle = (low + high) / 2;
    if (x < h->edge[middle])
      high = middle;
    else
      low = middle;
  }
  return (ptrdiff_t)low;
}

ptrdiff_t em_histogram_find(const struct em_histogram *h, double x) {
  const ptrdiff_t bins = (ptrdiff_t)h->bins;
  if (x < h->edge[0]) return -1;
  if (!(x < h->edge[bins])) return bins;
  if (h->per_octave > 0 && !h->mirrored) return find_octave(h, x);
  if (h->per_octave > 0) {
    const ptrdiff_t k = x == h->edge[0] ? bins / 2 - 1 : find_octave(h, fabs(x));
    return x >= 0.0 ? bins / 2 + k : bins / 2 - 1 - k;
  }
  if (!(h->width > 0.0)) return find_edge(h, x);
  ptrdiff_t k = (ptrdiff_t)((x - h->edge[0]) / h->width);
  if (k > bins - 1) k = bins - 1;
  while (x < h->edge[k])
    k--; /* rounding: the edges decide */
  while (x >= h->edge[k + 1])
    k++;
  return k;
}

void em_histogram_add(struct em_histogram *h, double x, double weight) {
  if (!isfinite(x)) return;
  const ptrdiff_t k = em_histogram_find(h, x);
  if (k < 0) {
    h->below += weight;
  } else if (k >= (ptrdiff_t)h->bins) {
    h->above += weight;
  } else {
    h->count[k] += weight;
    h->total += weight;
  }
}

void em_histogram_merge(struct em_histogram *h, const struct em_histogram *other, double weight) {
  for (size_t k = 0; k < h->bins; k++)
    h->count[k] += weight * other->count[k];
  h->below += weight * other->below;
  h->above += weight * other->above;
  h->total += weight * other->total;
}

double em_histogram_weight(const struct em_histogram *h) {
  return h->below + h->total + h->above;
}

double em_histogram_density(const struct em_histogram *h, size_t k) {
  const double all = em_histogram_weight(h);
  return all > 0.0 ? h->count[k] / (all * (h->edge[k + 1] - h->edge[k])) : 0.0;
}

double em_histogram_share(const struct em_histogram *h, double x) {
  const double all = em_histogram_weight(h);
  if (!(all > 0.0)) return NAN;
  const ptrdiff_t bin = em_histogram_find(h, x);
  if (bin < 0) return h->below > 0.0 ? NAN : 0.0;
  if (bin >= (ptrdiff_t)h->bins && h->above > 0.0) return NAN;
  double sum = h->below;
  for (ptrdiff_t k = 0; k < bin; k++)
    sum += h->count[k];
  if (bin < (ptrdiff_t)h->bins)
    sum += h->count[bin] * (x - h->edge[bin]) / (h->edge[bin + 1] - h->edge[bin]);
  return sum / all;
}

double em_histogram_quantile(const struct em_histogram *h, double p) {
  const double all = em_histogram_weight(h);
  double left = p * all - h->below;
  if (!(all > 0.0) || left < 0.0) return NAN;
  for (size_t k = 0; k < h->bins; k++) {
    const double count = h->count[k];
    if (count > 0.0 && left <= count)
      return h->edge[k] + (h->edge[k + 1] - h->edge[k]) * (left / count);
    left -= count;
  }
  if (h->above > 0.0) return NAN;
  for (size_t k = h->bins; k-- > 0;) /* rounding: the end of the last bin in use */
    if (h->count[k] > 0.0) return h->edge[k + 1];
  return NAN;
}

/* Mean of the bins' centres. */
static double centre(const struct em_histogram *h) {
  double sum = 0.0;
  for (size_t k = 0; k < h->bins; k++)
    sum += h->count[k] * 0.5 * (h->edge[k] + h->edge[k + 1]);
  return sum / h->total;
}

double em_histogram_mean(const struct em_histogram *h) {
  return h->total > 0.0 && h->below == 0.0 && h->above == 0.0 ? centre(h) : NAN;
}

struct em_histogram *em_histogram_rebin(const struct em_histogram *h, size_t bins, double low,
                                        double high) {
  struct em_histogram *out = em_histogram_new(bins, low, high);
  if (!out) return NULL;
  out->below = h->below;
  out->above = h->above;
  for (size_t k = 0; k < h->bins; k++) {
    const double count = h->count[k], a = h->edge[k], b = h->edge[k + 1];
    if (count == 0.0) continue;
    if (a < low) out->below += count * (fmin(b, low) - a) / (b - a);
    if (b > high) out->above += count * (b - fmax(a, high)) / (b - a);
    if (b <= low || a >= high) continue;
    ptrdiff_t j = em_histogram_find(out, fmax(a, low));
    for (; j < (ptrdiff_t)bins && out->edge[j] < b; j++) {
      const double part = fmin(b, out->edge[j + 1]) - fmax(a, out->edge[j]);
      if (part <= 0.0) continue;
      out->count[j] += count * part / (b - a);
      out->total += count * part / (b - a);
    }
  }
  return out;
}

/* Standard deviation of the bins' centres. */
static double spread(const struct em_histogram *h) {
  const double mean = centre(h);
  double sum = 0.0;
  for (size_t k = 0; k < h->bins; k++) {
    const double d = 0.5 * (h->edge[k] + h->edge[k + 1]) - mean;
    sum += h->count[k] * d * d;
  }
  return sqrt(sum / h->total);
}

/* Vertex of the parabola through three equidistant values, as an offset in steps. */
static double vertex(double left, double middle, double right) {
  const double bend = left - 2.0 * middle + right;
  return bend < 0.0 ? 0.5 * (left - right) / bend : 0.0;
}

/* Maximum of the kernel density of equal bins. Where the range has a bound, what lies beyond it is
 * folded back: bin −1 is bin 0 again, and bin `bins` the last one. */
static double highest(const struct em_histogram *g, double sigma, bool bound_low, bool bound_high) {
  const ptrdiff_t bins = (ptrdiff_t)g->bins, reach = (ptrdiff_t)ceil(4.0 * sigma / g->width);
  double *kernel = malloc(((size_t)reach + 1) * sizeof *kernel);
  double *smooth = calloc(g->bins, sizeof *smooth);
  double mode = NAN;
  if (kernel && smooth) {
    for (ptrdiff_t d = 0; d <= reach; d++) {
      const double x = (double)d * g->width / sigma;
      kernel[d] = exp(-0.5 * x * x);
    }
    ptrdiff_t best = 0;
    for (ptrdiff_t k = 0; k < bins; k++) {
      for (ptrdiff_t d = -reach; d <= reach; d++) {
        ptrdiff_t j = k + d;
        if (j < 0 && bound_low) j = -1 - j;
        if (j >= bins && bound_high) j = 2 * bins - 1 - j;
        if (j >= 0 && j < bins) smooth[k] += g->count[j] * kernel[d < 0 ? -d : d];
      }
      if (smooth[k] > smooth[best]) best = k;
    }
    const double left = smooth[best > 0 ? best - 1 : 0];
    const double right = smooth[best < bins - 1 ? best + 1 : bins - 1];
    mode = g->edge[best] + (0.5 + vertex(left, smooth[best], right)) * g->width;
  }
  free(kernel);
  free(smooth);
  return mode;
}

double em_histogram_mode(const struct em_histogram *h, double n) {
  if (!(h->total > 0.0)) return NAN;
  if (!(n > 0.0)) n = em_histogram_weight(h);
  const double iqr = em_histogram_quantile(h, 0.75) - em_histogram_quantile(h, 0.25);
  double scale = spread(h);
  if (iqr > 0.0 && iqr / 1.349 < scale) scale = iqr / 1.349;
  const double sigma = 0.9 * scale * pow(n, -1.0 / 7.0);
  if (sigma == 0.0) return em_histogram_quantile(h, 0.5);
  double high = em_histogram_quantile(h, 0.999) + 3.0 * sigma;
  double low = em_histogram_quantile(h, 0.001) - 3.0 * sigma;
  if (isnan(low) || isnan(high)) return NAN;
  const bool bound_low = h->edge[0] >= 0.0;
  const bool bound_high = h->above == 0.0 && high > h->edge[h->bins];
  if (bound_low) low = 0.0;
  if (bound_high) high = h->edge[h->bins];
  size_t bins = (size_t)ceil((high - low) / (0.25 * sigma));
  if (bins > 4096) bins = 4096;
  struct em_histogram *grid = em_histogram_rebin(h, bins, low, high);
  if (!grid) return NAN;
  const double mode = highest(grid, fmax(sigma, grid->width), bound_low, bound_high);
  em_histogram_free(grid);
  return mode;
}

size_t em_histogram_default_bins(double n, size_t most) {
  const double bins = ceil(sqrt(fmax(n, 1.0)));
  return bins < (double)most ? (size_t)bins : most;
}
