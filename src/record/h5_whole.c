/* Is a file whole? Everything in it has a checksum, which HDF5 tests when it reads. */
#include <stdio.h>
#include <stdlib.h>

#include "record/h5.h"

/* Groups in groups; ours have fewer. */
enum { DEEPEST = 16 };

/* Rows that one read takes: those of a chunk. */
static hsize_t rows_at_once(hid_t set, hsize_t rows) {
  hsize_t chunk[EM_H5_RANK] = {rows};
  const hid_t create = H5Dget_create_plist(set);
  if (H5Pget_layout(create) == H5D_CHUNKED) H5Pget_chunk(create, EM_H5_RANK, chunk);
  H5Pclose(create);
  return chunk[0] < rows ? chunk[0] : rows;
}

/* Reads rows [first, first + count) as they are stored. */
static bool read_rows(hid_t set, hid_t type, struct em_h5_shape shape, hsize_t first, hsize_t count,
                      void *rows) {
  const hsize_t start[EM_H5_RANK] = {first};
  const hid_t space = H5Dget_space(set);
  shape.dims[0] = count;
  const hid_t memory = H5Screate_simple(shape.rank, shape.dims, NULL);
  const bool good =
      H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, shape.dims, NULL) >= 0 &&
      H5Dread(set, type, memory, space, H5P_DEFAULT, rows) >= 0;
  H5Sclose(memory);
  H5Sclose(space);
  return good;
}

static bool read_set(hid_t file, const char *path, hid_t set) {
  struct em_h5_shape shape;
  if (!em_h5_shape(file, path, &shape)) return false;
  const hid_t type = H5Dget_type(set);
  const bool single = shape.rank == 0;
  const hsize_t rows = single ? 1 : shape.dims[0], step = single ? 1 : rows_at_once(set, rows);
  size_t size = H5Tget_size(type) * step;
  for (int k = 1; k < shape.rank; k++)
    size *= shape.dims[k];
  void *room = malloc(size ? size : 1);
  bool good = room;
  if (single) good = good && H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, room) >= 0;
  for (hsize_t at = 0; !single && at < rows && good; at += step)
    good = read_rows(set, type, shape, at, at + step < rows ? step : rows - at, room);
  free(room);
  H5Tclose(type);
  return good;
}

/* `path`: of the group; in the end of what is damaged. */
static bool is_whole(hid_t file, hid_t group, int depth, char *path, size_t size) {
  H5G_info_t info;
  if (depth == DEEPEST || H5Gget_info(group, &info) < 0) return false;
  for (hsize_t k = 0; k < info.nlinks; k++) {
    const hid_t one = H5Oopen_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, k, H5P_DEFAULT);
    if (one < 0) return false;
    const H5I_type_t type = H5Iget_type(one);
    bool good = H5Iget_name(one, path, size) > 0;
    if (type == H5I_GROUP) good = good && is_whole(file, one, depth + 1, path, size);
    if (type == H5I_DATASET) good = good && read_set(file, path, one);
    H5Oclose(one);
    if (!good) return false;
  }
  return H5Iget_name(group, path, size) > 0;
}

bool em_h5_is_whole(hid_t file, char *fault, size_t size) {
  snprintf(fault, size, "/");
  const hid_t root = H5Gopen2(file, "/", H5P_DEFAULT);
  const bool good = root >= 0 && is_whole(file, root, 0, fault, size);
  if (root >= 0) H5Gclose(root);
  return good;
}
