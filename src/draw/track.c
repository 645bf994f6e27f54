/* Goes through the frames of a film, finds the ball in each, and hands its way to the fit. */
#include "eventmill/track.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "draw/track_bounce.h"
#include "draw/track_disc.h"
#include "draw/track_image.h"

const char *em_track_plate_name(enum em_track_plate plate) {
#define NAME(code, text) text,
  static const char *const name[] = {EM_TRACK_PLATE_LIST(NAME)};
#undef NAME
  return (unsigned)plate < EM_TRACK_PLATES ? name[plate] : "?";
}

int em_track_plate_find(const char *name) {
  for (int k = 0; k < EM_TRACK_PLATES; k++)
    if (strcmp(name, em_track_plate_name((enum em_track_plate)k)) == 0) return k;
  return -1;
}

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static enum em_status median_radius(struct em_track *track, struct em_error *err) {
  double *radius = calloc(track->count + 1, sizeof *radius);
  if (radius == NULL) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for radii");
  for (size_t k = 0; k < track->count; k++)
    radius[k] = track->spot[k].radius;
  qsort(radius, track->count, sizeof *radius, ascending);
  track->radius = radius[track->count / 2];
  free(radius);
  return EM_OK;
}

/* Leaves out discs of another size: dirt, reflections, what enters the picture by half. */
static void keep_alike(struct em_track *track) {
  size_t kept = 0;
  for (size_t k = 0; k < track->count; k++)
    if (fabs(track->spot[k].radius / track->radius - 1.0) < 0.15)
      track->spot[kept++] = track->spot[k];
  track->count = kept;
}

static enum em_status find_all(struct em_track *track, const struct em_film_strip *strip,
                               const struct em_track_options *o, struct em_error *err) {
  const size_t pixels = track->width * track->height;
  const double tolerance = o->roundness > 0.0 ? o->roundness : 0.15;
  uint8_t *bytes = malloc(3 * pixels);
  float *field = malloc(2 * pixels * sizeof *field);
  enum em_status status = EM_OK;
  if (bytes == NULL || field == NULL)
    status = em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a frame");
  else
    status = em_track_image_ground(strip, bytes, err);
  for (size_t k = 0; k < strip->count && status == EM_OK; k++) {
    struct em_disc d = {0};
    status = em_track_image_read(strip, k, bytes + pixels, err);
    if (status != EM_OK) break;
    em_track_image_contrast(bytes + pixels, bytes, strip->width, strip->height,
                            o->smoothing > 0.0 ? o->smoothing : 1.0, field, field + pixels);
    if (em_track_disc_find(field, strip->width, strip->height, tolerance, bytes + 2 * pixels, &d))
      track->spot[track->count++] = (struct em_track_spot){
          k, d.x, d.y, d.radius, d.scatter, d.roundness,
      };
  }
  free(bytes);
  free(field);
  return status;
}

static enum em_status analyse(struct em_track *track, const struct em_film_strip *strip,
                              const char *film, const struct em_track_options *o,
                              struct em_error *err) {
  track->frames = strip->count;
  track->width = (size_t)strip->width;
  track->height = (size_t)strip->height;
  track->spot = calloc(strip->count, sizeof *track->spot);
  if (track->spot == NULL) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a track");
  enum em_status status = find_all(track, strip, o, err);
  if (status == EM_OK) status = median_radius(track, err);
  if (status != EM_OK) return status;
  keep_alike(track);
  track->scale = o->scale > 0.0 ? o->scale : 0.5 * o->diameter / fmax(track->radius, 1e-9);
  return em_track_bounce(track, o->fps, o->plate, film, err);
}

enum em_status em_track_folder(struct em_track **track, const char *folder,
                               const struct em_track_options *options, struct em_error *err) {
  struct em_film_strip strip;
  *track = NULL;
  if (!(options->fps > 0.0 && isfinite(options->fps)) ||
      !(options->scale > 0.0 || options->diameter > 0.0))
    return em_error_set(err, EM_INPUT, NULL, 0,
                        "frames per second and either metres per pixel or the ball's diameter have "
                        "to be given, above 0");
  struct em_track *made = calloc(1, sizeof *made);
  if (made == NULL) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a track");
  enum em_status status = em_track_image_list(&strip, folder, err);
  if (status == EM_OK) status = analyse(made, &strip, folder, options, err);
  em_track_image_clear(&strip);
  if (status != EM_OK) {
    em_track_free(made);
    return status;
  }
  *track = made;
  return EM_OK;
}

void em_track_free(struct em_track *track) {
  if (track == NULL) return;
  free(track->spot);
  free(track);
}
