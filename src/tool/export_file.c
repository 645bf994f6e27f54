/* Files that appear complete or not at all. */
#include <endian.h>
#include <errno.h>
#include <stdint.h>
#include <string.h>
#include <unistd.h>

#include "tool/export.h"

enum em_status em_export_file_open(struct em_export_file *file, const char *path,
                                   struct em_error *err) {
  if (strlen(path) >= sizeof file->path)
    return em_error_set(err, EM_FILE, path, 0, "the path is too long");
  strcpy(file->path, path);
  snprintf(file->temporary, sizeof file->temporary, "%s.%ld", path, (long)getpid());
  file->out = fopen(file->temporary, "wb");
  if (file->out) return EM_OK;
  return em_error_set(err, EM_FILE, path, 0, "cannot be written: %s", strerror(errno));
}

enum em_status em_export_file_close(struct em_export_file *file, enum em_status status,
                                    struct em_error *err) {
  const int bad = ferror(file->out);
  if (fclose(file->out) != 0 || bad) {
    if (status == EM_OK)
      status = em_error_set(err, EM_FILE, file->path, 0, "cannot be written: %s", strerror(errno));
  }
  if (status == EM_OK && rename(file->temporary, file->path) != 0)
    status = em_error_set(err, EM_FILE, file->path, 0, "cannot be written: %s", strerror(errno));
  if (status != EM_OK) unlink(file->temporary);
  return status;
}

void em_export_file_number(char *text, size_t size, const char *path, size_t number,
                           const char *ending) {
  const char *dot = strrchr(path, '.'), *slash = strrchr(path, '/');
  if (!dot || (slash && dot < slash)) dot = path + strlen(path);
  snprintf(text, size, "%.*s-%04zu%s", (int)(dot - path), path, number, ending ? ending : dot);
}

void em_export_file_float(FILE *out, double x) {
  const float value = (float)x;
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  bits = htole32(bits);
  fwrite(&bits, sizeof bits, 1, out);
}
