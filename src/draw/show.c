/* Gathers what a picture of a run needs, and follows the trails of chosen balls. */
#include "eventmill/show.h"

#include <stdlib.h>
#include <string.h>

/* A trail is a row of beads, so close that they touch: where the ball went a fifth of its radius,
 * but no more than TRAIL_POINTS of them. */
enum { TRAIL_POINTS = 16384, LEAST_POINTS = 100 };
static const double SPACING = 0.2;

/* Of the run's last time: what is shorter does not change a time near it. */
static const double FINEST = 1e-15;

struct point {
  double time;
  struct em_vec place;
};

struct em_show {
  const struct em_run_file *file;
  struct em_show_options options;
  struct em_motion *motion;
  double trail_time;   /* s, how long trails are: not longer than the run */
  double trailed;      /* s: trails are known up to here */
  size_t points;       /* per ball, in a ring */
  struct point *trail; /* trail_count × TRAIL_POINTS */
  struct em_picture_bead *bead;
};

enum em_status em_show_new(struct em_show **show, const struct em_run_file *file,
                           const struct em_show_options *options, struct em_error *err) {
  const char *path = em_run_file_path(file);
  *show = NULL;
  if (options->trail_count > EM_SHOW_TRAILS)
    return em_error_set(err, EM_INPUT, path, 0, "trails of %zu balls; at most %d are possible",
                        options->trail_count, EM_SHOW_TRAILS);
  for (size_t k = 0; k < options->trail_count; k++)
    if (options->trail[k] >= em_run_file_ball_count(file))
      return em_error_set(err, EM_INPUT, path, 0, "no ball %zu for a trail; the run has %zu",
                          options->trail[k], em_run_file_ball_count(file));
  if (options->mark_time > 0.0 && !em_run_file_has_rows(file))
    return em_error_set(err, EM_INPUT, path, 0,
                        "collisions cannot be marked: the run has no collision table "
                        "(record.collisions)");
  if (options->classes && !em_run_file_has_rows(file))
    return em_error_set(err, EM_INPUT, path, 0,
                        "balls cannot be coloured by class: the run has no collision table "
                        "(record.collisions)");
  struct em_show *made = calloc(1, sizeof *made);
  if (made == NULL) return em_error_set(err, EM_MEMORY, path, 0, "no memory to show the run");
  made->file = file;
  made->options = *options;
  made->trailed = -INFINITY;
  made->trail = calloc(options->trail_count * TRAIL_POINTS + 1, sizeof *made->trail);
  made->bead = calloc(em_show_bead_room(made) + 1, sizeof *made->bead);
  enum em_status status = em_motion_new(&made->motion, file, options->mark_time, err);
  if (status == EM_OK && (made->trail == NULL || made->bead == NULL))
    status = em_error_set(err, EM_MEMORY, path, 0, "no memory to show the run");
  if (status != EM_OK) {
    em_show_free(made);
    return status;
  }
  made->trail_time = fmin(options->trail_time, em_show_last(made) - em_show_first(made));
  *show = made;
  return EM_OK;
}

void em_show_free(struct em_show *show) {
  if (show == NULL) return;
  em_motion_free(show->motion);
  free(show->trail);
  free(show->bead);
  free(show);
}

double em_show_first(const struct em_show *show) {
  return em_motion_first(show->motion);
}

double em_show_last(const struct em_show *show) {
  return em_motion_last(show->motion);
}

bool em_show_is_exact(const struct em_show *show) {
  return em_motion_is_exact(show->motion);
}

size_t em_show_bead_room(const struct em_show *show) {
  return show->options.trail_count * TRAIL_POINTS +
         (show->options.mark_time > 0.0 ? EM_SHOW_MARKS : 0);
}

/* The time in which the fastest of the balls goes from one bead to the next. */
static double step_from(const struct em_show *show, const struct em_balls *balls) {
  double step = show->trail_time / LEAST_POINTS;
  for (size_t k = 0; k < show->options.trail_count; k++) {
    struct em_vec place, velocity;
    em_motion_ball(show->motion, show->options.trail[k], &place, &velocity);
    const double speed = em_vec_norm(velocity);
    const double way = SPACING * balls->radius[show->options.trail[k]];
    if (speed * step > way) step = way / speed;
  }
  return fmax(fmax(step, show->trail_time / TRAIL_POINTS), FINEST * em_show_last(show));
}

/* Follows the trails up to a time. */
static enum em_status follow(struct em_show *show, double time, struct em_error *err) {
  if (show->options.trail_count == 0 || show->trail_time <= 0.0) return EM_OK;
  const double begin = fmax(em_show_first(show), time - show->trail_time);
  if (show->trailed > time || show->trailed < begin) { /* a jump: begin anew */
    show->trailed = begin;
    show->points = 0;
  }
  enum em_status status = em_motion_seek(show->motion, show->trailed, err);
  if (status != EM_OK) return status;
  const struct em_balls *balls = em_motion_balls(show->motion);
  for (double step; (step = step_from(show, balls)) <= time - show->trailed;) {
    show->trailed += step;
    status = em_motion_seek(show->motion, show->trailed, err);
    if (status != EM_OK) return status;
    for (size_t k = 0; k < show->options.trail_count; k++) {
      struct point *p = &show->trail[k * TRAIL_POINTS + show->points % TRAIL_POINTS];
      struct em_vec velocity;
      p->time = show->trailed;
      em_motion_ball(show->motion, show->options.trail[k], &p->place, &velocity);
    }
    show->points++;
  }
  return EM_OK;
}

/* A trail thins out towards its end, or towards the begin of the run. */
static size_t string_beads(const struct em_show *show, double time, const struct em_balls *balls) {
  const size_t known = show->points < TRAIL_POINTS ? show->points : TRAIL_POINTS;
  const double length = fmin(show->trail_time, time - em_show_first(show));
  size_t count = 0;
  for (size_t k = 0; k < show->options.trail_count; k++) {
    const uint8_t *c = em_colour_cycle((unsigned)k + 1);
    const double radius = balls->radius[show->options.trail[k]];
    for (size_t j = 0; j < known; j++) {
      const struct point *p = &show->trail[k * TRAIL_POINTS + j];
      const double age = (time - p->time) / length;
      if (!(age >= 0.0 && age <= 1.0)) continue;
      show->bead[count++] = (struct em_picture_bead){
          p->place, radius * (0.45 - 0.30 * age), {c[0], c[1], c[2]}, false};
    }
  }
  return count;
}

/* The discs of collisions fit between the smallest balls. */
static size_t mark(struct em_show *show, size_t beads, const struct em_balls *balls) {
  double radius = balls->radius[0];
  for (size_t k = 1; k < balls->count; k++)
    radius = fmin(radius, balls->radius[k]);
  return em_motion_marks(show->motion, show->bead + beads, EM_SHOW_MARKS, 0.6 * radius);
}

enum em_status em_show_at(struct em_show *show, double time, struct em_picture_state *state,
                          struct em_error *err) {
  enum em_status status = follow(show, time, err);
  if (status == EM_OK) status = em_motion_seek(show->motion, time, err);
  if (status != EM_OK) return status;
  const struct em_balls *balls = em_motion_balls(show->motion);
  const size_t beads = string_beads(show, time, balls);
  const size_t marks = show->options.mark_time > 0.0 ? mark(show, beads, balls) : 0;
  const size_t marked = marks < EM_SHOW_MARKS ? marks : EM_SHOW_MARKS;
  *state = (struct em_picture_state){
      .balls = balls,
      .time = fmin(fmax(time, em_show_first(show)), em_show_last(show)),
      .blade_angle = em_motion_blades(show->motion),
      .last = em_motion_classes(show->motion),
      .bead_count = beads + marked,
      .bead = show->bead,
      .unmarked = marks - marked,
  };
  return EM_OK;
}
