/* Frames as VTK PolyData: XML files with raw appended data, and a collection with their times. */
#include <endian.h>
#include <stdlib.h>
#include <string.h>

#include "record/output.h"
#include "tool/export.h"

/* The arrays of a file, in the order of the appended data. */
struct array {
  const char *name;
  int components;
};

static const struct array arrays[] = {{"position", 3}, {"velocity", 3}, {"speed", 1},   {"spin", 3},
                                      {"radius", 1},   {"mass", 1},     {"species", 1}, {"id", 1}};

enum { ARRAYS = sizeof arrays / sizeof *arrays };

static double value_of(const struct em_balls *b, int array, size_t i, int component) {
  const struct em_vec *vec = array == 0 ? b->position : array == 1 ? b->velocity : b->spin;
  switch (array) {
  case 2:
    return em_vec_norm(b->velocity[i]);
  case 4:
    return b->radius[i];
  case 5:
    return b->mass[i];
  case 6:
    return b->species[i];
  case 7:
    return (double)i;
  default:
    return em_vec_component(vec[i], component);
  }
}

static void declare(FILE *out, int array, size_t offset) {
  fprintf(out,
          "<DataArray type=\"Float32\" Name=\"%s\" NumberOfComponents=\"%d\" "
          "format=\"appended\" offset=\"%zu\"/>\n",
          arrays[array].name, arrays[array].components, offset);
}

static void header(FILE *out, size_t count, double time) {
  size_t offset = 0;
  fprintf(out,
          "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
          "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n"
          "<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
          "format=\"ascii\">%.17g</DataArray></FieldData>\n"
          "<Piece NumberOfPoints=\"%zu\" NumberOfVerts=\"%zu\" NumberOfLines=\"0\" "
          "NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n<Points>\n",
          time, count, count);
  for (int a = 0; a < ARRAYS; a++) {
    declare(out, a, offset);
    if (a == 0) fprintf(out, "</Points>\n<PointData Scalars=\"speed\" Vectors=\"velocity\">\n");
    offset += 8 + count * (size_t)arrays[a].components * 4;
  }
  fprintf(out,
          "</PointData>\n<Verts>\n<DataArray type=\"Int64\" Name=\"connectivity\" "
          "format=\"appended\" offset=\"%zu\"/>\n",
          offset);
  offset += 8 + count * 8;
  fprintf(out,
          "<DataArray type=\"Int64\" Name=\"offsets\" format=\"appended\" offset=\"%zu\"/>\n"
          "</Verts>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_",
          offset);
}

static void put64(FILE *out, uint64_t x) {
  const uint64_t little = htole64(x);
  fwrite(&little, sizeof little, 1, out);
}

static void write_piece(FILE *out, const struct em_balls *balls, double time) {
  const size_t n = balls->count;
  header(out, n, time);
  for (int a = 0; a < ARRAYS; a++) {
    put64(out, n * (size_t)arrays[a].components * 4);
    for (size_t i = 0; i < n; i++)
      for (int c = 0; c < arrays[a].components; c++)
        em_export_file_float(out, value_of(balls, a, i, c));
  }
  put64(out, n * 8);
  for (size_t i = 0; i < n; i++)
    put64(out, i);
  put64(out, n * 8);
  for (size_t i = 0; i < n; i++)
    put64(out, i + 1);
  fprintf(out, "\n</AppendedData>\n</VTKFile>\n");
}

/* Frame k's line of the collection, whose files lie beside it. */
static enum em_status put_member(FILE *out, const struct em_export *job, size_t k,
                                 struct em_error *err) {
  char path[EM_SCENE_PATH];
  em_export_file_name(path, sizeof path, job, k, ".vtp");
  const char *slash = strrchr(path, '/');
  char *name = em_output_xml(slash ? slash + 1 : path);
  if (!name) return em_error_set(err, EM_MEMORY, job->out, 0, "out of memory");
  fprintf(out, "<DataSet timestep=\"%.17g\" file=\"%s\"/>\n",
          em_run_file_frame_time(job->run, job->frame[k]), name);
  free(name);
  return EM_OK;
}

static enum em_status write_collection(const struct em_export *job, struct em_error *err) {
  struct em_output file;
  enum em_status status = em_output_begin(&file, job->out, EM_OUTPUT_STREAM, err);
  if (status != EM_OK) return status;
  fprintf(file.out, "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
                    "byte_order=\"LittleEndian\">\n<Collection>\n");
  for (size_t k = 0; k < job->frames && status == EM_OK; k++)
    status = put_member(file.out, job, k, err);
  fprintf(file.out, "</Collection>\n</VTKFile>\n");
  return em_output_end(&file, status, err);
}

enum em_status em_export_vtk_write(const struct em_export *job, struct em_error *err) {
  struct em_balls *balls = NULL;
  size_t written = 0;
  enum em_status status = em_run_file_balls(job->run, &balls, err);
  while (written < job->frames && status == EM_OK) {
    struct em_output file;
    char path[EM_SCENE_PATH];
    em_export_file_name(path, sizeof path, job, written, ".vtp");
    status = em_run_file_frame(job->run, job->frame[written], balls, err);
    if (status == EM_OK) status = em_output_begin(&file, path, EM_OUTPUT_STREAM, err);
    if (status != EM_OK) break;
    write_piece(file.out, balls, em_run_file_frame_time(job->run, job->frame[written]));
    status = em_output_end(&file, EM_OK, err);
    written += status == EM_OK;
  }
  em_start_free(balls);
  if (status == EM_OK) status = write_collection(job, err);
  if (status != EM_OK) em_export_file_remove(job, written, ".vtp");
  return status;
}
