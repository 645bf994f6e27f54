/* millpost film: a film of a run. */
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "eventmill/film.h"
#include "eventmill/run_file.h"
#include "eventmill/show.h"
#include "tool/millpost.h"
#include "tool/millpost_look.h"
#include "tool/progress.h"

static volatile sig_atomic_t stop;

static void on_signal(int number) {
  (void)number;
  stop = 1;
}

/* A film that is being made of a run. */
struct reel {
  struct em_show *show;
  double from, step; /* s, of the mill */
  struct em_progress *progress;
  struct timespec begin;
};

static double seconds_since(const struct timespec *begin) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)(now.tv_sec - begin->tv_sec) + 1e-9 * (double)(now.tv_nsec - begin->tv_nsec);
}

static enum em_status state_at(void *self, size_t k, struct em_picture_state *state,
                               struct em_error *err) {
  const struct reel *reel = self;
  return em_show_at(reel->show, reel->from + (double)k * reel->step, state, err);
}

static bool show_progress(void *self, size_t done, size_t frames) {
  const struct reel *reel = self;
  char text[96];
  const double share = (double)done / (double)frames, wall = seconds_since(&reel->begin);
  snprintf(text, sizeof text, "%zu of %zu frames, %.1f frames/s", done, frames,
           wall > 0.0 ? (double)done / wall : 0.0);
  em_progress_show(reel->progress, &(struct em_progress_state){share, share, wall}, text);
  return !stop;
}

static void write_note(char *note, size_t size, double slow) {
  if (slow > 1.02)
    snprintf(note, size, "%.3g times slower", slow);
  else if (slow < 0.98)
    snprintf(note, size, "%.3g times faster", 1.0 / slow);
}

/* The time of the mill from one frame of the film to the next. */
static double step_of(const struct em_millpost_look *look, const struct em_run_file *run,
                      const struct em_show *show) {
  const size_t frames = em_run_file_frame_count(run);
  if (isfinite(look->slow)) return 1.0 / (look->slow * look->fps);
  if (em_show_is_exact(show) || frames < 2) return 1e-3;
  return (em_show_last(show) - em_show_first(show)) / (double)(frames - 1);
}

static enum em_status set_up(struct em_film_options *options, struct reel *reel,
                             const struct em_millpost_look *look, const struct em_run_file *run,
                             struct em_error *err) {
  struct em_picture_state state;
  const double first = em_show_first(reel->show), last = em_show_last(reel->show);
  reel->from = isfinite(look->from) ? look->from : first;
  const double to = isfinite(look->to) ? look->to : last, slack = 1e-9 * (1.0 + fabs(last));
  if (!(reel->from >= first - slack && to <= last + slack && reel->from <= to))
    return em_error_set(err, EM_INPUT, look->run, 0,
                        "a film from %g to %g s: the run has frames from %g to %g s", reel->from,
                        to, first, last);
  reel->step = step_of(look, run, reel->show);
  const double frames = floor((to - reel->from) / reel->step + 1e-6) + 1.0;
  if (!(frames <= 1e7))
    return em_error_set(err, EM_INPUT, look->run, 0, "a film of %g frames is too long", frames);
  const enum em_status status = em_show_at(reel->show, 0.5 * (reel->from + to), &state, err);
  if (status != EM_OK) return status;
  options->picture = em_millpost_look_picture(look, em_run_file_scene(run), state.balls);
  if (look->smooth == 0) options->picture.smooth = 1;
  options->picture.camera.orbits = look->orbit != 0.0;
  write_note(options->picture.note, sizeof options->picture.note, 1.0 / (reel->step * look->fps));
  options->frames = (size_t)frames;
  options->fps = look->fps;
  options->orbit = look->orbit / look->fps * M_PI / 180.0;
  options->workers = (int)look->workers;
  options->quality = (int)look->quality;
  options->bead_room = em_show_bead_room(reel->show);
  return EM_OK;
}

static enum em_status make(const struct em_millpost_look *look, const struct em_run_file *run,
                           const char *out, struct reel *reel, struct em_error *err) {
  struct em_film_options options = {0};
  const enum em_status ready = set_up(&options, reel, look, run, err);
  if (ready != EM_OK) return ready;
  static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
  enum { SIGNALS = sizeof signals / sizeof *signals };
  struct sigaction old[SIGNALS], action = {.sa_handler = on_signal};
  for (int k = 0; k < SIGNALS; k++)
    sigaction(signals[k], &action, &old[k]);
  reel->progress = em_progress_new(look->quiet);
  clock_gettime(CLOCK_MONOTONIC, &reel->begin);
  const enum em_status status =
      em_film_make(out, em_run_file_scene(run), &options, state_at, reel, show_progress, reel, err);
  em_progress_end(reel->progress);
  for (int k = 0; k < SIGNALS; k++)
    sigaction(signals[k], &old[k], NULL);
  const double wall = seconds_since(&reel->begin);
  if (status == EM_OK && !look->quiet)
    fprintf(stderr, "%s: %zu frames of %d x %d in %.1f s, %.1f frames/s\n", out, options.frames,
            options.picture.width & ~1, options.picture.height & ~1, wall,
            (double)options.frames / wall);
  return status;
}

int em_millpost_film(int argc, char **argv) {
  struct em_millpost_look look;
  struct em_error err = {.code = EM_OK};
  struct em_run_file *run = NULL;
  struct reel reel = {0};
  char name[256], out[272];
  const int code = em_millpost_look_read(&look, EM_LOOK_FILM, argc, argv);
  if (code >= 0) return code;
  em_millpost_label(look.run, name, sizeof name);
  snprintf(out, sizeof out, "%s.mp4", name);
  enum em_status status = em_millpost_open(&run, look.run, &err);
  if (status == EM_OK) status = em_show_new(&reel.show, run, &look.show, &err);
  if (status == EM_OK) status = make(&look, run, look.out != NULL ? look.out : out, &reel, &err);
  em_show_free(reel.show);
  if (run != NULL) em_run_file_close(run);
  return status == EM_OK ? EM_MILLPOST_DONE : em_millpost_fail(&err);
}
