/* Makes films: states come in order, pictures are drawn side by side, frames leave in order. */
#include "eventmill/film.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "draw/crew.h"
#include "draw/movie.h"

/* A film that is being made. */
struct making {
  const struct em_film_options *options;
  const struct em_scene *scene;
  em_film_source *source;
  void *source_self;
  em_film_progress *progress;
  void *progress_self;
  struct em_movie movie;
};

static enum em_status add(struct making *m, const uint8_t *rgba, size_t k, struct em_error *err) {
  const enum em_status status = em_movie_add(&m->movie, rgba, err);
  if (status != EM_OK || m->progress == NULL) return status;
  if (m->progress(m->progress_self, k + 1, m->options->frames)) return EM_OK;
  return em_error_set(err, EM_STOPPED, NULL, 0, "stopped after %zu of %zu frames", k + 1,
                      m->options->frames);
}

static enum em_status make_alone(struct making *m, struct em_error *err) {
  const struct em_film_options *o = m->options;
  struct em_picture *picture = NULL;
  uint8_t *rgba = malloc(4 * (size_t)o->picture.width * (size_t)o->picture.height);
  enum em_status status = rgba != NULL
                              ? em_picture_new(&picture, m->scene, &o->picture, err)
                              : em_error_set(err, EM_MEMORY, NULL, 0, "no memory for a film");
  for (size_t k = 0; k < o->frames && status == EM_OK; k++) {
    struct em_picture_state state;
    status = m->source(m->source_self, k, &state, err);
    if (o->orbit != 0.0) em_picture_turn(picture, o->picture.camera.azimuth + o->orbit * (double)k);
    if (status == EM_OK) status = em_picture_draw(picture, &state, rgba, err);
    if (status == EM_OK) status = add(m, rgba, k, err);
  }
  em_picture_free(picture);
  free(rgba);
  return status;
}

static enum em_status make_together(struct making *m, int workers, struct em_error *err) {
  const size_t frames = m->options->frames;
  struct em_picture_state state;
  struct em_crew *crew = NULL;
  enum em_status status = m->source(m->source_self, 0, &state, err);
  if (status == EM_OK) status = em_crew_start(&crew, workers, m->scene, m->options, &state, err);
  const size_t depth = status == EM_OK ? em_crew_depth(crew) : 0;
  for (size_t k = 0; k < frames + depth && status == EM_OK; k++) {
    const uint8_t *rgba;
    if (k >= depth) status = em_crew_take(crew, k - depth, &rgba, err);
    if (k >= depth && status == EM_OK) status = add(m, rgba, k - depth, err);
    if (k >= frames || status != EM_OK) continue;
    if (k > 0) status = m->source(m->source_self, k, &state, err);
    if (status == EM_OK) status = em_crew_give(crew, k, &state, err);
  }
  em_crew_end(crew);
  return status;
}

static enum em_status check(const struct em_film_options *o, const char *path,
                            struct em_error *err) {
  if (strcmp(em_output_ending(path), ".mp4") != 0)
    return em_error_set(err, EM_INPUT, path, 0, "the name of a film must end in .mp4");
  if (o->frames == 0) return em_error_set(err, EM_INPUT, path, 0, "a film without frames");
  if (!(o->fps >= 0.1 && o->fps <= 1000.0))
    return em_error_set(err, EM_INPUT, path, 0, "%g frames per second; 0.1 to 1000 are possible",
                        o->fps);
  if (o->picture.width < 2 || o->picture.height < 2)
    return em_error_set(err, EM_INPUT, path, 0, "a film of %d x %d pixels; it needs 2 x 2",
                        o->picture.width, o->picture.height);
  if (o->quality < 0 || o->quality > 51)
    return em_error_set(err, EM_INPUT, path, 0, "quality %d; 1 to 51 are possible", o->quality);
  return EM_OK;
}

enum em_status em_film_make(const char *path, const struct em_scene *scene,
                            const struct em_film_options *options, em_film_source *source,
                            void *source_self, em_film_progress *progress, void *progress_self,
                            struct em_error *err) {
  enum em_status status = check(options, path, err);
  if (status != EM_OK) return status;
  struct em_film_options even = *options;
  even.picture.width &= ~1;
  even.picture.height &= ~1;
  struct making m = {.options = &even,
                     .scene = scene,
                     .source = source,
                     .source_self = source_self,
                     .progress = progress,
                     .progress_self = progress_self};
  const long cores = sysconf(_SC_NPROCESSORS_ONLN);
  int workers = options->workers > 0 ? options->workers : cores > 0 ? (int)cores : 1;
  if ((size_t)workers > options->frames) workers = (int)options->frames;
  status = em_movie_begin(&m.movie, path, even.picture.width, even.picture.height, even.fps,
                          even.quality > 0 ? even.quality : 20, err);
  if (status != EM_OK) return status;
  status =
      workers == 1 && options->workers == 1 ? make_alone(&m, err) : make_together(&m, workers, err);
  struct em_error last = {0};
  const enum em_status ended = em_movie_end(&m.movie, status == EM_OK, &last);
  if (status == EM_OK && ended != EM_OK && err != NULL) *err = last;
  return status != EM_OK ? status : ended;
}
