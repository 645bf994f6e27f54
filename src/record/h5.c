/* Small things done with HDF5: attributes, growing and fixed datasets, documents. */
#include "record/h5.h"

#include <stdlib.h>
#include <string.h>

void em_h5_quiet(void) {
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
}

bool em_h5_group(hid_t file, const char *path) {
  const hid_t create = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(create, 1);
  const hid_t group = H5Gcreate2(file, path, create, H5P_DEFAULT, H5P_DEFAULT);
  H5Pclose(create);
  return group >= 0 && H5Gclose(group) >= 0;
}

/* Every link on the way must exist, or HDF5 calls it an error. */
bool em_h5_exists(hid_t file, const char *path) {
  char part[512];
  const size_t length = strlen(path);
  if (length >= sizeof part) return false;
  for (size_t i = 1; i <= length; i++) {
    if (path[i] != '/' && path[i] != '\0') continue;
    memcpy(part, path, i);
    part[i] = '\0';
    if (H5Lexists(file, part, H5P_DEFAULT) <= 0) return false;
  }
  return H5Oexists_by_name(file, path, H5P_DEFAULT) > 0;
}

bool em_h5_link(hid_t file, const char *from, const char *to) {
  return H5Lcreate_hard(file, from, file, to, H5P_DEFAULT, H5P_DEFAULT) >= 0;
}

/* ---------------------------------------------------------------- attributes */

static bool put(hid_t file, const char *path, const char *name, hid_t file_type, hid_t memory_type,
                hid_t space, const void *data) {
  const hid_t object = H5Oopen(file, path, H5P_DEFAULT);
  if (object < 0) return false;
  if (H5Aexists(object, name) > 0) H5Adelete(object, name);
  const hid_t attribute = H5Acreate2(object, name, file_type, space, H5P_DEFAULT, H5P_DEFAULT);
  bool good = attribute >= 0 && H5Awrite(attribute, memory_type, data) >= 0;
  if (attribute >= 0) good = H5Aclose(attribute) >= 0 && good;
  return H5Oclose(object) >= 0 && good;
}

static hid_t text_type(size_t size) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, size ? size : 1);
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  return type;
}

bool em_h5_put_text(hid_t file, const char *path, const char *name, const char *text) {
  const hid_t type = text_type(strlen(text)), space = H5Screate(H5S_SCALAR);
  const bool good = put(file, path, name, type, type, space, text);
  H5Sclose(space);
  H5Tclose(type);
  return good;
}

bool em_h5_put_texts(hid_t file, const char *path, const char *name, size_t count,
                     const char *const *texts) {
  size_t size = 1;
  for (size_t i = 0; i < count; i++)
    size = strlen(texts[i]) > size ? strlen(texts[i]) : size;
  char *room = calloc(count ? count : 1, size);
  if (!room) return false;
  for (size_t i = 0; i < count; i++)
    memcpy(room + i * size, texts[i], strlen(texts[i]));
  const hsize_t dims = count;
  const hid_t type = text_type(size), space = H5Screate_simple(1, &dims, NULL);
  const bool good = put(file, path, name, type, type, space, room);
  H5Sclose(space);
  H5Tclose(type);
  free(room);
  return good;
}

static hid_t open_attribute(hid_t file, const char *path, const char *name) {
  if (!em_h5_exists(file, path) || H5Aexists_by_name(file, path, name, H5P_DEFAULT) <= 0) return -1;
  return H5Aopen_by_name(file, path, name, H5P_DEFAULT, H5P_DEFAULT);
}

static bool is_size(hid_t attribute, hssize_t count) {
  const hid_t space = H5Aget_space(attribute);
  const bool same = space >= 0 && H5Sget_simple_extent_npoints(space) == count;
  if (space >= 0) H5Sclose(space);
  return same;
}

/* Numbers go to the place of the old ones: an attribute that is made anew would leave a hole. */
static bool rewrite(hid_t file, const char *path, const char *name, hid_t memory_type, size_t count,
                    const void *numbers) {
  const hid_t attribute = open_attribute(file, path, name);
  if (attribute < 0) return false;
  const bool good = is_size(attribute, (hssize_t)(count ? count : 1)) &&
                    H5Awrite(attribute, memory_type, numbers) >= 0;
  H5Aclose(attribute);
  return good;
}

bool em_h5_put_numbers(hid_t file, const char *path, const char *name, hid_t file_type,
                       hid_t memory_type, size_t count, const void *numbers) {
  const hsize_t dims = count;
  if (rewrite(file, path, name, memory_type, count, numbers)) return true;
  const hid_t space = count ? H5Screate_simple(1, &dims, NULL) : H5Screate(H5S_SCALAR);
  const bool good = put(file, path, name, file_type, memory_type, space, numbers);
  H5Sclose(space);
  return good;
}

bool em_h5_put_double(hid_t file, const char *path, const char *name, double number) {
  return em_h5_put_numbers(file, path, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 0, &number);
}

bool em_h5_put_count(hid_t file, const char *path, const char *name, uint64_t number) {
  return em_h5_put_numbers(file, path, name, H5T_STD_U64LE, H5T_NATIVE_UINT64, 0, &number);
}

bool em_h5_get_text(hid_t file, const char *path, const char *name, char *text, size_t size) {
  const hid_t attribute = open_attribute(file, path, name);
  if (attribute < 0) return false;
  const hid_t type = H5Aget_type(attribute);
  const bool fits = is_size(attribute, 1) && H5Tget_class(type) == H5T_STRING &&
                    H5Tis_variable_str(type) == 0 && H5Tget_size(type) < (1 << 16);
  const size_t length = fits ? H5Tget_size(type) : 0;
  char *room = fits ? calloc(length + 1, 1) : NULL;
  const bool good = room && H5Aread(attribute, type, room) >= 0;
  if (good) {
    const size_t used = strlen(room) < size - 1 ? strlen(room) : size - 1;
    memcpy(text, room, used);
    text[used] = '\0';
  }
  free(room);
  H5Tclose(type);
  H5Aclose(attribute);
  return good;
}

/* HDF5 converts between numbers, but not from texts. */
static bool is_number(hid_t type) {
  const H5T_class_t cls = H5Tget_class(type);
  return cls == H5T_INTEGER || cls == H5T_FLOAT;
}

bool em_h5_get_numbers(hid_t file, const char *path, const char *name, hid_t memory_type,
                       size_t count, void *numbers) {
  const hid_t attribute = open_attribute(file, path, name);
  if (attribute < 0) return false;
  const hid_t type = H5Aget_type(attribute);
  const bool good = is_size(attribute, (hssize_t)(count ? count : 1)) && is_number(type) &&
                    H5Aread(attribute, memory_type, numbers) >= 0;
  H5Tclose(type);
  H5Aclose(attribute);
  return good;
}

/* ---------------------------------------------------------------- datasets */

int em_h5_level_of_reals(int deflate) {
  return deflate < 4 ? 0 : deflate;
}

static hid_t layout(struct em_h5_shape shape, hsize_t chunk, int deflate) {
  hsize_t dims[EM_H5_RANK];
  for (int i = 0; i < shape.rank; i++)
    dims[i] = shape.dims[i] ? shape.dims[i] : 1;
  if (chunk) dims[0] = chunk;
  const hid_t create = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(create, shape.rank, dims);
  if (deflate > 0) {
    H5Pset_shuffle(create);
    H5Pset_deflate(create, (unsigned)deflate);
  }
  H5Pset_fletcher32(create);
  return create;
}

bool em_h5_create(hid_t file, const char *path, hid_t type, struct em_h5_shape shape, hsize_t chunk,
                  int deflate, const char *unit) {
  hsize_t most[EM_H5_RANK];
  memcpy(most, shape.dims, sizeof most);
  if (chunk) most[0] = H5S_UNLIMITED;
  const hid_t space = H5Screate_simple(shape.rank, shape.dims, most);
  const hid_t create = layout(shape, chunk, deflate);
  const hid_t set = H5Dcreate2(file, path, type, space, H5P_DEFAULT, create, H5P_DEFAULT);
  H5Pclose(create);
  H5Sclose(space);
  if (set < 0 || H5Dclose(set) < 0) return false;
  return !unit || em_h5_put_text(file, path, "unit", unit);
}

static bool shape_of(hid_t set, struct em_h5_shape *shape) {
  const hid_t space = H5Dget_space(set);
  const int rank = space < 0 ? -1 : H5Sget_simple_extent_ndims(space);
  const bool good = rank >= 0 && rank <= EM_H5_RANK;
  if (good) {
    shape->rank = rank;
    H5Sget_simple_extent_dims(space, shape->dims, NULL);
  }
  if (space >= 0) H5Sclose(space);
  return good;
}

/* Selects rows of a dataset; *memory gets a space of that size. */
static hid_t select_rows(hid_t set, hsize_t first, hsize_t count, hid_t *memory) {
  struct em_h5_shape shape;
  if (!shape_of(set, &shape) || shape.rank < 1 || first > shape.dims[0] ||
      count > shape.dims[0] - first)
    return -1;
  hsize_t start[EM_H5_RANK] = {first};
  shape.dims[0] = count;
  const hid_t space = H5Dget_space(set);
  if (count == 0)
    H5Sselect_none(space);
  else
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, shape.dims, NULL);
  *memory = H5Screate_simple(shape.rank, shape.dims, NULL);
  return space;
}

static bool set_rows(hid_t set, hsize_t count) {
  struct em_h5_shape shape;
  if (!shape_of(set, &shape) || shape.rank < 1) return false;
  if (shape.dims[0] == count) return true;
  shape.dims[0] = count;
  return H5Dset_extent(set, shape.dims) >= 0;
}

bool em_h5_set_rows(hid_t file, const char *path, hsize_t count) {
  const hid_t set = H5Dopen2(file, path, H5P_DEFAULT);
  if (set < 0) return false;
  const bool good = set_rows(set, count);
  return H5Dclose(set) >= 0 && good;
}

bool em_h5_write_rows(hid_t file, const char *path, hid_t memory_type, hsize_t first, hsize_t count,
                      const void *rows) {
  const hid_t set = H5Dopen2(file, path, H5P_DEFAULT);
  if (set < 0) return false;
  hid_t memory = -1, space = -1;
  bool good = set_rows(set, first + count);
  if (good) space = select_rows(set, first, count, &memory);
  good = space >= 0 && H5Dwrite(set, memory_type, memory, space, H5P_DEFAULT, rows) >= 0;
  if (space >= 0) {
    H5Sclose(space);
    H5Sclose(memory);
  }
  return H5Dclose(set) >= 0 && good;
}

bool em_h5_write(hid_t file, const char *path, hid_t memory_type, const void *data) {
  const hid_t set = H5Dopen2(file, path, H5P_DEFAULT);
  if (set < 0) return false;
  const bool good = H5Dwrite(set, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0;
  return H5Dclose(set) >= 0 && good;
}

static hid_t open_set(hid_t file, const char *path) {
  return em_h5_exists(file, path) ? H5Dopen2(file, path, H5P_DEFAULT) : -1;
}

static bool set_is_number(hid_t set) {
  const hid_t type = H5Dget_type(set);
  const bool good = is_number(type);
  H5Tclose(type);
  return good;
}

/* Deflate shrinks at most 1032-fold: a file cannot hold more than that, whatever its headers say.
 */
static bool can_hold(hid_t file, hid_t set, const struct em_h5_shape *shape) {
  const hid_t type = H5Dget_type(set);
  hsize_t size = 0, bytes = H5Tget_size(type);
  H5Tclose(type);
  if (H5Fget_filesize(file, &size) < 0 || size > UINT64_MAX / 1032) return false;
  for (int i = 0; i < shape->rank; i++)
    if (__builtin_mul_overflow(bytes, shape->dims[i], &bytes)) return false;
  return bytes <= 1032 * size;
}

bool em_h5_shape(hid_t file, const char *path, struct em_h5_shape *shape) {
  const hid_t set = open_set(file, path);
  if (set < 0) return false;
  const bool good = shape_of(set, shape) && can_hold(file, set, shape);
  H5Dclose(set);
  return good;
}

bool em_h5_read_rows(hid_t file, const char *path, hid_t memory_type, hsize_t first, hsize_t count,
                     void *rows) {
  const hid_t set = open_set(file, path);
  if (set < 0) return false;
  hid_t memory = -1;
  const hid_t space = set_is_number(set) ? select_rows(set, first, count, &memory) : -1;
  const bool good = space >= 0 && H5Dread(set, memory_type, memory, space, H5P_DEFAULT, rows) >= 0;
  if (space >= 0) {
    H5Sclose(space);
    H5Sclose(memory);
  }
  H5Dclose(set);
  return good;
}

bool em_h5_read(hid_t file, const char *path, hid_t memory_type, void *data) {
  const hid_t set = open_set(file, path);
  if (set < 0) return false;
  const bool good =
      set_is_number(set) && H5Dread(set, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0;
  H5Dclose(set);
  return good;
}

/* ---------------------------------------------------------------- documents */

/* A scalar of one long text, in a checksummed chunk: bytes [1] of that type. */
bool em_h5_put_document(hid_t file, const char *path, const char *text) {
  if (em_h5_exists(file, path) && H5Ldelete(file, path, H5P_DEFAULT) < 0) return false;
  const hid_t type = text_type(strlen(text));
  const struct em_h5_shape one = {1, {1}};
  const bool good =
      em_h5_create(file, path, type, one, 0, 0, NULL) && em_h5_write(file, path, type, text);
  H5Tclose(type);
  return good;
}

static char *read_document(hid_t set, size_t limit) {
  struct em_h5_shape shape;
  if (!shape_of(set, &shape) || shape.rank != 1 || shape.dims[0] != 1) return NULL;
  const hid_t type = H5Dget_type(set);
  char *text = NULL;
  if (H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0 &&
      H5Tget_size(type) <= limit)
    text = calloc(H5Tget_size(type) + 1, 1);
  if (text && H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text) < 0) {
    free(text);
    text = NULL;
  }
  H5Tclose(type);
  return text;
}

char *em_h5_get_document(hid_t file, const char *path, size_t limit) {
  const hid_t set = open_set(file, path);
  if (set < 0) return NULL;
  char *text = read_document(set, limit);
  H5Dclose(set);
  return text;
}
