/* millpost frame: a picture of a moment of a run. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "eventmill/picture.h"
#include "eventmill/run_file.h"
#include "eventmill/show.h"
#include "tool/millpost.h"
#include "tool/millpost_look.h"

/* A state of its own, that outlives the show's next one. */
struct moment {
  struct em_picture_state state;
  struct em_balls *balls;
  double *blade;
};

static bool copy_moment(struct moment *m, const struct em_picture_state *state, size_t blades) {
  const struct em_balls *from = state->balls;
  m->state = *state;
  m->balls = em_start_new(from->count);
  m->blade = calloc(blades + 1, sizeof *m->blade);
  if (m->balls == NULL || m->blade == NULL) return false;
  for (size_t k = 0; k < from->count; k++) {
    m->balls->position[k] = from->position[k];
    m->balls->velocity[k] = from->velocity[k];
    m->balls->spin[k] = from->spin[k];
    m->balls->radius[k] = from->radius[k];
    m->balls->species[k] = from->species[k];
  }
  for (size_t k = 0; k < blades; k++)
    m->blade[k] = state->blade_angle[k];
  m->state.balls = m->balls;
  m->state.blade_angle = m->blade;
  m->state.last = NULL;
  m->state.bead_count = 0;
  return true;
}

/* Three moments as the channels of one picture. */
static enum em_status draw_triple(struct em_picture *picture, struct em_show *show, double at,
                                  double step, size_t blades, uint8_t *rgba, struct em_error *err) {
  struct moment moment[3] = {0};
  struct em_picture_state three[3];
  enum em_status status = EM_OK;
  for (int k = 0; k < 3 && status == EM_OK; k++) {
    struct em_picture_state state;
    status = em_show_at(show, at + k * step, &state, err);
    if (status == EM_OK && !copy_moment(&moment[k], &state, blades))
      status = em_error_set(err, EM_MEMORY, NULL, 0, "no memory for three moments");
    three[k] = moment[k].state;
    three[k].time = moment[0].state.time;
  }
  if (status == EM_OK) status = em_picture_triple(picture, three, rgba, err);
  for (int k = 0; k < 3; k++) {
    em_start_free(moment[k].balls);
    free(moment[k].blade);
  }
  return status;
}

static enum em_status draw(const struct em_millpost_look *look, const struct em_run_file *run,
                           struct em_show *show, const char *out, struct em_error *err) {
  const struct em_scene *scene = em_run_file_scene(run);
  const bool triple = isfinite(look->triple);
  const double after = triple ? 2.0 * look->triple : 0.0; /* s, to the last of the moments */
  const double at = isfinite(look->at) ? look->at : em_show_last(show) - after;
  struct em_picture_state state;
  struct em_picture *picture = NULL;
  const double slack = 1e-9 * (1.0 + fabs(em_show_last(show)));
  if (at < em_show_first(show) - slack || at + after > em_show_last(show) + slack)
    return em_error_set(err, EM_INPUT, look->run, 0,
                        "a picture of %g to %g s: the run has frames from %g to %g s", at,
                        at + after, em_show_first(show), em_show_last(show));
  enum em_status status = em_show_at(show, at, &state, err);
  if (status != EM_OK) return status;
  struct em_picture_options options = em_millpost_look_picture(look, scene, state.balls);
  if (triple) {
    if (look->by < 0) options.by = EM_PICTURE_PLAIN;
    options.dark = true;
    snprintf(options.note, sizeof options.note, "red, green, blue: %g ms apart",
             1e3 * look->triple);
  }
  status = em_picture_new(&picture, scene, &options, err);
  uint8_t *rgba = malloc(4 * (size_t)options.width * (size_t)options.height);
  if (status == EM_OK && rgba == NULL)
    status = em_error_set(err, EM_MEMORY, NULL, 0, "no memory for the picture");
  if (status == EM_OK)
    status = triple ? draw_triple(picture, show, at, look->triple, em_scene_blade_count(scene),
                                  rgba, err)
                    : em_picture_draw(picture, &state, rgba, err);
  if (status == EM_OK) status = em_picture_save(out, rgba, options.width, options.height, err);
  if (status == EM_OK && !look->quiet)
    fprintf(stderr, "%s: %d x %d, t = %.6g s, drawn by %s\n", out, options.width, options.height,
            state.time, em_picture_renderer(picture));
  free(rgba);
  em_picture_free(picture);
  return status;
}

int em_millpost_frame(int argc, char **argv) {
  struct em_millpost_look look;
  struct em_error err = {.code = EM_OK};
  struct em_run_file *run = NULL;
  struct em_show *show = NULL;
  char name[256], out[272];
  const int code = em_millpost_look_read(&look, EM_LOOK_FRAME, argc, argv);
  if (code >= 0) return code;
  em_millpost_label(look.run, name, sizeof name);
  snprintf(out, sizeof out, "%s.png", name);
  enum em_status status = em_millpost_open(&run, look.run, &err);
  if (status == EM_OK) status = em_show_new(&show, run, &look.show, &err);
  if (status == EM_OK) status = draw(&look, run, show, look.out != NULL ? look.out : out, &err);
  em_show_free(show);
  if (run != NULL) em_run_file_close(run);
  return status == EM_OK ? EM_MILLPOST_DONE : em_millpost_fail(&err);
}
