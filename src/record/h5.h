/* Small things done with HDF5: attributes, growing and fixed datasets, all with checksums.
 * Functions return false when HDF5 reports a failure; reading ones also when type or size is not as
 * expected. */
#ifndef EVENTMILL_H5_H
#define EVENTMILL_H5_H

#include <hdf5.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { EM_H5_RANK = 4 };

/* Shape of a dataset; dims[0] is the row count of a growing one. */
struct em_h5_shape {
  int rank;
  hsize_t dims[EM_H5_RANK];
};

/* HDF5 shall not print (it does by default, per thread). */
void em_h5_quiet(void);

/* Creates the group and those above it. */
bool em_h5_group(hid_t file, const char *path);
bool em_h5_exists(hid_t file, const char *path);
bool em_h5_link(hid_t file, const char *from, const char *to); /* hard link */

/* Attributes of the object at `path`; an existing one of that name is replaced. */
bool em_h5_put_text(hid_t file, const char *path, const char *name, const char *text);
bool em_h5_put_texts(hid_t file, const char *path, const char *name, size_t count,
                     const char *const *texts);
bool em_h5_put_numbers(hid_t file, const char *path, const char *name, hid_t file_type,
                       hid_t memory_type, size_t count, const void *numbers); /* 0: scalar */
bool em_h5_put_double(hid_t file, const char *path, const char *name, double number);
bool em_h5_put_count(hid_t file, const char *path, const char *name, uint64_t number);

/* Text is cut to size - 1 bytes. */
bool em_h5_get_text(hid_t file, const char *path, const char *name, char *text, size_t size);
bool em_h5_get_numbers(hid_t file, const char *path, const char *name, hid_t memory_type,
                       size_t count, void *numbers); /* count 0: one */

/* Deflate level of measured numbers where the scene asks for `deflate`: below 4 they are stored as
 * they are. Their mantissas are noise: deflate would take a sixth of the time of a mill's run to
 * make frames a tenth smaller, and longer still for the columns of the table. */
int em_h5_level_of_reals(int deflate);

/* Makes a dataset: growing (rows of dims[1..], dims[0] = 0 at first) in chunks of `chunk` rows, or
 * fixed (chunk = 0). deflate: level, 0 none. unit may be NULL. */
bool em_h5_create(hid_t file, const char *path, hid_t type, struct em_h5_shape shape, hsize_t chunk,
                  int deflate, const char *unit);
/* Writes rows [first, first + count) of a growing dataset, which is set to that length. */
bool em_h5_write_rows(hid_t file, const char *path, hid_t memory_type, hsize_t first, hsize_t count,
                      const void *rows);
bool em_h5_set_rows(hid_t file, const char *path, hsize_t count);
bool em_h5_write(hid_t file, const char *path, hid_t memory_type, const void *data);

/* Shape of the dataset at path; false when there is none of at most EM_H5_RANK
 * dimensions, or when it claims to be larger than the file could hold. */
bool em_h5_shape(hid_t file, const char *path, struct em_h5_shape *shape);
bool em_h5_read_rows(hid_t file, const char *path, hid_t memory_type, hsize_t first, hsize_t count,
                     void *rows);
bool em_h5_read(hid_t file, const char *path, hid_t memory_type, void *data);

/* A text as a scalar dataset of fixed length; replaced when it exists. Read: freed by the caller;
 * NULL: none, or longer than `limit`. */
bool em_h5_put_document(hid_t file, const char *path, const char *text);
char *em_h5_get_document(hid_t file, const char *path, size_t limit);

/* Reads all that is in the file; false: something cannot be read, and its path is in `fault`. */
bool em_h5_is_whole(hid_t file, char *fault, size_t size);

#endif
