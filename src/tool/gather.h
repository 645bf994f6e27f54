/* Collects what the statistics are made of: histograms per class and block of time, streamed from a
 * run's frames, collision table or online histograms. Memory does not grow with the file. */
#ifndef EVENTMILL_GATHER_H
#define EVENTMILL_GATHER_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/contact.h"
#include "eventmill/histogram.h"
#include "eventmill/interval.h"
#include "eventmill/run_file.h"
#include "tool/window.h"

/* code, name, symbol on axes, unit */
#define EM_GATHER_LIST(X)                                        \
  X(VN, "vn", "normal collision speed v_n", "m/s")               \
  X(VT, "vt", "tangential collision speed v_t", "m/s")           \
  X(SPEED, "speed", "ball speed", "m/s")                         \
  X(RELATIVE, "relative", "relative speed at collisions", "m/s") \
  X(VX, "vx", "ball velocity, x", "m/s")                         \
  X(VY, "vy", "ball velocity, y", "m/s")                         \
  X(VZ, "vz", "ball velocity, z", "m/s")                         \
  X(ENERGY, "energy", "collision energy ½ m_eff v_n²", "J")      \
  X(LOST, "lost", "energy dissipated in a collision", "J")       \
  X(IMPACT, "impact", "impact parameter / sum of radii", "1")
#define EM_GATHER_ENUM(code, name, symbol, unit) EM_GATHER_##code,
enum em_gather_of { EM_GATHER_LIST(EM_GATHER_ENUM) EM_GATHER_COUNT };
#undef EM_GATHER_ENUM

enum { EM_GATHER_ALL = EM_CLASS_COUNT, EM_GATHER_ROWS = EM_CLASS_COUNT + 1 };

struct em_gather {
  enum em_gather_of of;
  bool of_balls;   /* speeds of balls in frames: counted under EM_GATHER_ALL alone, without rates */
  bool online;     /* from the online histograms: the window is that of whole blocks */
  double from, to; /* s, what was really used */
  size_t frames;   /* that were read, for quantities of balls */
  size_t blocks;
  double *duration;                            /* s, blocks */
  struct em_histogram **block[EM_GATHER_ROWS]; /* class or all, then block */
  struct em_histogram *total[EM_GATHER_ROWS];  /* the same for the whole window, in finer bins where
                                                  there are any */
  double least[EM_GATHER_ROWS], most[EM_GATHER_ROWS]; /* of all values; least > most: none, or from
                                                         the online histograms */
  double sum[EM_GATHER_ROWS];                         /* of all values */
};

int em_gather_find(const char *name); /* -1: no such quantity */
const char *em_gather_name(enum em_gather_of of);
const char *em_gather_symbol(enum em_gather_of of);
const char *em_gather_unit(enum em_gather_of of);
bool em_gather_is_of_balls(enum em_gather_of of); /* in frames; else at collisions */

/* Collects. classes: bits of those that make up EM_GATHER_ALL; 0: all four. Errors: EM_INPUT (the
 * file does not hold what the quantity needs), EM_MEMORY, and those of reading. */
enum em_status em_gather_new(struct em_gather **gather, const struct em_run_file *run,
                             enum em_gather_of of, unsigned classes, const struct em_window *window,
                             struct em_error *err);
void em_gather_free(struct em_gather *gather);

/* The window that was really used, where `asked` was asked for. */
struct em_window em_gather_window(const struct em_gather *gather, const struct em_window *asked);

/* ½ m v_n² of row k, with the reduced mass where two balls meet; NAN: there is no such ball. */
double em_gather_row_energy(const struct em_rows *rows, size_t k, const struct em_balls *balls);
/* What row k dissipates (J), 0 where it is but rounding of that energy; NAN: no such ball. */
double em_gather_row_lost(const struct em_rows *rows, size_t k, const struct em_balls *balls);

/* Figures of class `row` (or EM_GATHER_ALL) with confidence intervals at `level`. */
enum em_gather_figure {
  EM_GATHER_RATE,     /* 1/s */
  EM_GATHER_QUANTILE, /* parameter p */
  EM_GATHER_MODE,
  EM_GATHER_MEAN,
  EM_GATHER_SHARE_ABOVE, /* parameter: threshold */
  EM_GATHER_RATE_ABOVE   /* 1/s, parameter: threshold */
};
struct em_interval em_gather_interval(const struct em_gather *gather, int row,
                                      enum em_gather_figure figure, double parameter, double level);
/* The highest value; of online histograms, the end of the last bin in use. NAN: there is none, or
 * values lie beyond the bins. */
double em_gather_highest(const struct em_gather *gather, int row);
/* The share of a class among all. */
struct em_interval em_gather_share(const struct em_gather *gather, int row, double level);

#endif
