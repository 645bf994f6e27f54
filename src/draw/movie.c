/* Sends raw frames to ffmpeg and puts the finished file in its place. */
#include "draw/movie.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Can the file be written? Better to know before the work than after. */
static enum em_status try_file(const char *temporary, const char *path, struct em_error *err) {
  const int fd = open(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) return em_error_set(err, EM_FILE, path, 0, "cannot be written: %s", strerror(errno));
  close(fd);
  return EM_OK;
}

enum em_status em_movie_begin(struct em_movie *movie, const char *path, int width, int height,
                              double fps, int quality, struct em_error *err) {
  char size[32], rate[32], crf[16];
  char *output = NULL;
  memset(movie, 0, sizeof *movie);
  movie->frame_size = 4 * (size_t)width * (size_t)height;
  movie->path = strdup(path);
  if (asprintf(&movie->temporary, "%s.part", path) < 0) movie->temporary = NULL;
  if (asprintf(&output, "file:%s.part", path) < 0) output = NULL;
  enum em_status status = EM_OK;
  if (movie->path == NULL || movie->temporary == NULL || output == NULL)
    status = em_error_set(err, EM_MEMORY, path, 0, "no memory for a film");
  if (status == EM_OK) status = try_file(movie->temporary, path, err);
  if (status == EM_OK) {
    snprintf(size, sizeof size, "%dx%d", width, height);
    snprintf(rate, sizeof rate, "%.6g", fps);
    snprintf(crf, sizeof crf, "%d", quality);
    const char *const command[] = {"ffmpeg",
                                   "-nostdin",
                                   "-loglevel",
                                   "error",
                                   "-y",
                                   "-f",
                                   "rawvideo",
                                   "-pix_fmt",
                                   "rgba",
                                   "-s",
                                   size,
                                   "-r",
                                   rate,
                                   "-i",
                                   "pipe:0",
                                   "-an",
                                   "-vf",
                                   "scale=out_color_matrix=bt709:out_range=tv",
                                   "-c:v",
                                   "libx264",
                                   "-preset",
                                   "veryfast",
                                   "-crf",
                                   crf,
                                   "-pix_fmt",
                                   "yuv420p",
                                   "-colorspace",
                                   "bt709",
                                   "-color_primaries",
                                   "bt709",
                                   "-color_trc",
                                   "bt709",
                                   "-color_range",
                                   "tv",
                                   "-movflags",
                                   "+faststart",
                                   "-f",
                                   "mp4",
                                   output,
                                   NULL};
    status = em_child_start(&movie->child, command, -1, err);
    if (status != EM_OK) unlink(movie->temporary);
  }
  free(output);
  if (status != EM_OK) {
    free(movie->path);
    free(movie->temporary);
    memset(movie, 0, sizeof *movie);
  }
  return status;
}

enum em_status em_movie_add(struct em_movie *movie, const uint8_t *rgba, struct em_error *err) {
  return em_child_send(&movie->child, rgba, movie->frame_size, err);
}

enum em_status em_movie_end(struct em_movie *movie, bool keep, struct em_error *err) {
  enum em_status status = EM_OK;
  if (keep) status = em_child_finish(&movie->child, err);
  if (!keep || status != EM_OK) em_child_abandon(&movie->child);
  if (keep && status == EM_OK && rename(movie->temporary, movie->path) != 0)
    status = em_error_set(err, EM_FILE, movie->path, 0, "cannot be written: %s", strerror(errno));
  if (!keep || status != EM_OK) unlink(movie->temporary);
  free(movie->path);
  free(movie->temporary);
  memset(movie, 0, sizeof *movie);
  return status;
}
