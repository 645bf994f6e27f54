/* A main() for fuzz targets that runs the files of a corpus once, so that `make check` holds what
 * fuzzing once found. Usage: fuzz_x_replay DIRECTORY|FILE ... */
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* 0: the target took the file, whatever it holds. */
static int run_file(const char *path) {
  FILE *file = fopen(path, "rb");
  if (!file) return 1;
  if (fseek(file, 0, SEEK_END) != 0) {
    fclose(file);
    return 1;
  }
  long size = ftell(file);
  rewind(file);
  /* Exactly as large as the input, so that a sanitizer sees reads beyond it. */
  uint8_t *data = size < 0 ? NULL : malloc(size > 0 ? (size_t)size : 1);
  int bad = !data || fread(data, 1, (size_t)size, file) != (size_t)size;
  fclose(file);
  if (!bad) LLVMFuzzerTestOneInput(data, (size_t)size);
  free(data);
  return bad;
}

static int is_directory(const char *path) {
  struct stat st;
  return stat(path, &st) == 0 && S_ISDIR(st.st_mode);
}

static int run_directory(const char *path, int *files) {
  DIR *dir = opendir(path);
  if (!dir) return 1;
  int bad = 0;
  for (struct dirent *entry; (entry = readdir(dir)) != NULL;) {
    if (entry->d_name[0] == '.') continue;
    char name[4096];
    snprintf(name, sizeof name, "%s/%s", path, entry->d_name);
    bad |= run_file(name);
    ++*files;
  }
  closedir(dir);
  return bad;
}

int main(int argc, char **argv) {
  int bad = 0, files = 0;
  for (int i = 1; i < argc; ++i) {
    if (is_directory(argv[i])) {
      bad |= run_directory(argv[i], &files);
    } else {
      bad |= run_file(argv[i]);
      ++files;
    }
  }
  /* Nothing read: the test would pass without having tested anything. */
  if (bad || files == 0) {
    fprintf(stderr, "%s: no corpus, or a file of it cannot be read\n", argv[0]);
    return 1;
  }
  printf("%d files\n", files);
  return 0;
}
