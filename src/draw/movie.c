/* Sends raw frames to ffmpeg and puts the finished file in its place. */
#include "draw/movie.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "num/locale.h"

/* Starts ffmpeg: raw frames come from its standard input, the film goes to `output`. */
static enum em_status start(struct em_child *child, const char *output, int width, int height,
                            double fps, int quality, struct em_error *err) {
  EM_LOCALE_PLAIN;
  char size[32], rate[32], crf[16];
  snprintf(size, sizeof size, "%dx%d", width, height);
  snprintf(rate, sizeof rate, "%.6g", fps);
  snprintf(crf, sizeof crf, "%d", quality);
  const char *const command[] = {
      "ffmpeg", "-nostdin", "-loglevel", "error", "-y",
      /* from raw frames */
      "-f", "rawvideo", "-pix_fmt", "rgba", "-s", size, "-r", rate, "-i", "pipe:0", "-an",
      /* by H.264 */
      "-c:v", "libx264", "-preset", "veryfast", "-crf", crf, "-pix_fmt", "yuv420p",
      /* with the colours of HD video */
      "-vf", "scale=out_color_matrix=bt709:out_range=tv", "-colorspace", "bt709",
      "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv",
      /* to an MP4 file that plays while it loads */
      "-movflags", "+faststart", "-f", "mp4", output, NULL};
  return em_child_start(child, command, -1, err);
}

enum em_status em_movie_begin(struct em_movie *movie, const char *path, int width, int height,
                              double fps, int quality, struct em_error *err) {
  memset(movie, 0, sizeof *movie);
  movie->frame_size = 4 * (size_t)width * (size_t)height;
  enum em_status status = em_output_begin(&movie->output, path, EM_OUTPUT_FILE, err);
  if (status != EM_OK) return status;
  char *output = NULL;
  if (asprintf(&output, "file:%s", movie->output.temporary) < 0)
    return em_output_end(&movie->output,
                         em_error_set(err, EM_MEMORY, path, 0, "no memory for a film"), err);
  status = start(&movie->child, output, width, height, fps, quality, err);
  free(output);
  return status == EM_OK ? EM_OK : em_output_end(&movie->output, status, err);
}

enum em_status em_movie_add(struct em_movie *movie, const uint8_t *rgba, struct em_error *err) {
  return em_child_send(&movie->child, rgba, movie->frame_size, err);
}

enum em_status em_movie_end(struct em_movie *movie, bool keep, struct em_error *err) {
  enum em_status status = keep ? em_child_finish(&movie->child, err) : EM_STOPPED;
  if (status != EM_OK) em_child_abandon(&movie->child);
  status = em_output_end(&movie->output, status, err);
  return keep ? status : EM_OK;
}
