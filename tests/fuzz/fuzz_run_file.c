/* Fuzz target: the run-file reader. An input that begins as HDF5 does is taken as a file; any other
 * one as changes to a good file: groups of four bytes, three for the place and one for the value.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "../unit/run_digest.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static uint8_t *good;
static size_t good_size;
static uint64_t good_digest;

/* Records a small run, keeps its bytes. */
static void make_good(void) {
  static const char *const overrides[] = {"duration=0.004", "balls.count=8"};
  char path[300];
  struct em_error err = {0};
  snprintf(path, sizeof path, "%s/good.h5", digest_folder());
  struct em_scene *scene = digest_scene(SMALL_MILL, 2, overrides);
  const struct em_recorder_options options = {.path = path};
  if (em_recorder_run(scene, &options, NULL, NULL, &err)) abort();
  em_scene_free(scene);
  if (digest_run(path, &good_digest, &err)) abort();
  FILE *in = fopen(path, "rb");
  fseek(in, 0, SEEK_END);
  good_size = (size_t)ftell(in);
  rewind(in);
  good = malloc(good_size);
  if (!good || fread(good, 1, good_size, in) != good_size) abort();
  fclose(in);
  digest_folder_remove();
}

/* Reads a file of these bytes to its end; 0 when it is refused. */
static uint64_t read_bytes(const uint8_t *data, size_t size) {
  char path[64];
  uint64_t digest = 0;
  struct em_error err = {0};
  const int fd = memfd_create("run", 0);
  if (fd < 0 || write(fd, data, size) != (ssize_t)size) abort();
  snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
  const enum em_status status = digest_run(path, &digest, &err);
  if (status && !strstr(err.text, "error: ")) abort();
  close(fd);
  return status ? 0 : digest;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (!good) make_good();
  if (size >= 4 && memcmp(data, good, 4) == 0) {
    read_bytes(data, size);
    return 0;
  }
  uint8_t *changed = malloc(good_size);
  if (!changed) abort();
  memcpy(changed, good, good_size);
  for (size_t i = 0; i + 4 <= size; i += 4) {
    const size_t at = (size_t)data[i] << 16 | (size_t)data[i + 1] << 8 | data[i + 2];
    changed[at % good_size] = data[i + 3];
  }
  const uint64_t digest = read_bytes(changed, good_size);
  if (digest && digest != good_digest) abort(); /* wrong numbers without a word */
  free(changed);
  return 0;
}
