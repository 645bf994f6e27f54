/* Writes files under another name first, and pipes and devices directly. */
#include "record/output.h"

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static enum em_status cannot(const char *path, struct em_error *err) {
  return em_error_set(err, EM_FILE, path, 0, "cannot be written: %s", strerror(errno));
}

static void clear(struct em_output *output) {
  free(output->path);
  free(output->temporary);
  *output = (struct em_output){NULL, NULL, NULL};
}

/* A link stays; what it leads to is replaced. */
static char *behind_links(const char *path) {
  char *real = realpath(path, NULL);
  return real ? real : strdup(path);
}

enum em_status em_output_begin(struct em_output *output, const char *path, enum em_output_kind kind,
                               struct em_error *err) {
  struct stat there;
  const bool special = stat(path, &there) == 0 && !S_ISREG(there.st_mode);
  *output = (struct em_output){NULL, NULL, NULL};
  if (special && kind == EM_OUTPUT_FILE)
    return em_error_set(err, EM_INPUT, path, 0,
                        "is a pipe, a device or a folder, expected a regular file or a new one");
  output->path = special ? strdup(path) : behind_links(path);
  if (!output->path ||
      (!special && asprintf(&output->temporary, "%s.%d.part", output->path, (int)getpid()) < 0)) {
    output->temporary = NULL;
    clear(output);
    return em_error_set(err, EM_MEMORY, path, 0, "no memory for its name");
  }
  output->out = fopen(special ? output->path : output->temporary, "wbe");
  if (output->out) return EM_OK;
  cannot(path, err);
  clear(output);
  return EM_FILE;
}

/* What is on the disk survives a crash of the machine; what is only renamed may be empty after it.
 */
static bool is_on_disk(FILE *out) {
  return fflush(out) == 0 && fsync(fileno(out)) == 0;
}

enum em_status em_output_end(struct em_output *output, enum em_status status,
                             struct em_error *err) {
  const bool good = !ferror(output->out) && (!output->temporary || is_on_disk(output->out));
  if ((fclose(output->out) != 0 || !good) && status == EM_OK) status = cannot(output->path, err);
  if (output->temporary && status == EM_OK && rename(output->temporary, output->path) != 0)
    status = cannot(output->path, err);
  if (output->temporary && status != EM_OK) unlink(output->temporary);
  clear(output);
  return status;
}

const char *em_output_ending(const char *path) {
  const char *dot = strrchr(path, '.');
  return dot && !strchr(dot, '/') ? dot : path + strlen(path);
}

void em_output_name(char *text, size_t size, const char *path, const char *tag,
                    const char *ending) {
  const char *own = em_output_ending(path);
  snprintf(text, size, "%.*s-%s%s", (int)(own - path), path, tag, ending ? ending : own);
}

char *em_output_xml(const char *text) {
  char *result = malloc(6 * strlen(text) + 1), *to = result;
  for (; result && *text; text++) {
    const char *entity = *text == '&'   ? "&amp;"
                         : *text == '<' ? "&lt;"
                         : *text == '>' ? "&gt;"
                         : *text == '"' ? "&quot;"
                                        : NULL;
    if (entity)
      to = stpcpy(to, entity);
    else
      *to++ = *text;
  }
  if (result) *to = '\0';
  return result;
}
