/* Films: pictures drawn by several processes at once, sent in order to ffmpeg. */
#ifndef EVENTMILL_FILM_H
#define EVENTMILL_FILM_H

#include <stdbool.h>
#include <stddef.h>

#include "eventmill/error.h"
#include "eventmill/picture.h"

#ifdef __cplusplus
extern "C" {
#endif

struct em_film_options {
  struct em_picture_options picture; /* width and height are rounded down to even numbers */
  size_t frames;
  double fps;       /* frames per second of film */
  double orbit;     /* rad per frame, by which the camera goes round */
  int workers;      /* processes that draw, no more than frames; 0: one per core; 1: this process
                       alone */
  int quality;      /* x264's constant rate factor, 1 (best) … 51; 0 stands for 20 */
  size_t bead_room; /* the largest number of beads in a state */
};

/* Fills the state of frame k (from 0, rising); it need hold only until the next call. */
typedef enum em_status em_film_source(void *self, size_t k, struct em_picture_state *state,
                                      struct em_error *err);

/* Is told how many frames are done; false ends the work (EM_STOPPED). */
typedef bool em_film_progress(void *self, size_t done, size_t frames);

/* Draws a film of a scene and writes an MP4 file (H.264, yuv420p, ready for streaming), complete or
 * not at all. Unless workers is 1, processes are forked, which OpenGL survives only if this process
 * has made no canvas before. Errors: EM_INPUT (another ending than .mp4, options), EM_MEMORY,
 * EM_FILE, EM_PICTURE (ffmpeg or a worker failed; what it said is in err), EM_STOPPED, those of the
 * source. */
enum em_status em_film_make(const char *path, const struct em_scene *scene,
                            const struct em_film_options *options, em_film_source *source,
                            void *source_self, em_film_progress *progress, void *progress_self,
                            struct em_error *err);

#ifdef __cplusplus
}
#endif

#endif
