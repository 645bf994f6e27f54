/* The key figures of a run with confidence intervals: one list, used to compare runs and to scale
 * between them. */
#ifndef EVENTMILL_FIGURES_H
#define EVENTMILL_FIGURES_H

#include "eventmill/interval.h"
#include "eventmill/run_file.h"
#include "tool/window.h"

/* code, key, words, unit */
#define EM_FIGURES_LIST(X)                                            \
  X(MEDIAN_SPEED, "median_speed", "median speed of the balls", "m/s") \
  X(MEAN_SPEED, "mean_speed", "mean speed of the balls", "m/s")       \
  X(RATE, "collision_rate", "collisions", "1/s")                      \
  X(RATE_BALL, "rate_ball_ball", "  ball-ball", "1/s")                \
  X(RATE_DRUM, "rate_ball_drum", "  ball-drum", "1/s")                \
  X(RATE_END, "rate_ball_end", "  ball-end", "1/s")                   \
  X(RATE_BLADE, "rate_ball_blade", "  ball-blade", "1/s")             \
  X(MODE_VN, "mode_vn", "mode of v_n", "m/s")                         \
  X(MEDIAN_VN, "median_vn", "median of v_n", "m/s")                   \
  X(MEDIAN_VN_BALL, "median_vn_ball_ball", "  ball-ball", "m/s")      \
  X(Q75_VN, "q75_vn", "3rd quartile of v_n", "m/s")                   \
  X(SHARE_ABOVE, "share_above", "share above the threshold", "")      \
  X(RATE_ABOVE, "rate_above", "rate above the threshold", "1/s")      \
  X(POWER, "power", "power of the blades", "W")                       \
  X(DISSIPATED, "dissipated", "dissipated", "W")                      \
  X(IMPACT, "impact", "Σ ½ m_eff v_n²", "W")
#define EM_FIGURES_ENUM(code, key, words, unit) EM_FIGURES_##code,
enum em_figures_kind { EM_FIGURES_LIST(EM_FIGURES_ENUM) EM_FIGURES_COUNT };
#undef EM_FIGURES_ENUM

struct em_figures {
  struct em_window window, counted; /* counted: of the collisions, in whole blocks of histograms
                                       where there is no table */
  struct em_interval value[EM_FIGURES_COUNT]; /* value NAN: the run cannot tell */
};

const char *em_figures_key(enum em_figures_kind kind);
const char *em_figures_words(enum em_figures_kind kind);
const char *em_figures_unit(enum em_figures_kind kind);

/* The window that a figure is of. */
const struct em_window *em_figures_window(const struct em_figures *figures,
                                          enum em_figures_kind kind);

/* Computes all figures of the window [from, to] (NAN: steady start, end); threshold in m/s. Errors:
 * EM_INPUT, EM_MEMORY and those of reading. */
enum em_status em_figures_read(struct em_figures *figures, const struct em_run_file *run,
                               double from, double to, double threshold, double level,
                               struct em_error *err);

#endif
