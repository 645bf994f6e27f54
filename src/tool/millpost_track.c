/* millpost track: restitution from films of a ball that hits a plate. */
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "eventmill/track.h"
#include "tool/millpost.h"

static const char help[] =
    "Usage: millpost track FOLDER ... --fps F (--diameter D | --scale S) [OPTION ...]\n\n"
    "Measures the normal restitution of a ball that is shot, or falls, at a plate. Each FOLDER "
    "holds\n"
    "one film as PNG frames in the order of their names, from a camera that stands still. Uneven\n"
    "light, flicker, stripes and noise are taken out; the plate has to be along a side of the "
    "picture.\n\nOptions:\n"
    "  --fps F            frames per second of the camera\n"
    "  --diameter D       of the ball, in m: gives the scale\n"
    "  --scale S          m per pixel, when it is known better\n"
    "  --plate SIDE       left, right, top, bottom; default: auto, where the ball turns back\n"
    "  --roundness X      how far U²/(4πA) of a contour may be from 1; default: 0.15\n"
    "  --smoothing S      of the frames, in pixels; default: 1\n"
    "  --places           list centre and radius in each frame\n"
    "  --output FILE      -o FILE: speed and restitution of each film, for millpost fit\n"
    "  --csv, --json      tables for programs\n"
    "  --help             print this\n\n"
    "Examples:\n"
    "  millpost track shot-17 --fps 5000 --diameter 0.005\n"
    "  millpost track shots/* --fps 5000 --diameter 0.005 -o shots.txt\n"
    "  millpost fit shots.txt -o shots.png\n";

static const struct option options[] = {
    {"fps", required_argument, NULL, 'f'},
    {"diameter", required_argument, NULL, 'd'},
    {"scale", required_argument, NULL, 's'},
    {"plate", required_argument, NULL, 'p'},
    {"roundness", required_argument, NULL, 'r'},
    {"smoothing", required_argument, NULL, 'm'},
    {"places", no_argument, NULL, 'l'},
    {"output", required_argument, NULL, 'o'},
    {"csv", no_argument, NULL, 'c'},
    {"json", no_argument, NULL, 'j'},
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

struct wish {
  struct em_track_options track;
  struct em_millpost_options print; /* format alone */
  const char *out;
  bool places;
};

static int read_number(const char *name, const char *text, double *value) {
  char *end;
  *value = strtod(text, &end);
  if (end == text || *end != '\0' || !isfinite(*value))
    return em_millpost_usage("track", "--%s: '%s' is not a number", name, text);
  if (!(*value > 0.0)) return em_millpost_usage("track", "--%s: %s is not above 0", name, text);
  return -1;
}

static int store(struct wish *wish, int option, const char *text) {
  struct em_track_options *o = &wish->track;
  int side;
  switch (option) {
  case 'f':
    return read_number("fps", text, &o->fps);
  case 'd':
    return read_number("diameter", text, &o->diameter);
  case 's':
    return read_number("scale", text, &o->scale);
  case 'r':
    return read_number("roundness", text, &o->roundness);
  case 'm':
    return read_number("smoothing", text, &o->smoothing);
  case 'p':
    side = em_track_plate_find(text);
    if (side < 0)
      return em_millpost_usage("track",
                               "--plate: unknown side '%s', expected auto, left, right, top or "
                               "bottom",
                               text);
    o->plate = (enum em_track_plate)side;
    return -1;
  case 'o':
    wish->out = text;
    return -1;
  case 'c':
    wish->print.format = EM_REPORT_CSV;
    return -1;
  case 'j':
    wish->print.format = EM_REPORT_JSON;
    return -1;
  default:
    wish->places = true;
    return -1;
  }
}

static int read_command_line(struct wish *wish, int argc, char **argv) {
  *wish = (struct wish){.places = false};
  opterr = 0;
  optind = 0; /* glibc: start afresh */
  for (int c; (c = getopt_long(argc, argv, ":ho:", options, NULL)) != -1;) {
    const char *asked = optind > 0 ? argv[optind - 1] : "";
    if (c == 'h') {
      fputs(help, stdout);
      return EM_MILLPOST_DONE;
    }
    if (c == ':') return em_millpost_usage("track", "'%s' needs a value", asked);
    if (c == '?') return em_millpost_usage("track", "unknown option '%s'", asked);
    const int code = store(wish, c, optarg);
    if (code >= 0) return code;
  }
  if (optind == argc) return em_millpost_usage("track", "expected FOLDER, with PNG frames");
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
  em_report_column(report, "radius", "radius", "pixel");
  em_report_column(report, "sigma", "scatter", "pixel");
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
  em_report_number(report, t->scale);
  em_report_number(report, t->radius);
  em_report_number(report, t->sigma);
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
  FILE *out = fopen(path, "w");
  bool good = out != NULL;
  if (good) {
    fprintf(out, "# speed (m/s), restitution; standard error of restitution, film\n");
    for (int k = 0; k < count; k++)
      fprintf(out, "%.8g %.8g # %.2g %s\n", track[k]->approach.value, track[k]->restitution.value,
              track[k]->restitution.error, folder[k]);
    good = !ferror(out);
    good = fclose(out) == 0 && good;
  }
  if (good) return EM_OK;
  return em_error_set(err, EM_FILE, path, 0, "cannot be written: %s", strerror(errno));
}

static struct em_report *report_of(const struct wish *wish, char *const *folder,
                                   struct em_track *const *track, int count) {
  struct em_report *report = em_report_new("track");
  em_report_fact(report, "fps", "frames per second", wish->track.fps, "1/s");
  begin_shots(report);
  for (int k = 0; k < count; k++)
    add_shot(report, folder[k], track[k]);
  if (!wish->places) return report;
  em_report_begin(report, "places", "The ball, frame by frame");
  em_report_column(report, "film", "film", "");
  em_report_column(report, "frame", "frame", "");
  em_report_column(report, "x", "x", "pixel");
  em_report_column(report, "y", "y", "pixel");
  em_report_column(report, "radius", "radius", "pixel");
  em_report_column(report, "roundness", "U²/4πA", "");
  for (int k = 0; k < count; k++)
    add_places(report, folder[k], track[k]);
  return report;
}

int em_millpost_track(int argc, char **argv) {
  struct wish wish;
  struct em_error err = {.code = EM_OK};
  const int wrong = read_command_line(&wish, argc, argv);
  if (wrong >= 0) return wrong;
  const int count = argc - optind;
  char **folder = argv + optind;
  struct em_track **track = calloc((size_t)count, sizeof *track);
  enum em_status status =
      track != NULL ? EM_OK : em_error_set(&err, EM_MEMORY, NULL, 0, "no memory for the films");
  for (int k = 0; k < count && status == EM_OK; k++)
    status = em_track_folder(&track[k], folder[k], &wish.track, &err);
  if (status == EM_OK && wish.out != NULL)
    status = write_pairs(wish.out, folder, track, count, &err);
  const int code = status == EM_OK ? em_millpost_print(report_of(&wish, folder, track, count),
                                                       &wish.print, EM_MILLPOST_DONE)
                                   : em_millpost_fail(&err);
  for (int k = 0; k < count && track != NULL; k++)
    em_track_free(track[k]);
  free(track);
  return code;
}
