/* Reads frames, finds the picture without the ball, and what differs from it. */
#include "draw/track_image.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <png.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { MEDIAN_OF = 41, LARGEST_SIDE = 16384 };

/* ---------------------------------------------------------------- files */

static int is_picture(const struct dirent *entry) {
  const size_t length = strlen(entry->d_name);
  return length > 4 && strcasecmp(entry->d_name + length - 4, ".png") == 0;
}

static enum em_status open_png(png_image *image, const char *path, struct em_error *err) {
  memset(image, 0, sizeof *image);
  image->version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_file(image, path))
    return em_error_set(err, EM_FILE, path, 0, "cannot be read: %s", image->message);
  image->format = PNG_FORMAT_RGB;
  return EM_OK;
}

/* frame-2 comes before frame-10. */
static enum em_status list_names(struct em_film_strip *strip, const char *folder,
                                 struct em_error *err) {
  struct dirent **entry;
  const int count = scandir(folder, &entry, is_picture, versionsort);
  if (count < 0)
    return em_error_set(err, EM_FILE, folder, 0, "cannot be read: %s", strerror(errno));
  bool good = (strip->path = calloc((size_t)count + 1, sizeof *strip->path)) != NULL;
  for (int k = 0; k < count; k++) {
    const size_t size = strlen(folder) + strlen(entry[k]->d_name) + 2;
    char *path = good ? malloc(size) : NULL;
    good = path != NULL;
    if (good) {
      snprintf(path, size, "%s/%s", folder, entry[k]->d_name);
      strip->path[strip->count++] = path;
    }
    free(entry[k]);
  }
  free(entry);
  return good ? EM_OK : em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a list of frames");
}

enum em_status em_track_image_list(struct em_film_strip *strip, const char *folder,
                                   struct em_error *err) {
  memset(strip, 0, sizeof *strip);
  enum em_status status = list_names(strip, folder, err);
  if (status == EM_OK && strip->count < 7)
    status = em_error_set(
        err, EM_INPUT, folder, 0,
        "%zu PNG frames: at least 7 are needed, three before and after the impact", strip->count);
  if (status != EM_OK) return status;
  png_image image;
  status = open_png(&image, strip->path[0], err);
  if (status != EM_OK) return status;
  strip->width = (int)image.width;
  strip->height = (int)image.height;
  png_image_free(&image);
  if (strip->width >= 8 && strip->height >= 8 && strip->width <= LARGEST_SIDE &&
      strip->height <= LARGEST_SIDE)
    return EM_OK;
  return em_error_set(err, EM_INPUT, strip->path[0], 0, "%d x %d pixels: 8 to %d are possible",
                      strip->width, strip->height, LARGEST_SIDE);
}

void em_track_image_clear(struct em_film_strip *strip) {
  for (size_t k = 0; k < strip->count; k++)
    free(strip->path[k]);
  free(strip->path);
  memset(strip, 0, sizeof *strip);
}

enum em_status em_track_image_read(const struct em_film_strip *strip, size_t k, uint8_t *rgb,
                                   struct em_error *err) {
  const png_color black = {0, 0, 0};
  png_image image;
  const enum em_status status = open_png(&image, strip->path[k], err);
  if (status != EM_OK) return status;
  if ((int)image.width != strip->width || (int)image.height != strip->height) {
    const int w = (int)image.width, h = (int)image.height;
    png_image_free(&image);
    return em_error_set(err, EM_INPUT, strip->path[k], 0,
                        "%d x %d pixels, the first frame has %d x %d", w, h, strip->width,
                        strip->height);
  }
  if (png_image_finish_read(&image, &black, rgb, 3 * strip->width, NULL)) return EM_OK;
  const enum em_status failed =
      em_error_set(err, EM_FILE, strip->path[k], 0, "cannot be read: %s", image.message);
  png_image_free(&image);
  return failed;
}

/* ---------------------------------------------------------------- ground */

static uint8_t median_of(const uint8_t *stack, size_t bytes, size_t at, size_t count) {
  unsigned histogram[256] = {0};
  for (size_t k = 0; k < count; k++)
    histogram[stack[k * bytes + at]]++;
  unsigned level = 0;
  for (size_t sum = histogram[0]; 2 * sum < count; sum += histogram[level])
    level++;
  return (uint8_t)level;
}

enum em_status em_track_image_ground(const struct em_film_strip *strip, uint8_t *ground,
                                     struct em_error *err) {
  const size_t bytes = 3 * (size_t)strip->width * (size_t)strip->height;
  const size_t count = strip->count < MEDIAN_OF ? strip->count : MEDIAN_OF;
  uint8_t *stack = malloc(count * bytes);
  if (stack == NULL)
    return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for %zu frames", count);
  enum em_status status = EM_OK;
  for (size_t k = 0; k < count && status == EM_OK; k++)
    status = em_track_image_read(strip, k * strip->count / count, stack + k * bytes, err);
  for (size_t p = 0; p < bytes && status == EM_OK; p++)
    ground[p] = median_of(stack, bytes, p, count);
  free(stack);
  return status;
}

/* ---------------------------------------------------------------- difference */

/* The median of frame/ground, each value weighted by its light; by a histogram of 0 to 4. */
static double gain_of(const uint8_t *rgb, const uint8_t *ground, size_t bytes) {
  enum { BINS = 4000 };
  size_t weight[BINS + 1] = {0}, all = 0;
  for (size_t p = 0; p < bytes; p++) {
    const double ratio = ground[p] > 0 ? (double)rgb[p] / ground[p] : 1.0;
    weight[ratio < 4.0 ? lround(ratio * (BINS / 4.0)) : BINS] += ground[p];
    all += ground[p];
  }
  size_t sum = weight[0];
  int bin = 0;
  while (2 * sum < all)
    sum += weight[++bin];
  return bin * (4.0 / BINS);
}

void em_track_image_difference(const uint8_t *rgb, const uint8_t *ground, size_t pixels,
                               float *difference) {
  const double gain = gain_of(rgb, ground, 3 * pixels);
  for (size_t p = 0; p < 3 * pixels; p++)
    difference[p] = (float)(rgb[p] - gain * ground[p]);
}

static int clamped(int k, int size) {
  return k < 0 ? 0 : k >= size ? size - 1 : k;
}

/* Of three channels, along rows or columns. */
static void blur(const float *in, float *out, int width, int height, double sigma, bool down) {
  enum { MOST = 32 };
  float weight[MOST + 1] = {0.0F}, sum = 0.0F;
  const int reach = (int)fmin(ceil(3.0 * sigma), MOST);
  for (int k = 0; k <= reach; k++) {
    weight[k] = (float)exp(-0.5 * k * k / (sigma * sigma));
    sum += k ? 2.0F * weight[k] : weight[k];
  }
  for (int y = 0; y < height; y++)
    for (int x = 0; x < width; x++) {
      float value[3] = {0.0F, 0.0F, 0.0F};
      for (int k = -reach; k <= reach; k++) {
        const int u = down ? x : clamped(x + k, width), v = down ? clamped(y + k, height) : y;
        const float *p = in + 3 * ((size_t)v * (size_t)width + (size_t)u);
        for (int c = 0; c < 3; c++)
          value[c] += weight[abs(k)] * p[c];
      }
      for (int c = 0; c < 3; c++)
        out[3 * ((size_t)y * (size_t)width + (size_t)x) + (size_t)c] = value[c] / sum;
    }
}

void em_track_image_contrast(const float *difference, int width, int height, double smoothing,
                             float *contrast, float *work) {
  const size_t pixels = (size_t)width * (size_t)height;
  blur(difference, work, width, height, smoothing, false);
  blur(work, contrast, width, height, smoothing, true);
  for (size_t p = 0; p < pixels; p++) {
    const float *v = contrast + 3 * p;
    contrast[p] = sqrtf((v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) / 3.0F);
  }
}
