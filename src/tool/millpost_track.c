/* millpost track: restitution from films of a ball that hits a plate. */
#include <stdio.h>
#include <stdlib.h>

#include "eventmill/track.h"
#include "record/output.h"
#include "tool/millpost.h"

struct wish {
  struct em_track_options track;
  struct em_millpost_options print; /* format alone */
  const char *out;
  bool places, quiet;
};

static int read_plate(void *place, const char *command, const char *option, const char *text) {
  const int side = em_track_plate_find(text);
  if (side < 0)
    return em_millpost_usage(
        command, "--%s: unknown side '%s', expected one of:" EM_TRACK_PLATE_LIST(EM_MILLPOST_WORD),
        option, text);
  *(enum em_track_plate *)place = (enum em_track_plate)side;
  return -1;
}

#define AT(field) offsetof(struct wish, field)
#define OPTION(key, argument, help, target, field) \
  EM_MILLPOST_OPTION(struct wish, key, argument, help, target, field)

static const struct em_millpost_option options[] = {
    OPTION("fps", "F", "frames per second of the camera", POSITIVE, track.fps),
    OPTION("diameter", "D", "of the ball, in m: gives the scale", POSITIVE, track.diameter),
    OPTION("scale", "S", "m per pixel, when it is known better", POSITIVE, track.scale),
    {"plate", "SIDE",
     "one of:" EM_TRACK_PLATE_LIST(EM_MILLPOST_WORD) "; default: auto, where the ball turns back",
     EM_MILLPOST_OTHER, AT(track.plate), NULL, 0, read_plate},
    OPTION("roundness", "X", "how far U²/(4πA) of a contour may be from 1; default: 0.15", POSITIVE,
           track.roundness),
    OPTION("smoothing", "S", "of the frames, in pixels, 0.5 to 3, more for noise; default: 1",
           POSITIVE, track.smoothing),
    OPTION("places", NULL, "list centre and radius in each frame", FLAG, places),
    OPTION("output", "FILE", "-o FILE: speed and restitution of each film, for millpost fit", TEXT,
           out),
    {"csv", NULL, "print comma-separated values", EM_MILLPOST_CHOICE, AT(print.format), NULL,
     EM_REPORT_CSV, NULL},
    {"json", NULL, "-j: print one JSON object", EM_MILLPOST_CHOICE, AT(print.format), NULL,
     EM_REPORT_JSON, NULL},
};

static const struct em_millpost_help help = {
    .name = "track",
    .arguments = "FOLDER ... --fps F (--diameter D | --scale S)",
    .summary = "Measures the normal restitution of a ball that is shot, or falls, at a plate.",
    .details =
        "Each FOLDER holds one film as PNG frames in the order of their names, from a camera that\n"
        "stands still. Uneven light, flicker, stripes and noise are taken out; the ball may not "
        "be\n"
        "in one place in half of the frames, and the plate has to be along a side of the picture.\n"
        "With --diameter, errors of speeds contain that of the radius in pixels. A film without "
        "an\n"
        "impact, or in which more frames about it are lost than the ball is seen in on a side, is\n"
        "reported, and the others go on.",
    .examples = "  millpost track shot-17 --fps 5000 --diameter 0.005\n"
                "  millpost track shots/* --fps 5000 --diameter 0.005 -o shots.txt\n"
                "  millpost fit shots.txt -o shots.png",
    .least = 1,
    .most = -1,
};

static int read_command_line(struct wish *wish, int argc, char **argv, int *count, char ***folder) {
  static const struct em_millpost_line line = {options, sizeof options / sizeof *options,
                                               AT(quiet)};
  *wish = (struct wish){.places = false};
  const int code = em_millpost_line_read(wish, &line, &help, argc, argv, count, folder);
  if (code >= 0) return code;
  if (!(wish->track.fps > 0.0))
    return em_millpost_usage("track", "expected --fps, the camera's frames per second");
  if (!(wish->track.scale > 0.0) && !(wish->track.diameter > 0.0))
    return em_millpost_usage("track",
                             "expected --diameter of the ball or --scale in metres per pixel");
  return -1;
}

static void begin_shots(struct em_report *report) {
  em_report_begin(report, "shots", "Shots, ± standard error");
  em_report_column(report, "film", "film", "");
  em_report_column(report, "speed", "v before", "m/s");
  em_report_column(report, "restitution", "ε_n", "");
  em_report_column(report, "restitution_error", "±", "");
  em_report_column(report, "speed_error", "± of v", "m/s");
  em_report_column(report, "departure", "v after", "m/s");
  em_report_column(report, "departure_error", "±", "m/s");
  em_report_column(report, "tangent_before", "v_t before", "m/s");
  em_report_column(report, "tangent_after", "v_t after", "m/s");
  em_report_column(report, "plate", "plate", "");
  em_report_column(report, "before", "frames before", "");
  em_report_column(report, "after", "after", "");
  em_report_column(report, "scale", "scale", "m/pixel");
  em_report_column(report, "scale_error", "±", "m/pixel");
  em_report_column(report, "radius", "radius", "pixel");
  em_report_column(report, "sigma", "scatter", "pixel");
  em_report_column(report, "lost", "frames lost", "");
  em_report_column(report, "frames", "of", "");
}

static void add_shot(struct em_report *report, const char *folder, const struct em_track *t) {
  em_report_text(report, "%s", folder);
  em_report_number(report, t->approach.value);
  em_report_number(report, t->restitution.value);
  em_report_number(report, t->restitution.error);
  em_report_number(report, t->approach.error);
  em_report_number(report, t->departure.value);
  em_report_number(report, t->departure.error);
  em_report_number(report, t->tangent_before.value);
  em_report_number(report, t->tangent_after.value);
  em_report_text(report, "%s", em_track_plate_name(t->plate));
  em_report_count(report, t->before);
  em_report_count(report, t->after);
  em_report_number(report, t->scale.value);
  em_report_number(report, t->scale.error);
  em_report_number(report, t->radius.value);
  em_report_number(report, t->sigma);
  em_report_count(report, t->lost);
  em_report_count(report, t->frames);
}

static void add_places(struct em_report *report, const char *folder, const struct em_track *t) {
  for (size_t k = 0; k < t->count; k++) {
    em_report_text(report, "%s", folder);
    em_report_count(report, t->spot[k].frame);
    em_report_number(report, t->spot[k].x);
    em_report_number(report, t->spot[k].y);
    em_report_number(report, t->spot[k].radius);
    em_report_number(report, t->spot[k].roundness);
  }
}

static enum em_status write_pairs(const char *path, char *const *folder,
                                  struct em_track *const *track, int count, struct em_error *err) {
  struct em_output file;
  const enum em_status status = em_output_begin(&file, path, EM_OUTPUT_STREAM, err);
  if (status != EM_OK) return status;
  fprintf(file.out, "# speed (m/s), restitution; standard error of restitution, film\n");
  for (int k = 0; k < count; k++)
    if (track[k])
      fprintf(file.out, "%.8g %.8g # %.2g %s\n", track[k]->approach.value,
              track[k]->restitution.value, track[k]->restitution.error, folder[k]);
  return em_output_end(&file, EM_OK, err);
}

static struct em_report *report_of(const struct wish *wish, char *const *folder,
                                   struct em_track *const *track, int count) {
  struct em_report *report = em_report_new("track");
  em_report_fact(report, "fps", "frames per second", wish->track.fps, "1/s");
  begin_shots(report);
  for (int k = 0; k < count; k++)
    if (track[k]) add_shot(report, folder[k], track[k]);
  for (int k = 0; k < count; k++)
    if (track[k] && track[k]->lost > 0)
      em_report_note(report,
                     "%s: frames without the ball between the first and the last with it: %zu",
                     folder[k], track[k]->lost);
  if (!wish->places) return report;
  em_report_begin(report, "places", "The ball, frame by frame");
  em_report_column(report, "film", "film", "");
  em_report_column(report, "frame", "frame", "");
  em_report_column(report, "x", "x", "pixel");
  em_report_column(report, "y", "y", "pixel");
  em_report_column(report, "radius", "radius", "pixel");
  em_report_column(report, "roundness", "U²/4πA", "");
  for (int k = 0; k < count; k++)
    if (track[k]) add_places(report, folder[k], track[k]);
  return report;
}

/* Measures all films; those that fail stay NULL, and the first failure's exit code is returned. */
static int measure(struct em_track **track, char *const *folder, int count,
                   const struct em_track_options *o, int *good) {
  int code = EM_MILLPOST_DONE;
  *good = 0;
  for (int k = 0; k < count; k++) {
    struct em_error err = {.code = EM_OK};
    if (em_track_folder(&track[k], folder[k], o, &err) == EM_OK) {
      (*good)++;
      continue;
    }
    if (err.code == EM_FILE) err.code = EM_INPUT;
    const int failed = em_millpost_fail(&err);
    if (code == EM_MILLPOST_DONE) code = failed;
  }
  return code;
}

int em_millpost_track(int argc, char **argv) {
  struct wish wish;
  struct em_error err = {.code = EM_OK};
  int count, good;
  char **folder;
  const int wrong = read_command_line(&wish, argc, argv, &count, &folder);
  if (wrong >= 0) return wrong;
  struct em_track **track = calloc((size_t)count, sizeof *track);
  if (!track) {
    em_error_set(&err, EM_MEMORY, NULL, 0, "no memory for the films");
    return em_millpost_fail(&err);
  }
  int code = measure(track, folder, count, &wish.track, &good);
  if (good > 0 && wish.out != NULL && write_pairs(wish.out, folder, track, count, &err) != EM_OK)
    code = em_millpost_fail(&err);
  if (good > 0) code = em_millpost_print(report_of(&wish, folder, track, count), &wish.print, code);
  for (int k = 0; k < count; k++)
    em_track_free(track[k]);
  free(track);
  return code;
}
