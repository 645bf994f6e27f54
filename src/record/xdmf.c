/* Writes the XDMF sidecar of a run file. */
#include "eventmill/xdmf.h"

#include <stdlib.h>
#include <string.h>

#include "num/locale.h"
#include "record/layout.h"
#include "record/output.h"
#include "record/run_file_inside.h"

struct sidecar {
  const struct em_run_file *file;
  FILE *out;
  enum em_xdmf_form form;
  char *data; /* the run file's name as the sidecar calls it, escaped */
};

static size_t folder_length(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash ? (size_t)(slash - path) + 1 : 0;
}

static char *data_name(const char *run, const char *sidecar, enum em_xdmf_form form) {
  const size_t length = folder_length(run);
  const bool beside = length == folder_length(sidecar) && strncmp(run, sidecar, length) == 0;
  if (form == EM_XDMF_HYPERSLAB && beside) return em_output_xml(run + length);
  char *whole = realpath(run, NULL);
  char *name = whole ? em_output_xml(whole) : NULL;
  free(whole);
  return name;
}

/* A fixed dataset of one number per ball. */
static void put_fixed(const struct sidecar *s, const char *name, const char *type, int bytes) {
  fprintf(s->out,
          "    <Attribute Name=\"%s\" AttributeType=\"Scalar\" Center=\"Node\">\n"
          "     <DataItem Dimensions=\"%zu\" NumberType=\"%s\" Precision=\"%d\" Format=\"HDF\">"
          "%s:" EM_LAYOUT_BALLS "/%s</DataItem>\n    </Attribute>\n",
          name, s->file->balls, type, bytes, s->data, name);
}

/* Frame k of an element of vectors. */
static void put_frame(const struct sidecar *s, const char *element, size_t k) {
  const size_t n = s->file->balls, frames = s->file->frames;
  const char *number = "NumberType=\"Float\" Precision=\"8\" Format=\"HDF\"";
  if (s->form == EM_XDMF_SELECTION)
    fprintf(s->out,
            "     <DataItem Dimensions=\"%zu 3\" %s>%s:" EM_LAYOUT_BALLS
            "/%s/value|%zu 0 0:1 1 1:1 %zu 3:%zu %zu 3</DataItem>\n",
            n, number, s->data, element, k, n, frames, n);
  else
    fprintf(s->out,
            "     <DataItem ItemType=\"HyperSlab\" Type=\"HyperSlab\" Dimensions=\"%zu 3\">\n"
            "      <DataItem Dimensions=\"3 3\" NumberType=\"Int\" Format=\"XML\">"
            "%zu 0 0 1 1 1 1 %zu 3</DataItem>\n"
            "      <DataItem Dimensions=\"%zu %zu 3\" %s>%s:" EM_LAYOUT_BALLS
            "/%s/value</DataItem>\n     </DataItem>\n",
            n, k, n, frames, n, number, s->data, element);
}

static void put_vectors(const struct sidecar *s, const char *element, size_t k) {
  fprintf(s->out, "    <Attribute Name=\"%s\" AttributeType=\"Vector\" Center=\"Node\">\n",
          element);
  put_frame(s, element, k);
  fprintf(s->out, "    </Attribute>\n");
}

static void put_grid(const struct sidecar *s, size_t k) {
  fprintf(s->out,
          "   <Grid Name=\"frame %zu\" GridType=\"Uniform\">\n    <Time Value=\"%.17g\"/>\n"
          "    <Topology TopologyType=\"Polyvertex\" NumberOfElements=\"%zu\" "
          "NodesPerElement=\"1\"/>\n    <Geometry GeometryType=\"XYZ\">\n",
          k, s->file->frame_time[k], s->file->balls);
  put_frame(s, "position", k);
  fprintf(s->out, "    </Geometry>\n");
  put_vectors(s, "velocity", k);
  if (s->file->has_spin) put_vectors(s, "angular_velocity", k);
  put_fixed(s, "radius", "Float", 8);
  put_fixed(s, "mass", "Float", 8);
  put_fixed(s, "species", "Int", 4);
  fprintf(s->out, "   </Grid>\n");
}

static void put_all(const struct sidecar *s) {
  fprintf(s->out,
          "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<Xdmf Version=\"%s\">\n <Domain>\n"
          "  <Grid Name=\"balls\" GridType=\"Collection\" CollectionType=\"Temporal\">\n",
          s->form == EM_XDMF_SELECTION ? "3.0" : "2.0");
  for (size_t k = 0; k < s->file->frames; k++)
    put_grid(s, k);
  fprintf(s->out, "  </Grid>\n </Domain>\n</Xdmf>\n");
}

enum em_status em_xdmf_write(const struct em_run_file *file, const char *path,
                             enum em_xdmf_form form, struct em_error *err) {
  EM_LOCALE_PLAIN;
  if (file->frames == 0 || file->balls == 0)
    return em_error_set(err, EM_INPUT, file->path, 0, "has no frames to show");
  struct sidecar s = {.file = file, .form = form, .data = data_name(file->path, path, form)};
  if (!s.data) return em_error_set(err, EM_MEMORY, path, 0, "out of memory");
  struct em_output output;
  enum em_status status = em_output_begin(&output, path, EM_OUTPUT_STREAM, err);
  if (status == EM_OK) {
    s.out = output.out;
    put_all(&s);
    status = em_output_end(&output, EM_OK, err);
  }
  free(s.data);
  return status;
}
