/* Where the balls of a run are at any time, from its frames and, where there is one, its collision
 * table.
 *
 * With a collision table every path is exact: between two contacts a ball flies freely, and the
 * table holds where each contact was. Without one, a path between two frames is a cubic through
 * both positions with their velocities (shortened, so that it does not overshoot), kept inside the
 * chamber. */
#ifndef EVENTMILL_MOTION_H
#define EVENTMILL_MOTION_H

#include "eventmill/error.h"
#include "eventmill/picture.h"
#include "eventmill/run_file.h"
#include "eventmill/start.h"

#ifdef __cplusplus
extern "C" {
#endif

struct em_motion;

/* Begins with a file that has frames; it must outlive the motion. `memory`: how long (s) contacts
 * are remembered for em_motion_marks. Errors: EM_INPUT (no balls, no frames), EM_MEMORY, those of
 * the file.
 */
enum em_status em_motion_new(struct em_motion **motion, const struct em_run_file *file,
                             double memory, struct em_error *err);
void em_motion_free(struct em_motion *motion);

/* Times (s) of the first and the last frame. */
double em_motion_first(const struct em_motion *motion);
double em_motion_last(const struct em_motion *motion);
bool em_motion_is_exact(const struct em_motion *motion);

/* Goes to a time (s), which is clamped to the frames' span. Rising times are fastest. Errors:
 * EM_MEMORY, EM_FORMAT (the file is damaged). */
enum em_status em_motion_seek(struct em_motion *motion, double time, struct em_error *err);

/* At that time: all balls (owned by the motion); one ball; the blades' angles (rad), one per blade;
 * classes of the last contacts (NULL without a collision table). */
const struct em_balls *em_motion_balls(struct em_motion *motion);
void em_motion_ball(const struct em_motion *motion, size_t ball, struct em_vec *position,
                    struct em_vec *velocity);
const double *em_motion_blades(const struct em_motion *motion);
const uint8_t *em_motion_classes(struct em_motion *motion);

/* Contacts within the last `memory` seconds as shrinking discs, at most `room` of them, the latest
 * ones, the smallest of a fifth of the radius. Returns how many contacts there were, which may be
 * more than `room`. */
size_t em_motion_marks(const struct em_motion *motion, struct em_picture_bead *bead, size_t room,
                       double radius);

#ifdef __cplusplus
}
#endif

#endif
