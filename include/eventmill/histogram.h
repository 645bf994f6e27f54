/* Histograms: equal bins, bins per octave (many decades at a constant relative width), or bins
 * between given edges. Figures that are read off one (quantiles, mode, shares) take the counts of
 * a bin as spread evenly over it, so fine bins serve as a compressed sample. Values beyond the
 * edges count in all of them; a figure that depends on where these lie is NAN. */
#ifndef EVENTMILL_HISTOGRAM_H
#define EVENTMILL_HISTOGRAM_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

struct em_histogram {
  size_t bins;
  double *edge;           /* bins + 1, rising, owned; in the unit of the quantity */
  double *count;          /* bins, owned; weights are allowed */
  double below;           /* weight that fell below edge[0] */
  double above;           /* weight that fell on or above edge[bins] */
  double total;           /* weight inside the edges */
  double width;           /* of equal bins; 0 for others */
  int per_octave, lowest; /* of bins per octave; 0 for others */
  bool mirrored;          /* bins per octave for both signs */
};

/* Equal bins on [low, high). NULL: no memory, or an empty range. */
struct em_histogram *em_histogram_new(size_t bins, double low, double high);

/* Bins between bins + 1 rising edges, which are copied. NULL: no memory, or edges that do not rise.
 */
struct em_histogram *em_histogram_new_edges(size_t bins, const double *edge);

/* per_octave equal bins in each octave [2^k, 2^(k+1)), k = lowest … lowest + octaves − 1; what is
 * nearer to 0 is counted in the first bin, which reaches down to 0. mirrored: the same bins for
 * negative values. */
struct em_histogram *em_histogram_new_octaves(int per_octave, int lowest, int octaves,
                                              bool mirrored);

/* An empty histogram with the bins of another. */
struct em_histogram *em_histogram_new_like(const struct em_histogram *h);
void em_histogram_free(struct em_histogram *h);

/* The bin of x, or -1 below, or `bins` above. */
ptrdiff_t em_histogram_find(const struct em_histogram *h, double x);

/* Counts x; a value that is not finite is left out. */
void em_histogram_add(struct em_histogram *h, double x, double weight);

/* Adds `weight` times the counts of another one with the same bins. */
void em_histogram_merge(struct em_histogram *h, const struct em_histogram *other, double weight);

/* What was counted, inside the edges and beyond. */
double em_histogram_weight(const struct em_histogram *h);

/* Density of bin k, normalised to area 1 over all that was counted; 0 when empty. */
double em_histogram_density(const struct em_histogram *h, size_t k);

/* Share (0 … 1) at or below x, and the x below which the share p lies. NAN when empty, or when
 * values lie beyond the edges and so does x. */
double em_histogram_share(const struct em_histogram *h, double x);
double em_histogram_quantile(const struct em_histogram *h, double p);

/* Mean of the bins' centres; NAN when empty, or when values lie beyond the edges. */
double em_histogram_mean(const struct em_histogram *h);

/* Where the density is highest: maximum of the density smoothed by a Gaussian kernel of width
 * 0.9 min(σ, IQR/1.349) n^(-1/7) (the power that is best for a mode: Romano 1988), mirrored at 0
 * when nothing is negative, and at the last edge when the values reach it and nothing lies above.
 * n: how many independent values the histogram stands for (0: its weight). NAN when empty, when
 * more than 0.1 % lie beyond an edge, or when memory is short. */
double em_histogram_mode(const struct em_histogram *h, double n);

/* The same counts in other, equal bins. NULL: no memory, or an empty range. */
struct em_histogram *em_histogram_rebin(const struct em_histogram *h, size_t bins, double low,
                                        double high);

/* √n bins, at least 1 and at most `most` (16.3 of Reichardt 2005). */
size_t em_histogram_default_bins(double n, size_t most);

#ifdef __cplusplus
}
#endif

#endif
