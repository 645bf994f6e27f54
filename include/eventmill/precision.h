/* How well a run knows its key figures, while it goes on: figures over blocks of time with
 * confidence intervals that respect correlation, and the precision that a user asks for. */
#ifndef EVENTMILL_PRECISION_H
#define EVENTMILL_PRECISION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "eventmill/error.h"
#include "eventmill/interval.h"

#ifdef __cplusplus
extern "C" {
#endif

#define EM_PRECISION_LIST(X)                          \
  X(SPEED, "median(speed)", "median speed", "m/s")    \
  X(VN, "median(vn)", "median v_n", "m/s")            \
  X(RATE, "rate(vn>3)", "contacts above 3 m/s", "/s") \
  X(POWER, "power", "power", "W")
#define EM_PRECISION_ENUM(code, key, words, unit) EM_PRECISION_##code,
enum em_precision_kind { EM_PRECISION_LIST(EM_PRECISION_ENUM) EM_PRECISION_COUNT };
#undef EM_PRECISION_ENUM

/* "rate(vn>3)=1%": a figure, and the relative half width that its confidence interval shall have.
 */
struct em_precision_target {
  enum em_precision_kind kind;
  double above;  /* m/s, for RATE */
  double wanted; /* relative */
};

/* A target, found: its figure at a level of 95 %, and whether it is known as well as was wanted. */
struct em_precision_found {
  struct em_interval figure;
  bool reached;
};

/* Of targets; of independent values, from which on an interval is trusted; of blocks. */
enum { EM_PRECISION_TARGETS = 8, EM_PRECISION_LEAST = 32, EM_PRECISION_BLOCKS = 512 };

/* The bins of counts of v_n: those of em_tally.vn. */
enum { EM_PRECISION_PER_OCTAVE = 64, EM_PRECISION_LOWEST = -30, EM_PRECISION_OCTAVES = 40 };

struct em_precision;

/* NULL: no memory. */
struct em_precision *em_precision_new(void);
void em_precision_free(struct em_precision *p);

/* A block of time that follows the one before: its length (s), the median speed in it (m/s), the
 * power (W), and its counts of v_n, `classes` times the bins of em_tally.vn. Beyond
 * EM_PRECISION_BLOCKS, neighbours are joined. Errors: EM_MEMORY. */
enum em_status em_precision_add(struct em_precision *p, double time, double speed, double power,
                                const uint64_t *vn, size_t classes);

size_t em_precision_blocks(const struct em_precision *p);
double em_precision_time(const struct em_precision *p, size_t blocks); /* s, of the first ones */

/* A figure over the first `blocks` blocks at a confidence level; half NAN when they are too few. A
 * rate is known to one count in the whole time at best. */
struct em_interval em_precision_figure(const struct em_precision *p, size_t blocks,
                                       enum em_precision_kind kind, double above, double level);

/* By how much a figure of b differs from that of a, relative to a, of two runs with the same blocks
 * of time: what both have in common, as a drift, widens no interval. NAN where a's is 0. */
struct em_interval em_precision_shift(const struct em_precision *a, const struct em_precision *b,
                                      enum em_precision_kind kind, double above, double level);

/* Whether now, after a block, is a time to judge: four times while the blocks double. A run that
 * ends as soon as an interval is narrow prefers intervals that are so by chance; few looks, and
 * EM_PRECISION_LEAST independent values, leave them nearly as good as they say. */
bool em_precision_is_due(const struct em_precision *p);

/* Finds each target over all blocks (found: count, or NULL). Returns whether all are reached: the
 * value is not 0, and its half width at most what was wanted, and known from EM_PRECISION_LEAST
 * independent values. */
bool em_precision_judge(const struct em_precision *p, const struct em_precision_target *target,
                        size_t count, struct em_precision_found *found);

/* Reads targets, separated by commas; at most EM_PRECISION_TARGETS. Errors: EM_INPUT. */
enum em_status em_precision_read(struct em_precision_target *target, size_t *count,
                                 const char *text, struct em_error *err);

/* "rate(vn>2.5)" into text. */
void em_precision_name(const struct em_precision_target *target, char *text, size_t size);
const char *em_precision_words(enum em_precision_kind kind);
const char *em_precision_unit(enum em_precision_kind kind);

#ifdef __cplusplus
}
#endif

#endif
