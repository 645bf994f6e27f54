/* Writes PNG files. */
#include <png.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/picture.h"
#include "record/output.h"

static uint8_t *without_alpha(const uint8_t *rgba, size_t pixels) {
  uint8_t *rgb = malloc(3 * pixels);
  for (size_t k = 0; rgb != NULL && k < pixels; k++)
    memcpy(rgb + 3 * k, rgba + 4 * k, 3);
  return rgb;
}

enum em_status em_picture_save(const char *path, const uint8_t *rgba, int width, int height,
                               struct em_error *err) {
  if (strcmp(em_output_ending(path), ".png") != 0)
    return em_error_set(err, EM_INPUT, path, 0, "the name of a picture must end in .png");
  uint8_t *rgb = without_alpha(rgba, (size_t)width * (size_t)height);
  if (rgb == NULL) return em_error_set(err, EM_MEMORY, path, 0, "no memory to write the picture");
  struct em_output output;
  enum em_status status = em_output_begin(&output, path, EM_OUTPUT_STREAM, err);
  if (status == EM_OK) {
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (png_uint_32)width,
                       .height = (png_uint_32)height,
                       .format = PNG_FORMAT_RGB};
    if (!png_image_write_to_stdio(&image, output.out, 0, rgb, 0, NULL))
      status = em_error_set(err, EM_FILE, path, 0, "cannot be written: %s", image.message);
    status = em_output_end(&output, status, err);
  }
  free(rgb);
  return status;
}
