/* A run as a succession of states to be drawn: balls, blades, trails, marks. */
#ifndef EVENTMILL_SHOW_H
#define EVENTMILL_SHOW_H

#include "eventmill/error.h"
#include "eventmill/motion.h"
#include "eventmill/picture.h"
#include "eventmill/run_file.h"

#ifdef __cplusplus
extern "C" {
#endif

struct em_show;

enum { EM_SHOW_TRAILS = 64, EM_SHOW_MARKS = 4000 };

/* Zero: neither trails nor marks. */
struct em_show_options {
  size_t trail_count;           /* ≤ EM_SHOW_TRAILS */
  size_t trail[EM_SHOW_TRAILS]; /* indices of balls that leave a trail */
  double trail_time;            /* s, how long it is */
  double mark_time;             /* s, how long a collision is marked; 0: not */
  bool classes;                 /* the states tell the balls' last contacts */
};

/* The file must outlive the show. Errors: EM_INPUT (no frames, no such ball; marks or
 * classes without a collision table), EM_MEMORY, those of the file. */
enum em_status em_show_new(struct em_show **show, const struct em_run_file *file,
                           const struct em_show_options *options, struct em_error *err);
void em_show_free(struct em_show *show);

/* Times (s) of the first and the last frame; are positions exact at all times between? */
double em_show_first(const struct em_show *show);
double em_show_last(const struct em_show *show);
bool em_show_is_exact(const struct em_show *show);

/* The state at a time (s), clamped to the frames' span; it holds until the next call. Trails are
 * followed from one call to the next, so times should rise. Errors: those of em_motion_seek. */
enum em_status em_show_at(struct em_show *show, double time, struct em_picture_state *state,
                          struct em_error *err);

/* The largest number of beads that a state can have. */
size_t em_show_bead_room(const struct em_show *show);

#ifdef __cplusplus
}
#endif

#endif
