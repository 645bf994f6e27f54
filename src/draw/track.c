/* Goes through the frames of a film, finds the ball in each, and hands its way to the fit. */
#include "eventmill/track.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "draw/track_bounce.h"
#include "draw/track_disc.h"
#include "draw/track_image.h"

/* Pixels: how well the edge of a ball is known that is lit from any side (tests/unit/test_track.c).
 */
static const double EDGE = 0.05;

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

/* The median, and its standard error: that of the scatter, √(π/2) times the mean's, and of EDGE. */
static enum em_status median_radius(struct em_track *track, struct em_error *err) {
  double *radius = calloc(track->count + 1, sizeof *radius), median, spread;
  if (radius == NULL) return em_error_set(err, EM_MEMORY, NULL, 0, "no memory for radii");
  for (size_t k = 0; k < track->count; k++)
    radius[k] = track->spot[k].radius;
  qsort(radius, track->count, sizeof *radius, ascending);
  median = radius[track->count / 2];
  for (size_t k = 0; k < track->count; k++)
    radius[k] = fabs(radius[k] - median);
  qsort(radius, track->count, sizeof *radius, ascending);
  spread = 1.4826 * radius[track->count / 2] * sqrt(M_PI_2 / fmax((double)track->count, 1.0));
  track->radius = (struct em_track_value){median, hypot(spread, EDGE)};
  free(radius);
  return EM_OK;
}

/* Leaves out discs of another size: dirt, reflections, what enters the picture by half. */
static void keep_alike(struct em_track *track) {
  size_t kept = 0;
  for (size_t k = 0; k < track->count; k++)
    if (fabs(track->spot[k].radius / track->radius.value - 1.0) < 0.15)
      track->spot[kept++] = track->spot[k];
  track->count = kept;
  track->lost =
      kept > 0 ? track->spot[kept - 1].frame - track->spot[0].frame + 1 - kept : track->frames;
}

/* What is needed for one frame at a time. */
struct desk {
  uint8_t *ground, *frame, *mark;
  float *difference, *contrast, *work;
};

static bool open_desk(struct desk *d, size_t pixels) {
  *d = (struct desk){malloc(3 * pixels),
                     malloc(3 * pixels),
                     malloc(pixels),
                     malloc(3 * pixels * sizeof(float)),
                     malloc(3 * pixels * sizeof(float)),
                     malloc(3 * pixels * sizeof(float))};
  return d->ground && d->frame && d->mark && d->difference && d->contrast && d->work;
}

static void close_desk(struct desk *d) {
  free(d->ground);
  free(d->frame);
  free(d->mark);
  free(d->difference);
  free(d->contrast);
  free(d->work);
}

static enum em_status find_all(struct em_track *track, const struct em_film_strip *strip,
                               const struct em_track_options *o, struct em_error *err) {
  const size_t pixels = track->width * track->height;
  const double tolerance = o->roundness > 0.0 ? o->roundness : 0.15;
  const double smoothing = o->smoothing > 0.0 ? o->smoothing : 1.0;
  struct desk desk;
  enum em_status status = open_desk(&desk, pixels)
                              ? em_track_image_ground(strip, desk.ground, err)
                              : em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a frame");
  const struct em_disc_field field = {strip->width,  strip->height, desk.difference,
                                      desk.contrast, smoothing,     desk.mark};
  for (size_t k = 0; k < strip->count && status == EM_OK; k++) {
    struct em_disc d = {0};
    status = em_track_image_read(strip, k, desk.frame, err);
    if (status != EM_OK) break;
    em_track_image_difference(desk.frame, desk.ground, pixels, desk.difference);
    em_track_image_contrast(desk.difference, strip->width, strip->height, smoothing, desk.contrast,
                            desk.work);
    if (em_track_disc_find(&field, tolerance, &d))
      track->spot[track->count++] = (struct em_track_spot){
          k, d.x, d.y, d.radius, d.scatter, d.roundness,
      };
  }
  close_desk(&desk);
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
  const double scale = 0.5 * o->diameter / fmax(track->radius.value, 1e-9);
  track->scale.value = o->scale > 0.0 ? o->scale : scale;
  track->scale.error = o->scale > 0.0 ? 0.0 : scale * track->radius.error / track->radius.value;
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
  if (options->smoothing != 0.0 &&
      !(options->smoothing >= EM_TRACK_SHARPEST && options->smoothing <= EM_TRACK_SMOOTHEST))
    return em_error_set(err, EM_INPUT, NULL, 0, "smoothing of %g pixels: %g to %g are possible",
                        options->smoothing, EM_TRACK_SHARPEST, EM_TRACK_SMOOTHEST);
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
