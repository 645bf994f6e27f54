/* Key figures over blocks of time, and the precision that is asked of them. */
#include "eventmill/precision.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "num/locale.h"

enum { BINS = EM_PRECISION_PER_OCTAVE * EM_PRECISION_OCTAVES };

struct em_precision {
  size_t count, each; /* blocks; how many of those that came are joined in one */
  size_t open;        /* of these, how many the last one has */
  /* One more than are kept: a block that is to be joined comes after the last. */
  double time[EM_PRECISION_BLOCKS + 1], speed[EM_PRECISION_BLOCKS + 1];
  double power[EM_PRECISION_BLOCKS + 1];
  struct em_histogram *vn[EM_PRECISION_BLOCKS + 1];
};

#define KEY(code, key, words, unit)   key,
#define WORDS(code, key, words, unit) words,
#define UNIT(code, key, words, unit)  unit,
static const char *const keys[] = {EM_PRECISION_LIST(KEY)};
static const char *const all_words[] = {EM_PRECISION_LIST(WORDS)};
static const char *const units[] = {EM_PRECISION_LIST(UNIT)};

const char *em_precision_words(enum em_precision_kind kind) {
  return all_words[kind];
}

const char *em_precision_unit(enum em_precision_kind kind) {
  return units[kind];
}

struct em_precision *em_precision_new(void) {
  struct em_precision *p = calloc(1, sizeof *p);
  if (p) p->each = 1;
  return p;
}

void em_precision_free(struct em_precision *p) {
  for (size_t k = 0; p && k < p->count; k++)
    em_histogram_free(p->vn[k]);
  free(p);
}

/* Adds block `from` to block `to`. */
static void join(struct em_precision *p, size_t to, size_t from) {
  const double a = p->time[to], b = p->time[from], sum = a + b;
  p->speed[to] = (a * p->speed[to] + b * p->speed[from]) / sum;
  p->power[to] = (a * p->power[to] + b * p->power[from]) / sum;
  p->time[to] = sum;
  em_histogram_merge(p->vn[to], p->vn[from], 1.0);
}

static void join_neighbours(struct em_precision *p) {
  for (size_t k = 0; k < p->count / 2; k++) {
    join(p, 2 * k, 2 * k + 1);
    em_histogram_free(p->vn[2 * k + 1]);
    p->time[k] = p->time[2 * k];
    p->speed[k] = p->speed[2 * k];
    p->power[k] = p->power[2 * k];
    p->vn[k] = p->vn[2 * k];
  }
  p->count /= 2;
  p->each *= 2;
}

enum em_status em_precision_add(struct em_precision *p, double time, double speed, double power,
                                const uint64_t *vn, size_t classes) {
  struct em_histogram *h = em_histogram_new_octaves(EM_PRECISION_PER_OCTAVE, EM_PRECISION_LOWEST,
                                                    EM_PRECISION_OCTAVES, false);
  if (!h) return EM_MEMORY;
  for (size_t c = 0; c < classes; c++) { /* the last bin holds what lies above as well */
    for (size_t k = 0; k < BINS - 1; k++)
      h->count[k] += (double)vn[c * BINS + k];
    h->above += (double)vn[c * BINS + BINS - 1];
  }
  for (size_t k = 0; k < BINS - 1; k++)
    h->total += h->count[k];
  if (p->count == EM_PRECISION_BLOCKS && p->open == p->each) {
    join_neighbours(p);
    p->open = p->each;
  }
  const size_t k = p->count;
  p->time[k] = time;
  p->speed[k] = speed;
  p->power[k] = power;
  p->vn[k] = h;
  if (p->count > 0 && p->open < p->each) {
    join(p, k - 1, k);
    em_histogram_free(h);
    p->open++;
  } else {
    p->count++;
    p->open = 1;
  }
  return EM_OK;
}

size_t em_precision_blocks(const struct em_precision *p) {
  return p->count;
}

double em_precision_time(const struct em_precision *p, size_t blocks) {
  double sum = 0.0;
  for (size_t k = 0; k < blocks && k < p->count; k++)
    sum += p->time[k];
  return sum;
}

static double above(const struct em_histogram *h, double x) {
  const double all = em_histogram_weight(h);
  return all > 0.0 ? all * (1.0 - em_histogram_share(h, x)) : 0.0;
}

struct em_interval em_precision_figure(const struct em_precision *p, size_t blocks,
                                       enum em_precision_kind kind, double limit, double level) {
  struct em_interval out = {NAN, NAN, NAN, 0.0, 1.0};
  if (blocks > p->count) blocks = p->count;
  if (blocks == 0) return out;
  if (kind == EM_PRECISION_SPEED) return em_interval_series(p->speed, blocks, level);
  if (kind == EM_PRECISION_POWER) return em_interval_series(p->power, blocks, level);
  if (kind == EM_PRECISION_RATE) {
    double rate[EM_PRECISION_BLOCKS];
    for (size_t k = 0; k < blocks; k++)
      rate[k] = above(p->vn[k], limit) / p->time[k];
    out = em_interval_series(rate, blocks, level);
    const double one_count = 1.0 / em_precision_time(p, blocks);
    if (out.half < one_count) out.half = one_count; /* NAN stays */
    return out;
  }
  if (em_interval_quantile(&out, blocks, p->vn, 0.5, level))
    out = (struct em_interval){NAN, NAN, NAN, 0.0, 1.0};
  return out;
}

/* A figure of one block. */
static double of_block(const struct em_precision *p, size_t k, enum em_precision_kind kind,
                       double limit) {
  switch (kind) {
  case EM_PRECISION_SPEED:
    return p->speed[k];
  case EM_PRECISION_POWER:
    return p->power[k];
  case EM_PRECISION_RATE:
    return above(p->vn[k], limit) / p->time[k];
  case EM_PRECISION_VN:
  case EM_PRECISION_COUNT:
    break;
  }
  return em_histogram_quantile(p->vn[k], 0.5);
}

struct em_interval em_precision_shift(const struct em_precision *a, const struct em_precision *b,
                                      enum em_precision_kind kind, double limit, double level) {
  const size_t n = a->count < b->count ? a->count : b->count;
  const double from = em_precision_figure(a, n, kind, limit, level).value;
  const double to = em_precision_figure(b, n, kind, limit, level).value;
  double off[EM_PRECISION_BLOCKS];
  size_t used = 0;
  for (size_t k = 0; k < n; k++) {
    const double d = of_block(b, k, kind, limit) - of_block(a, k, kind, limit);
    if (isfinite(d)) off[used++] = d / fabs(from); /* a block without contacts has no median */
  }
  struct em_interval shift = em_interval_series(off, used, level);
  shift.value = (to - from) / fabs(from);
  if (isfinite(shift.value)) return shift;
  return (struct em_interval){NAN, NAN, NAN, 0.0, 1.0};
}

/* ---------------------------------------------------------------- when it is enough */

/* The last block may still wait for what is to be joined with it. */
static size_t complete(const struct em_precision *p) {
  return p->open < p->each ? p->count - (p->count > 0) : p->count;
}

/* After 4, 5, 6 and 7 times a power of two blocks, at which no joined one is open. */
bool em_precision_is_due(const struct em_precision *p) {
  size_t came = p->count > 0 ? (p->count - 1) * p->each + p->open : 0;
  if (came < EM_PRECISION_LEAST) return false;
  for (; came >= 8; came /= 2)
    if (came % 2) return false;
  return true;
}

/* Degrees of freedom that an error has by EM_PRECISION_LEAST independent values of a series that
 * remembers: half of them. One that sways has fewer, however little its mean does. */
static const double LEAST_FREEDOM = EM_PRECISION_LEAST / 2 - 1;

bool em_precision_judge(const struct em_precision *p, const struct em_precision_target *target,
                        size_t count, struct em_precision_found *found) {
  const size_t blocks = complete(p);
  bool all = true;
  for (size_t k = 0; k < count; k++) {
    const struct em_precision_target *t = &target[k];
    const struct em_interval f = em_precision_figure(p, blocks, t->kind, t->above, 0.95);
    const bool trusted =
        (double)blocks >= EM_PRECISION_LEAST * f.inefficiency && f.freedom >= LEAST_FREEDOM;
    const bool narrow = f.value != 0.0 && f.half <= t->wanted * fabs(f.value);
    if (found) found[k] = (struct em_precision_found){f, trusted && narrow};
    all = all && trusted && narrow;
  }
  return all;
}

/* ---------------------------------------------------------------- what is asked for */

static const char BLANKS[] = " \t";

static enum em_status refuse(const char *text, struct em_error *err) {
  return em_error_set(
      err, EM_INPUT, NULL, 0,
      "'%s': expected median(speed), median(vn), rate(vn>SPEED) or power, '=', and a "
      "precision such as 1%% or 0.01",
      text);
}

/* "rate(vn>3)" and the like; blanks may stand between its parts. */
static bool read_figure(struct em_precision_target *target, const char *name) {
  int length = 0;
  for (int k = 0; k < EM_PRECISION_COUNT; k++)
    if (strcmp(name, keys[k]) == 0) {
      target->kind = (enum em_precision_kind)k;
      return true;
    }
  target->kind = EM_PRECISION_RATE;
  return sscanf(name, "rate ( vn > %lf )%n", &target->above, &length) == 1 &&
         name[length] == '\0' && target->above >= 0.0 && target->above < INFINITY;
}

/* "1 %" or "0.01". */
static bool read_wanted(struct em_precision_target *target, const char *text) {
  char *end;
  target->wanted = strtod(text, &end);
  if (end == text) return false;
  end += strspn(end, BLANKS);
  if (*end == '%') {
    target->wanted *= 0.01;
    end += 1 + strspn(end + 1, BLANKS);
  }
  return *end == '\0' && target->wanted > 0.0 && target->wanted < 1.0;
}

/* Cuts the text at its "=". */
static enum em_status read_one(struct em_precision_target *target, char *text,
                               struct em_error *err) {
  *target = (struct em_precision_target){.above = 3.0};
  char *name = text + strspn(text, BLANKS), *equal = strchr(name, '=');
  if (!equal || !read_wanted(target, equal + 1)) return refuse(text, err);
  char *end = equal;
  while (end > name && strchr(BLANKS, end[-1]))
    end--;
  const char cut = *end;
  *end = '\0';
  const bool known = read_figure(target, name);
  *end = cut;
  return known ? EM_OK : refuse(text, err);
}

enum em_status em_precision_read(struct em_precision_target *target, size_t *count,
                                 const char *text, struct em_error *err) {
  EM_LOCALE_PLAIN;
  char *copy = strdup(text), *rest = NULL;
  if (!copy) return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
  enum em_status status = EM_OK;
  *count = 0;
  for (char *word = strtok_r(copy, ",", &rest); word && !status; word = strtok_r(NULL, ",", &rest))
    status = *count < EM_PRECISION_TARGETS ? read_one(&target[(*count)++], word, err)
                                           : refuse(text, err);
  if (!status && *count == 0) status = refuse(text, err);
  free(copy);
  return status;
}

void em_precision_name(const struct em_precision_target *target, char *text, size_t size) {
  EM_LOCALE_PLAIN;
  if (target->kind == EM_PRECISION_RATE)
    snprintf(text, size, "rate(vn>%g)", target->above);
  else
    snprintf(text, size, "%s", keys[target->kind]);
}
