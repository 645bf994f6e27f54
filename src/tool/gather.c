/* Collects histograms per class and block of time from a run file. */
#include "tool/gather.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCKS = 64, FRAME_BLOCKS = 128, COARSE = 64, FINE = 1024 };

/* Octaves of the bins: speeds 2⁻³⁰ … 2³⁰ m/s, energies 2⁻⁸⁰ … 2⁴⁰ J. */
struct range {
  int lowest, octaves;
};

int em_gather_find(const char *name) {
  for (int k = 0; k < EM_GATHER_COUNT; k++)
    if (strcmp(name, em_gather_name((enum em_gather_of)k)) == 0) return k;
  return -1;
}

#define NAME(code, name, symbol, unit)   name,
#define SYMBOL(code, name, symbol, unit) symbol,
#define UNIT(code, name, symbol, unit)   unit,
static const char *const names[] = {EM_GATHER_LIST(NAME)};
static const char *const symbols[] = {EM_GATHER_LIST(SYMBOL)};
static const char *const units[] = {EM_GATHER_LIST(UNIT)};

const char *em_gather_name(enum em_gather_of of) {
  return names[of];
}

const char *em_gather_symbol(enum em_gather_of of) {
  return symbols[of];
}

const char *em_gather_unit(enum em_gather_of of) {
  return units[of];
}

void em_gather_free(struct em_gather *gather) {
  if (!gather) return;
  for (int row = 0; row < EM_GATHER_ROWS; row++) {
    for (size_t b = 0; gather->block[row] && b < gather->blocks; b++)
      em_histogram_free(gather->block[row][b]);
    free(gather->block[row]);
    em_histogram_free(gather->total[row]);
  }
  free(gather->duration);
  free(gather);
}

static struct range range_of(enum em_gather_of of) {
  if (of == EM_GATHER_ENERGY || of == EM_GATHER_LOST) return (struct range){-80, 120};
  return (struct range){-30, 60};
}

static bool is_signed(enum em_gather_of of) {
  return of == EM_GATHER_VX || of == EM_GATHER_VY || of == EM_GATHER_VZ;
}

bool em_gather_is_of_balls(enum em_gather_of of) {
  return of == EM_GATHER_SPEED || is_signed(of);
}

static struct em_histogram *make_bins(enum em_gather_of of, int per_octave) {
  if (of == EM_GATHER_IMPACT) return em_histogram_new(per_octave == FINE ? 20000 : 1000, 0.0, 1.0);
  const struct range r = range_of(of);
  return em_histogram_new_octaves(per_octave, r.lowest, r.octaves, is_signed(of));
}

/* Room for so many blocks whose bins are those of `like`. */
static bool make_blocks(struct em_gather *gather, size_t blocks, const struct em_histogram *like) {
  gather->blocks = blocks;
  gather->duration = calloc(blocks, sizeof *gather->duration);
  if (!gather->duration) return false;
  for (int row = gather->of_balls ? EM_GATHER_ALL : 0; row < EM_GATHER_ROWS; row++) {
    gather->block[row] = calloc(blocks, sizeof *gather->block[row]);
    if (!gather->block[row]) return false;
    for (size_t b = 0; b < blocks; b++)
      if (!(gather->block[row][b] = em_histogram_new_like(like))) return false;
  }
  return true;
}

static bool prepare(struct em_gather *gather, size_t blocks) {
  struct em_histogram *like = make_bins(gather->of, COARSE);
  bool good = like && make_blocks(gather, blocks, like);
  for (int row = gather->of_balls ? EM_GATHER_ALL : 0; good && row < EM_GATHER_ROWS; row++)
    good = (gather->total[row] = make_bins(gather->of, FINE)) != NULL;
  em_histogram_free(like);
  return good;
}

static void count(struct em_gather *gather, int row, size_t block, double x) {
  if (!isfinite(x)) return;
  em_histogram_add(gather->block[row][block], x, 1.0);
  em_histogram_add(gather->total[row], x, 1.0);
  if (x < gather->least[row]) gather->least[row] = x;
  if (x > gather->most[row]) gather->most[row] = x;
  gather->sum[row] += x;
}

/* ---------------------------------------------------------------- frames */

static double of_ball(enum em_gather_of of, struct em_vec v) {
  switch (of) {
  case EM_GATHER_VX:
    return v.x;
  case EM_GATHER_VY:
    return v.y;
  case EM_GATHER_VZ:
    return v.z;
  default:
    return em_vec_norm(v);
  }
}

static enum em_status from_frames(struct em_gather *gather, const struct em_run_file *run,
                                  struct em_error *err) {
  size_t first = 0, end = em_run_file_frame_count(run);
  while (first < end && em_run_file_frame_time(run, first) < gather->from)
    first++;
  while (end > first && em_run_file_frame_time(run, end - 1) > gather->to)
    end--;
  const size_t frames = end - first, blocks = frames < FRAME_BLOCKS ? frames : FRAME_BLOCKS;
  if (frames == 0)
    return em_error_set(err, EM_INPUT, em_run_file_path(run), 0,
                        "no frame between %g s and %g s; speeds of balls need record.frames > 0",
                        gather->from, gather->to);
  if (!prepare(gather, blocks)) return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  gather->frames = frames;
  struct em_balls *balls = NULL;
  enum em_status status = em_run_file_balls(run, &balls, err);
  for (size_t k = 0; status == EM_OK && k < frames; k++) {
    status = em_run_file_frame(run, first + k, balls, err);
    const size_t b = k * blocks / frames;
    gather->duration[b] += 1.0;
    for (size_t i = 0; status == EM_OK && i < balls->count; i++)
      count(gather, EM_GATHER_ALL, b, of_ball(gather->of, balls->velocity[i]));
  }
  em_start_free(balls);
  return status;
}

/* ---------------------------------------------------------------- collision table */

static unsigned columns_of(enum em_gather_of of) {
  const unsigned common = EM_COLUMN_TIME | EM_COLUMN_CLASS;
  switch (of) {
  case EM_GATHER_VN:
    return common | EM_COLUMN_VN;
  case EM_GATHER_VT:
    return common | EM_COLUMN_VT;
  case EM_GATHER_LOST:
    return common | EM_COLUMN_LOST | EM_COLUMN_VN | EM_COLUMN_BALL | EM_COLUMN_PARTNER;
  case EM_GATHER_ENERGY:
    return common | EM_COLUMN_VN | EM_COLUMN_BALL | EM_COLUMN_PARTNER;
  default:
    return common | EM_COLUMN_VN | EM_COLUMN_VT;
  }
}

double em_gather_row_energy(const struct em_rows *rows, size_t k, const struct em_balls *balls) {
  if (rows->ball[k] >= balls->count) return NAN;
  double m = balls->mass[rows->ball[k]];
  if (rows->cls[k] == EM_CLASS_BALL && rows->partner[k] < balls->count) {
    const double other = balls->mass[rows->partner[k]];
    m = m * other / (m + other);
  }
  return 0.5 * m * (double)rows->vn[k] * (double)rows->vn[k];
}

/* Below this share of a contact's energy, what it loses is rounding. */
static const double ROUNDING = 1e-12;

double em_gather_row_lost(const struct em_rows *rows, size_t k, const struct em_balls *balls) {
  const double lost = (double)rows->lost[k], energy = em_gather_row_energy(rows, k, balls);
  if (isnan(energy)) return NAN;
  return fabs(lost) > ROUNDING * energy ? lost : 0.0;
}

static double of_row(enum em_gather_of of, const struct em_rows *rows, size_t k,
                     const struct em_balls *balls) {
  switch (of) {
  case EM_GATHER_VN:
    return (double)rows->vn[k];
  case EM_GATHER_VT:
    return (double)rows->vt[k];
  case EM_GATHER_LOST:
    return em_gather_row_lost(rows, k, balls);
  case EM_GATHER_RELATIVE:
    return hypot((double)rows->vn[k], (double)rows->vt[k]);
  case EM_GATHER_IMPACT: {
    const double g = hypot((double)rows->vn[k], (double)rows->vt[k]);
    return g > 0.0 ? fmin((double)rows->vt[k] / g, 1.0 - 1e-12) : NAN;
  }
  default:
    return em_gather_row_energy(rows, k, balls);
  }
}

/* The first row at or after `time`, to within a block of rows: times are rising. */
static enum em_status seek(const struct em_run_file *run, double time, uint64_t *first,
                           struct em_error *err) {
  struct em_rows *rows = em_run_file_rows_new(EM_COLUMN_TIME);
  if (!rows) return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  uint64_t low = 0, high = em_run_file_row_count(run) / EM_ROWS_BLOCK; /* blocks */
  enum em_status status = EM_OK;
  while (low < high && status == EM_OK) {
    const uint64_t middle = low + (high - low + 1) / 2;
    status = em_run_file_rows(run, middle * EM_ROWS_BLOCK, rows, err);
    if (status == EM_OK && rows->count > 0 && rows->time[0] < time)
      low = middle;
    else
      high = middle - 1;
  }
  em_run_file_rows_free(rows);
  *first = low * EM_ROWS_BLOCK;
  return status;
}

static void count_rows(struct em_gather *gather, const struct em_rows *rows, unsigned classes,
                       const struct em_window *window, const struct em_balls *balls) {
  const double scale = (double)gather->blocks / (gather->to - gather->from);
  for (size_t k = 0; k < rows->count; k++) {
    const double t = rows->time[k];
    const int cls = rows->cls[k];
    if (!em_window_has(window, t) || cls >= EM_CLASS_COUNT) continue;
    const double x = of_row(gather->of, rows, k, balls);
    size_t b = (size_t)((t - gather->from) * scale);
    if (b >= gather->blocks) b = gather->blocks - 1;
    count(gather, cls, b, x);
    if (classes & 1U << cls) count(gather, EM_GATHER_ALL, b, x);
  }
}

static enum em_status from_rows(struct em_gather *gather, const struct em_run_file *run,
                                unsigned classes, const struct em_window *window,
                                struct em_error *err) {
  if (!prepare(gather, BLOCKS)) return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  for (size_t b = 0; b < BLOCKS; b++)
    gather->duration[b] = (gather->to - gather->from) / BLOCKS;
  struct em_rows *rows = em_run_file_rows_new(columns_of(gather->of));
  struct em_balls *balls = NULL;
  uint64_t first = 0;
  enum em_status status = rows ? em_run_file_balls(run, &balls, err)
                               : em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  if (status == EM_OK) status = seek(run, gather->from, &first, err);
  while (status == EM_OK) {
    status = em_run_file_rows(run, first, rows, err);
    if (status != EM_OK || rows->count == 0) break;
    count_rows(gather, rows, classes, window, balls);
    first += rows->count;
    if (rows->time[rows->count - 1] > gather->to) break;
  }
  em_run_file_rows_free(rows);
  em_start_free(balls);
  return status;
}

/* ---------------------------------------------------------------- online histograms */

/* Blocks whose middle lies in the window; in one that is too short for any, those it overlaps. */
static void choose_blocks(const struct em_gather *gather, const struct em_run_file *run,
                          size_t *first, size_t *end) {
  const size_t count = em_run_file_block_count(run);
  *first = *end = 0;
  for (int overlap = 0; overlap < 2 && *end == 0; overlap++)
    for (size_t k = 0; k < count; k++) {
      const double low = em_run_file_block_start(run, k), high = em_run_file_block_end(run, k);
      const double middle = 0.5 * (low + high);
      const bool in = overlap ? low < gather->to && high > gather->from
                              : middle >= gather->from && middle <= gather->to;
      if (!in) continue;
      if (*end == 0) *first = k;
      *end = k + 1;
    }
}

/* The last bin of a tally holds what lies above as well. */
static void add_tally(struct em_histogram *h, const uint64_t *counts) {
  for (size_t k = 0; k < h->bins; k++) {
    h->count[k] += (double)counts[k];
    h->total += (double)counts[k];
  }
  h->above += (double)counts[h->bins];
}

static void count_block(struct em_gather *gather, size_t b, const uint64_t *counts, size_t bins,
                        unsigned classes) {
  for (int cls = 0; cls < EM_CLASS_COUNT; cls++) {
    add_tally(gather->block[cls][b], counts + (size_t)cls * bins);
    if (classes & 1U << cls)
      add_tally(gather->block[EM_GATHER_ALL][b], counts + (size_t)cls * bins);
  }
}

static enum em_status from_online(struct em_gather *gather, const struct em_run_file *run,
                                  unsigned classes, struct em_error *err) {
  const size_t bins = em_run_file_bins(run);
  size_t first, end;
  choose_blocks(gather, run, &first, &end);
  if (bins < 2 || em_run_file_block_count(run) == 0)
    return em_error_set(err, EM_INPUT, em_run_file_path(run), 0,
                        "the run holds neither a collision table nor histograms");
  if (end == first)
    return em_error_set(err, EM_INPUT, em_run_file_path(run), 0,
                        "no block of the histograms lies between %g s and %g s", gather->from,
                        gather->to);
  gather->online = true;
  gather->from = em_run_file_block_start(run, first);
  gather->to = em_run_file_block_end(run, end - 1);
  const size_t count = end - first, blocks = count < FRAME_BLOCKS ? count : FRAME_BLOCKS;
  struct em_histogram *like = em_histogram_new_edges(bins - 1, em_run_file_edges(run));
  uint64_t *counts = malloc(EM_CLASS_COUNT * bins * sizeof *counts);
  enum em_status status = EM_OK;
  if (!like || !counts || !make_blocks(gather, blocks, like))
    status = em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  for (size_t k = 0; k < count && status == EM_OK; k++) {
    const size_t b = k * blocks / count;
    status = em_run_file_block(run, first + k, counts, err);
    gather->duration[b] +=
        em_run_file_block_end(run, first + k) - em_run_file_block_start(run, first + k);
    if (status == EM_OK) count_block(gather, b, counts, bins, classes);
  }
  for (int row = 0; row < EM_GATHER_ROWS && status == EM_OK; row++) {
    if (!(gather->total[row] = em_histogram_new_like(like)))
      status = em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
    for (size_t b = 0; status == EM_OK && b < blocks; b++)
      em_histogram_merge(gather->total[row], gather->block[row][b], 1.0);
  }
  em_histogram_free(like);
  free(counts);
  return status;
}

enum em_status em_gather_new(struct em_gather **out, const struct em_run_file *run,
                             enum em_gather_of of, unsigned classes, const struct em_window *window,
                             struct em_error *err) {
  *out = NULL;
  struct em_gather *gather = calloc(1, sizeof *gather);
  if (!gather) return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  gather->of = of;
  gather->from = window->from;
  gather->to = window->to;
  gather->of_balls = em_gather_is_of_balls(of);
  for (int row = 0; row < EM_GATHER_ROWS; row++) {
    gather->least[row] = INFINITY;
    gather->most[row] = -INFINITY;
  }
  if (classes == 0) classes = (1U << EM_CLASS_COUNT) - 1U;
  enum em_status status;
  if (gather->of_balls)
    status = from_frames(gather, run, err);
  else if (em_run_file_has_rows(run))
    status = from_rows(gather, run, classes, window, err);
  else if (of == EM_GATHER_VN)
    status = from_online(gather, run, classes, err);
  else
    status = em_error_set(err, EM_INPUT, em_run_file_path(run), 0,
                          "'%s' needs the collision table: run with record.collisions=true",
                          em_gather_name(of));
  if (status == EM_OK)
    *out = gather;
  else
    em_gather_free(gather);
  return status;
}

struct em_window em_gather_window(const struct em_gather *gather, const struct em_window *asked) {
  struct em_window used = *asked;
  used.from = gather->from;
  used.to = gather->to;
  if (gather->online && (used.from != asked->from || used.to != asked->to))
    snprintf(used.how, sizeof used.how, "%.100s; in whole blocks of the histograms", asked->how);
  return used;
}

/* ---------------------------------------------------------------- figures */

struct asked {
  enum em_gather_figure figure;
  double parameter;
};

static double evaluate(const struct em_histogram *h, double weight, void *self) {
  const struct asked *asked = self;
  switch (asked->figure) {
  case EM_GATHER_RATE:
    return em_histogram_weight(h) / weight;
  case EM_GATHER_QUANTILE: /* em_interval_quantile */
    break;
  case EM_GATHER_MODE:
    return em_histogram_mode(h, 0.0);
  case EM_GATHER_MEAN:
    return em_histogram_mean(h);
  case EM_GATHER_SHARE_ABOVE:
    return 1.0 - em_histogram_share(h, asked->parameter);
  case EM_GATHER_RATE_ABOVE:
    if (!(em_histogram_weight(h) > 0.0)) return 0.0;
    return (1.0 - em_histogram_share(h, asked->parameter)) * em_histogram_weight(h) / weight;
  }
  return NAN;
}

/* What the bins leave uncertain and the values themselves tell. */
static double refine(const struct em_gather *gather, int row, enum em_gather_figure figure,
                     double value) {
  const struct em_histogram *h = gather->total[row];
  const double least = gather->least[row], most = gather->most[row];
  if (!(least <= most)) return value;
  if (figure == EM_GATHER_MEAN) return gather->sum[row] / em_histogram_weight(h);
  if (!isnan(value) && (figure == EM_GATHER_QUANTILE || figure == EM_GATHER_MODE))
    return fmin(fmax(value, least), most);
  return value;
}

double em_gather_highest(const struct em_gather *gather, int row) {
  const struct em_histogram *h = gather->total[row];
  if (gather->least[row] <= gather->most[row]) return gather->most[row];
  for (size_t k = h->bins; h->above == 0.0 && k-- > 0;)
    if (h->count[k] > 0.0) return h->edge[k + 1];
  return NAN;
}

struct em_interval em_gather_interval(const struct em_gather *gather, int row,
                                      enum em_gather_figure figure, double parameter,
                                      double level) {
  struct asked asked = {figure, parameter};
  struct em_interval out = {NAN, NAN, NAN, 0.0, 1.0};
  if (gather->block[row] && figure == EM_GATHER_QUANTILE)
    em_interval_quantile(&out, gather->blocks, gather->block[row], parameter, level);
  else if (gather->block[row])
    em_interval_figure(&out, gather->blocks, gather->block[row], gather->duration, evaluate, &asked,
                       level);
  out.value = refine(gather, row, figure, out.value);
  return out;
}

static double share_of(const struct em_histogram *h, double weight, void *self) {
  (void)weight;
  return h->total > 0.0 ? h->count[*(int *)self] / h->total : NAN;
}

struct em_interval em_gather_share(const struct em_gather *gather, int row, double level) {
  struct em_interval out = {NAN, NAN, NAN, 0.0, 1.0};
  struct em_histogram **count = calloc(gather->blocks, sizeof *count);
  bool good = count != NULL;
  for (size_t b = 0; good && b < gather->blocks; b++) {
    good = (count[b] = em_histogram_new(2, 0.0, 2.0)) != NULL;
    if (!good) break;
    const double in = em_histogram_weight(gather->block[row][b]);
    const double all = em_histogram_weight(gather->block[EM_GATHER_ALL][b]);
    count[b]->count[0] = in;
    count[b]->count[1] = all - in;
    count[b]->total = all;
  }
  int first = 0;
  if (good)
    em_interval_figure(&out, gather->blocks, count, gather->duration, share_of, &first, level);
  for (size_t b = 0; count && b < gather->blocks; b++)
    em_histogram_free(count[b]);
  free(count);
  return out;
}
