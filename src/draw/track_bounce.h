/* From places before and after an impact to speeds and restitution. */
#ifndef EM_DRAW_TRACK_BOUNCE_H
#define EM_DRAW_TRACK_BOUNCE_H

#include "eventmill/error.h"
#include "eventmill/track.h"

/* Fills in what `track` says about the motion, from its spots, its scale and the frame rate; plate:
 * AUTO, or the side that is known; film: its name in messages. Errors: EM_INPUT (too few spots, or
 * they show no impact on the plate), EM_MEMORY, EM_NUMERIC. */
enum em_status em_track_bounce(struct em_track *track, double fps, enum em_track_plate plate,
                               const char *film, struct em_error *err);

#endif
