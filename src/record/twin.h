/* A file in two copies, so that the one that the world sees is complete at every moment.
 *
 * HDF5 writes into the hidden copy PATH.next alone. em_twin_publish, called when HDF5 has closed
 * its file, makes that copy appear as PATH in one atomic rename; the former PATH becomes the hidden
 * copy and gets those pages that differ, but not before the rename is on the disk. Whenever the
 * program or the machine dies, PATH is a closed HDF5 file.
 *
 * One process at a time works on PATH: it holds a lock on PATH.lock, a file of no content that it
 * removes at the end. When PATH is a symbolic link, all this happens beside the file that it leads
 * to. */
#ifndef EVENTMILL_TWIN_H
#define EVENTMILL_TWIN_H

#include <hdf5.h>
#include <stdbool.h>

#include "eventmill/error.h"

struct em_twin;

/* Claims `path`: until em_twin_free nobody else changes what is there. Errors: EM_FILE (cannot be
 * written; another process works on it), EM_MEMORY. */
enum em_status em_twin_new(struct em_twin **twin, const char *path, struct em_error *err);

/* Makes the hidden copy: an empty one, or (from_existing) a copy of what is there. Errors: EM_FILE
 * (cannot be read or written; disk full). */
enum em_status em_twin_begin(struct em_twin *twin, bool from_existing, struct em_error *err);

/* Ends the work: the hidden copy and the lock are removed, PATH stays as it was last published. */
void em_twin_free(struct em_twin *twin);

/* A file access list that leads HDF5 to the hidden copy; to be closed by the caller. Negative: no.
 */
hid_t em_twin_access(struct em_twin *twin);

/* The name to give to H5Fcreate and H5Fopen. */
const char *em_twin_name(const struct em_twin *twin);

/* Makes the hidden copy the visible file. HDF5 must have closed it. `last`: nothing will be
 * written any more. Errors: EM_FILE (an earlier write or this one failed; PATH is as before). */
enum em_status em_twin_publish(struct em_twin *twin, bool last, struct em_error *err);

/* Was PATH ever published (or there from the beginning, when made from_existing)? */
bool em_twin_is_published(const struct em_twin *twin);

/* errno of the first write that failed, or 0. From then on writes are ignored. */
int em_twin_errno(const struct em_twin *twin);

#endif
