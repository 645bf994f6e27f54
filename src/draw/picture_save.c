/* Writes PNG files: to a temporary name first, so that a file is complete or not there. */
#include <errno.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "eventmill/picture.h"

static uint8_t *without_alpha(const uint8_t *rgba, size_t pixels) {
  uint8_t *rgb = malloc(3 * pixels);
  for (size_t k = 0; rgb != NULL && k < pixels; k++)
    memcpy(rgb + 3 * k, rgba + 4 * k, 3);
  return rgb;
}

static enum em_status write_to(FILE *file, const char *path, const uint8_t *rgb, int width,
                               int height, struct em_error *err) {
  png_image image = {.version = PNG_IMAGE_VERSION,
                     .width = (png_uint_32)width,
                     .height = (png_uint_32)height,
                     .format = PNG_FORMAT_RGB};
  const int done = png_image_write_to_stdio(&image, file, 0, rgb, 0, NULL);
  const int flushed = fflush(file) == 0 && fsync(fileno(file)) == 0;
  if (done && flushed) return EM_OK;
  return em_error_set(err, EM_FILE, path, 0, "the picture cannot be written: %s",
                      done ? strerror(errno) : image.message);
}

enum em_status em_picture_save(const char *path, const uint8_t *rgba, int width, int height,
                               struct em_error *err) {
  const size_t room = strlen(path) + 16;
  char *temporary = malloc(room);
  uint8_t *rgb = without_alpha(rgba, (size_t)width * (size_t)height);
  enum em_status status = EM_MEMORY;
  if (temporary == NULL || rgb == NULL) {
    em_error_set(err, EM_MEMORY, path, 0, "no memory to write the picture");
  } else {
    snprintf(temporary, room, "%s.part", path);
    FILE *file = fopen(temporary, "wb");
    if (file == NULL) {
      status = em_error_set(err, EM_FILE, path, 0, "cannot be written: %s", strerror(errno));
    } else {
      status = write_to(file, path, rgb, width, height, err);
      if (fclose(file) != 0 && status == EM_OK)
        status = em_error_set(err, EM_FILE, path, 0, "cannot be written: %s", strerror(errno));
      if (status == EM_OK && rename(temporary, path) != 0)
        status = em_error_set(err, EM_FILE, path, 0, "cannot be written: %s", strerror(errno));
      if (status != EM_OK) unlink(temporary);
    }
  }
  free(rgb);
  free(temporary);
  return status;
}
