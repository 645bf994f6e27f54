/* The command line of frame and film: one table of options, of which each takes its own. */
#include "tool/millpost_look.h"

#include <errno.h>
#include <getopt.h>
#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tool/millpost.h"

enum target { TEXT, FLAG, NUMBER, POSITIVE, WHOLE, SIZE, RANGE, VIEW, BY, MAP, HIDE, TRAIL };

struct entry {
  const char *name, *argument, *help;
  enum target target;
  size_t offset;
  unsigned kinds;
};

#define AT(field) offsetof(struct em_millpost_look, field)
enum { BOTH = EM_LOOK_FRAME | EM_LOOK_FILM };

static const struct entry entries[] = {
    {"at", "T", "the moment, in seconds; default: the last frame", NUMBER, AT(at), EM_LOOK_FRAME},
    {"triple", "DT", "three moments, DT seconds apart, as red, green and blue", POSITIVE,
     AT(triple), EM_LOOK_FRAME},
    {"from", "T", "begin at T seconds; default: the first frame", NUMBER, AT(from), EM_LOOK_FILM},
    {"to", "T", "end at T seconds; default: the last frame", NUMBER, AT(to), EM_LOOK_FILM},
    {"fps", "N", "frames per second of film; default: 25", POSITIVE, AT(fps), EM_LOOK_FILM},
    {"slow", "X",
     "slow motion: X seconds of film for one of the mill; default: every stored\n"
     "                     frame once, or 1 ms per frame with a collision table",
     POSITIVE, AT(slow), EM_LOOK_FILM},
    {"orbit", "DEG", "the camera goes round, DEG degrees per second of film", NUMBER, AT(orbit),
     EM_LOOK_FILM},
    {"camera", "VIEW", "axial, side or three-quarter; default: three-quarter", VIEW, AT(view),
     BOTH},
    {"turn", "DEG", "where the camera stands: 0 sees along the axis, 90 from the side", NUMBER,
     AT(turn), BOTH},
    {"tilt", "DEG", "how high the camera stands, -90 to 90", NUMBER, AT(tilt), BOTH},
    {"zoom", "X", "closer: 2 shows everything twice as large", POSITIVE, AT(zoom), BOTH},
    {"parallel", NULL, "without perspective", FLAG, AT(parallel), BOTH},
    {"size", "WxH", "pixels; default: 1280x720", SIZE, AT(width), BOTH},
    {"colour", "WHAT",
     "what colours tell: speed, spin, class (of the last contact; needs a\n"
     "                     collision table), species or plain; default: speed",
     BY, AT(by), BOTH},
    {"map", "NAME", "lagoon, ember, grey or balance; default: lagoon", MAP, AT(map), BOTH},
    {"scale", "LOW:HIGH", "ends of the colour scale; default: 0 to 110 % of the tip speed", RANGE,
     AT(low), BOTH},
    {"speeds", "LOW:HIGH", "only balls as fast as this, in m/s", RANGE, AT(show_low), BOTH},
    {"balls", "N", "no more than N balls", WHOLE, AT(balls), BOTH},
    {"hide", "WHAT,...", "rotor, drum, balls, legend, histogram", HIDE, 0, BOTH},
    {"trail", "BALL,...", "these balls (numbers from 0) draw a trail", TRAIL, 0, BOTH},
    {"trail-time", "T", "how long a trail is, in seconds; default: 0.05", POSITIVE,
     AT(show.trail_time), BOTH},
    {"marks", "T", "mark the collisions of the last T seconds (needs a collision table)", POSITIVE,
     AT(show.mark_time), BOTH},
    {"smooth", "N", "samples per pixel each way, 1 to 4; default: 2 for frames, 1 for film", WHOLE,
     AT(smooth), BOTH},
    {"dark", NULL, "on a dark ground", FLAG, AT(dark), BOTH},
    {"workers", "N", "processes that draw; default: one per core", WHOLE, AT(workers),
     EM_LOOK_FILM},
    {"quality", "Q", "H.264's rate factor, 1 (best) to 51; default: 20", WHOLE, AT(quality),
     EM_LOOK_FILM},
    {"output", "FILE", "-o FILE: what to write; default: the run's name, in this folder", TEXT,
     AT(out), BOTH},
    {"quiet", NULL, "no progress, no report", FLAG, AT(quiet), BOTH},
};

enum { ENTRIES = sizeof entries / sizeof *entries };

static const char *command_name(enum em_millpost_kind kind) {
  return kind == EM_LOOK_FRAME ? "frame" : "film";
}

static void print_help(enum em_millpost_kind kind) {
  if (kind == EM_LOOK_FRAME)
    printf("Usage: millpost frame RUN [--at T] [-o FILE.png] [OPTION ...]\n\n"
           "Draws a picture of a moment of a run.\n");
  else
    printf("Usage: millpost film RUN [--fps N] [-o FILE.mp4] [OPTION ...]\n\n"
           "Makes a film of a run (H.264, plays everywhere).\n");
  printf("\nBetween stored frames, balls move on exact paths when the run has a collision table,\n"
         "else on smooth curves.\n\nOptions:\n");
  for (int k = 0; k < ENTRIES; k++) {
    char left[64];
    if (!(entries[k].kinds & (unsigned)kind)) continue;
    snprintf(left, sizeof left, "--%s%s%s", entries[k].name, entries[k].argument ? " " : "",
             entries[k].argument ? entries[k].argument : "");
    printf("  %-18s %s\n", left, entries[k].help);
  }
  printf("  %-18s %s\n\nExamples:\n", "--help", "print this");
  if (kind == EM_LOOK_FRAME)
    printf("  millpost frame run.h5 --at 0.25\n"
           "  millpost frame run.h5 --camera axial --speeds 3:9 -o fast-balls.png\n"
           "  millpost frame run.h5 --at 0.2 --trail 17,256 --hide balls --dark\n"
           "  millpost frame run.h5 --at 0.2 --triple 0.002 --camera axial -o triple.png\n");
  else
    printf("  millpost film run.h5\n"
           "  millpost film run.h5 --slow 40 --orbit 10 -o mill.mp4\n"
           "  millpost film run.h5 --camera axial --from 0.2 --to 0.4 --size 1920x1080\n");
}

static bool read_number(const char *text, char end, double *value, const char **rest) {
  char *stop;
  *value = strtod(text, &stop);
  if (rest != NULL) *rest = stop;
  return stop != text && *stop == end && isfinite(*value);
}

static int read_size(struct em_millpost_look *look, const char *command, const char *text) {
  int used = 0;
  if (sscanf(text, "%5dx%5d%n", &look->width, &look->height, &used) == 2 && text[used] == '\0' &&
      look->width >= 16 && look->height >= 16 && look->width <= 4096 && look->height <= 4096)
    return -1;
  return em_millpost_usage(command, "--size: '%s' is not WIDTHxHEIGHT with 16 to 4096 pixels each",
                           text);
}

static int read_range(double *low, const char *command, const char *name, const char *text) {
  const char *rest;
  if (read_number(text, ':', &low[0], &rest) && read_number(rest + 1, '\0', &low[1], NULL) &&
      low[0] < low[1])
    return -1;
  return em_millpost_usage(command, "--%s: '%s' is not LOW:HIGH with LOW < HIGH", name, text);
}

static int read_hide(struct em_millpost_look *look, const char *command, const char *text) {
  const struct {
    const char *name;
    bool *flag;
  } things[] = {{"rotor", &look->hide_rotor},
                {"drum", &look->hide_drum},
                {"balls", &look->hide_balls},
                {"legend", &look->hide_legend},
                {"histogram", &look->hide_histogram}};
  for (const char *at = text;; at++) {
    const size_t length = strcspn(at, ",");
    bool known = false;
    for (size_t k = 0; k < sizeof things / sizeof *things; k++)
      if (strlen(things[k].name) == length && strncmp(at, things[k].name, length) == 0)
        known = *things[k].flag = true;
    if (!known)
      return em_millpost_usage(command,
                               "--hide: unknown thing '%.*s', expected rotor, drum, balls, legend "
                               "or histogram",
                               (int)length, at);
    at += length;
    if (*at == '\0') return -1;
  }
}

static int read_trail(struct em_millpost_look *look, const char *command, const char *text) {
  look->show.trail_count = 0;
  for (const char *at = text;; at++) {
    char *stop;
    errno = 0;
    const long ball = strtol(at, &stop, 10);
    if (stop == at || (*stop != ',' && *stop != '\0') || ball < 0 || errno != 0 ||
        look->show.trail_count == EM_SHOW_TRAILS)
      return em_millpost_usage(command, "--trail: '%s' is not a list of at most %d balls", text,
                               EM_SHOW_TRAILS);
    look->show.trail[look->show.trail_count++] = (size_t)ball;
    at = stop;
    if (*at == '\0') return -1;
  }
}

static int read_name(int *place, int found, const char *command, const struct entry *entry,
                     const char *text) {
  *place = found;
  if (found >= 0) return -1;
  return em_millpost_usage(command, "--%s: unknown '%s', expected %s", entry->name, text,
                           entry->target == VIEW  ? "axial, side or three-quarter"
                           : entry->target == MAP ? "lagoon, ember, grey or balance"
                                                  : "speed, spin, class, species or plain");
}

static int store(struct em_millpost_look *look, const struct entry *entry, const char *command,
                 const char *text) {
  void *place = (char *)look + entry->offset;
  double value;
  switch (entry->target) {
  case TEXT:
    *(const char **)place = text;
    return -1;
  case FLAG:
    *(bool *)place = true;
    return -1;
  case NUMBER:
  case POSITIVE:
  case WHOLE:
    if (!read_number(text, '\0', &value, NULL))
      return em_millpost_usage(command, "--%s: '%s' is not a number", entry->name, text);
    if (entry->target == POSITIVE && !(value > 0.0))
      return em_millpost_usage(command, "--%s: %s is not above 0", entry->name, text);
    if (entry->target == WHOLE && !(value >= 1.0 && value <= 1e9 && value == floor(value)))
      return em_millpost_usage(command, "--%s: '%s' is not a whole number above 0", entry->name,
                               text);
    *(double *)place = value;
    return -1;
  case SIZE:
    return read_size(look, command, text);
  case RANGE:
    return read_range(place, command, entry->name, text);
  case VIEW:
    return read_name(place, em_camera_find(text), command, entry, text);
  case BY:
    return read_name(place, em_picture_find(text), command, entry, text);
  case MAP:
    return read_name(place, em_colour_find(text), command, entry, text);
  case HIDE:
    return read_hide(look, command, text);
  case TRAIL:
  default:
    return read_trail(look, command, text);
  }
}

static void list_options(struct option *list, enum em_millpost_kind kind) {
  int count = 0;
  for (int k = 0; k < ENTRIES; k++)
    if (entries[k].kinds & (unsigned)kind)
      list[count++] = (struct option){
          entries[k].name, entries[k].argument ? required_argument : no_argument, NULL, 1000 + k};
  list[count++] = (struct option){"color", required_argument, NULL, 'c'};
  list[count++] = (struct option){"help", no_argument, NULL, 'h'};
  list[count] = (struct option){NULL, 0, NULL, 0};
}

static const struct entry *entry_named(const char *name) {
  for (int k = 0; k < ENTRIES; k++)
    if (strcmp(entries[k].name, name) == 0) return &entries[k];
  return NULL;
}

int em_millpost_look_read(struct em_millpost_look *look, enum em_millpost_kind kind, int argc,
                          char **argv) {
  const char *command = command_name(kind);
  struct option list[ENTRIES + 3];
  list_options(list, kind);
  *look = (struct em_millpost_look){.view = -1,
                                    .by = -1,
                                    .map = -1,
                                    .turn = NAN,
                                    .tilt = NAN,
                                    .low = NAN,
                                    .high = NAN,
                                    .at = NAN,
                                    .triple = NAN,
                                    .from = NAN,
                                    .to = NAN,
                                    .fps = 25.0,
                                    .slow = NAN,
                                    .show = {.trail_time = 0.05}};
  opterr = 0;
  optind = 0; /* glibc: start afresh */
  for (int c; (c = getopt_long(argc, argv, ":ho:", list, NULL)) != -1;) {
    const char *asked = optind > 0 ? argv[optind - 1] : "";
    if (c == 'h') {
      print_help(kind);
      return EM_MILLPOST_DONE;
    }
    if (c == ':') return em_millpost_usage(command, "'%s' needs a value", asked);
    if (c == '?') return em_millpost_usage(command, "unknown option '%s'", asked);
    const struct entry *entry = c == 'o'   ? entry_named("output")
                                : c == 'c' ? entry_named("colour")
                                           : &entries[c - 1000];
    const int code = store(look, entry, command, optarg);
    if (code >= 0) return code;
  }
  if (optind == argc) return em_millpost_usage(command, "expected RUN, a run file");
  if (optind + 1 < argc)
    return em_millpost_usage(command, "unexpected argument '%s'", argv[optind + 1]);
  look->run = argv[optind];
  return -1;
}

struct em_picture_options em_millpost_look_picture(const struct em_millpost_look *look,
                                                   const struct em_scene *scene,
                                                   const struct em_balls *balls) {
  const double degree = M_PI / 180.0;
  struct em_picture_options o = em_picture_default(scene, balls);
  if (look->width > 0) {
    o.width = look->width;
    o.height = look->height;
  }
  if (look->view >= 0) o.camera = em_camera_make((enum em_camera_view)look->view);
  if (isfinite(look->turn)) o.camera.azimuth = look->turn * degree;
  if (isfinite(look->tilt)) o.camera.elevation = fmax(-90.0, fmin(90.0, look->tilt)) * degree;
  if (look->zoom > 0.0) o.camera.zoom = look->zoom;
  if (look->parallel) o.camera.fov = 0.0;
  if (look->by >= 0) o.by = (enum em_picture_by)look->by;
  if (look->map >= 0) o.map = (enum em_colour)look->map;
  if (o.by == EM_PICTURE_SPIN) o.high = em_picture_spin_scale(balls);
  if (isfinite(look->low)) {
    o.low = look->low;
    o.high = look->high;
  }
  o.show_low = look->show_low;
  o.show_high = look->show_high;
  o.limit = (size_t)look->balls;
  if (look->smooth > 0.0) o.smooth = (int)look->smooth;
  o.hide_rotor = look->hide_rotor;
  o.hide_drum = look->hide_drum;
  o.hide_balls = look->hide_balls;
  o.hide_legend = look->hide_legend;
  o.histogram = !look->hide_histogram;
  o.dark = look->dark;
  return o;
}
