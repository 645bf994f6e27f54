/* What accuracy and effects cost on a scene: the variants that are measured, and what is measured.
 */
#ifndef EVENTMILL_MILL_COST_H
#define EVENTMILL_MILL_COST_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "eventmill/precision.h"
#include "eventmill/world.h"
#include "tool/progress.h"

/* Which table a variant belongs to. */
enum em_cost_group { EM_COST_ACCURACY, EM_COST_EFFECT, EM_COST_RECORDING };

/* Changes that no override can make. */
enum em_cost_change { EM_COST_AS_IS, EM_COST_NO_ROTOR, EM_COST_MIXED, EM_COST_UNMIXED };

enum { EM_COST_VARIANTS = 48, EM_COST_WORDS = 3, EM_COST_ROUNDS = 64 };
/* Whole runs cannot be cut into stretches, each with its own least time: so many times the turns.
 */
enum { EM_COST_WHOLE_RUNS = 3 };
/* s of computing below which a whole run tells nothing: starting alone varies by some 10 ms. */
#define EM_COST_LEAST_RUN 0.1

struct em_cost_variant {
  enum em_cost_group group;
  enum em_cost_change change;
  char name[64];
  size_t words;
  char word[EM_COST_WORDS][64]; /* KEY=VALUE */
};

/* Errors of contact times, over flights of the scene. */
struct em_cost_flights {
  uint64_t flights, contacts, missed, invented;
  double rms, most; /* s, of the contacts that both find */
};

struct em_cost_result {
  struct em_cost_variant variant;
  bool measured, failed; /* failed: `why` */
  char why[160];
  double time, time_low, time_high; /* computing time, relative to the scene as it is: from the
                                       least times of all stretches; least and most of the turns */
  double collisions;                /* their number, relative to the scene as it is */
  double collision;                 /* computing time per collision, relative */
  double energy;                    /* relative energy error at the end */
  struct em_interval shift[EM_PRECISION_COUNT]; /* of the key figures, relative */
  struct em_cost_flights flights;
};

struct em_cost {
  const char *path; /* of the scene */
  char *text;       /* in it, with its includes in place */
  size_t override_count;
  const char *const *overrides;
  struct em_scene *scene;       /* as it is */
  struct em_snapshot *snapshot; /* the steady state, from which all variants settle */
  struct em_snapshot *settled;  /* of the scene as it is, settled as they do */
  double steady;           /* s: begin of the steady state, and time in which a variant settles */
  double time, long_time;  /* s: simulated, in a turn; for the figures */
  char cut[160];           /* why the scene as it is cannot go on longer; or empty */
  int rounds;              /* turns */
  const char *only;        /* measure variants with this in their names; NULL: all */
  size_t flights, sampled; /* wanted; found */
  double cpu_per_time, collisions_per_time; /* 1; 1/s: of the scene as it is */
  double energy;
  struct em_precision *precision; /* of the scene as it is */
  struct em_interval figure[EM_PRECISION_COUNT];
  size_t count;
  struct em_cost_result result[EM_COST_VARIANTS];
  const volatile sig_atomic_t *stop; /* non-zero: end */
  struct em_progress *progress;
  const char *now;    /* what is measured now */
  double done, begun; /* share of all; s, wall clock */
};

/* The variants that mean something on this scene. */
void em_mill_cost_variants(struct em_cost *cost);

/* Runs to the steady state, and chooses the simulated times where `time` is NAN. */
enum em_status em_mill_cost_run_steady(struct em_cost *cost, struct em_error *err);
/* The scene as it is, for its figures. Where it collapses or jams, the times end there. */
enum em_status em_mill_cost_run_base(struct em_cost *cost, struct em_error *err);
/* One variant: settles, keeps its books, and goes in turns with the scene as it is. What keeps it
 * from that goes to the result. Errors: EM_STOPPED, EM_MEMORY. */
enum em_status em_mill_cost_run_variant(const struct em_cost *cost, struct em_cost_result *result,
                                        struct em_error *err);

/* The scene with `count` more words KEY=VALUE. Errors: those of em_scene_parse. */
enum em_status em_mill_cost_scene_with(const struct em_cost *cost, size_t count,
                                       const char *const *more, struct em_scene **scene,
                                       struct em_error *err);
/* A scene with a variant's changes, to be freed by em_mill_cost_scene_free; its rotors are hidden
 * where the variant has none: *hidden of them. */
enum em_status em_mill_cost_scene(const struct em_cost *cost, const struct em_cost_variant *variant,
                                  struct em_scene **scene, size_t *hidden, struct em_error *err);
void em_mill_cost_scene_free(struct em_scene *scene, size_t hidden);

/* A variant that records, by whole runs; times are NAN below EM_COST_LEAST_RUN. Errors: those of
 * em_recorder_run. */
enum em_status em_mill_cost_record(const struct em_cost *cost, struct em_cost_result *result,
                                   struct em_error *err);

/* Contact times of all variants of accuracy, over flights of the scene; none where it has neither
 * drum nor blades, or nothing comes to contact. */
enum em_status em_mill_cost_flights(struct em_cost *cost, struct em_error *err);

/* Tables: text or JSON to stdout, CSV to a file. Errors: EM_FILE. */
enum em_status em_mill_cost_report(const struct em_cost *cost, bool json, const char *csv,
                                   struct em_error *err);

enum { EM_COST_PICTURES = 4, EM_COST_PICTURE_PATH = EM_SCENE_PATH + 32 };

/* The path of a picture: PREFIX-accuracy.png, -effects.png, -recording.png, -statistics.png. */
void em_mill_cost_draw_path(const char *prefix, unsigned picture, char path[EM_COST_PICTURE_PATH]);

/* Draws them; says on stderr which has nothing to show. Errors: those of em_plot_draw. */
enum em_status em_mill_cost_draw(const struct em_cost *cost, const char *prefix,
                                 struct em_error *err);

/* Half width of an interval, relative to its value; 0 where it is rounding, NAN for a
 * value of 0. */
double em_mill_cost_width(const struct em_interval *figure);

static inline enum em_status em_mill_cost_no_memory(struct em_error *err) {
  return em_error_set(err, EM_MEMORY, NULL, 0, "out of memory");
}

/* Shows progress; what: of that which is measured now. */
void em_mill_cost_tell(const struct em_cost *cost, const char *what);

#endif
