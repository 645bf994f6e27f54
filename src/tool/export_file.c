/* What files of several formats are made of. */
#include <endian.h>
#include <stdint.h>
#include <string.h>
#include <unistd.h>

#include "record/output.h"
#include "tool/export.h"

void em_export_file_name(char *text, size_t size, const struct em_export *job, size_t k,
                         const char *ending) {
  char tag[32];
  snprintf(tag, sizeof tag, "%04zu", k);
  em_output_name(text, size, job->out, tag, ending);
}

void em_export_file_remove(const struct em_export *job, size_t count, const char *ending) {
  char path[EM_SCENE_PATH];
  for (size_t k = 0; k < count; k++) {
    em_export_file_name(path, sizeof path, job, k, ending);
    (void)unlink(path);
  }
}

void em_export_file_float(FILE *out, double x) {
  const float value = (float)x;
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  bits = htole32(bits);
  fwrite(&bits, sizeof bits, 1, out);
}
