/* The engine's state in a run file. */
#ifndef EVENTMILL_CHECKPOINT_H
#define EVENTMILL_CHECKPOINT_H

#include "eventmill/world.h"
#include "record/h5.h"

/* Makes the datasets for snapshots of this size. */
bool em_checkpoint_create(hid_t file, const struct em_snapshot *snapshot);
/* Writes a snapshot into them; both sizes must agree. */
bool em_checkpoint_write(hid_t file, const struct em_snapshot *snapshot);
/* Reads it; NULL with err filled: EM_FORMAT, EM_MEMORY. balls, blades, spin: what the scene says.
 */
struct em_snapshot *em_checkpoint_read(hid_t file, const char *name, size_t balls, size_t blades,
                                       bool spin, struct em_error *err);

#endif
