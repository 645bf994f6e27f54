/* The command line of frame and film: one table of options, of which each takes its own. */
#include "tool/millpost_look.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tool/millpost.h"

#define AT(field) offsetof(struct em_millpost_look, field)
#define OPTION(key, argument, help, target, field) \
  EM_MILLPOST_OPTION(struct em_millpost_look, key, argument, help, target, field)

static int read_size(void *place, const char *command, const char *option, const char *text) {
  int *size = place;
  int used = 0;
  if (sscanf(text, "%5dx%5d%n", &size[0], &size[1], &used) == 2 && text[used] == '\0' &&
      size[0] >= 16 && size[1] >= 16 && size[0] <= 4096 && size[1] <= 4096)
    return -1;
  return em_millpost_usage(command, "--%s: '%s' is not WIDTHxHEIGHT with 16 to 4096 pixels each",
                           option, text);
}

#define HIDDEN_WORD(name) " " #name
static const char hidden_words[] = EM_MILLPOST_HIDDEN_LIST(HIDDEN_WORD);

static int read_hide(void *place, const char *command, const char *option, const char *text) {
  struct em_millpost_hidden *hide = place;
#define THING(name) {#name, &hide->name},
  const struct {
    const char *name;
    bool *flag;
  } things[] = {EM_MILLPOST_HIDDEN_LIST(THING)};
#undef THING
  for (const char *at = text;; at++) {
    const size_t length = strcspn(at, ",");
    bool known = false;
    for (size_t k = 0; k < sizeof things / sizeof *things; k++)
      if (strlen(things[k].name) == length && strncmp(at, things[k].name, length) == 0)
        known = *things[k].flag = true;
    if (!known)
      return em_millpost_usage(command, "--%s: unknown thing '%.*s', expected any of:%s", option,
                               (int)length, at, hidden_words);
    at += length;
    if (*at == '\0') return -1;
  }
}

static int read_trail(void *place, const char *command, const char *option, const char *text) {
  struct em_show_options *show = place;
  show->trail_count = 0;
  for (const char *at = text;; at++) {
    char *stop;
    errno = 0;
    const long ball = strtol(at, &stop, 10);
    if (stop == at || (*stop != ',' && *stop != '\0') || ball < 0 || errno != 0 ||
        show->trail_count == EM_SHOW_TRAILS)
      return em_millpost_usage(command, "--%s: '%s' is not a list of at most %d balls", option,
                               text, EM_SHOW_TRAILS);
    show->trail[show->trail_count++] = (size_t)ball;
    at = stop;
    if (*at == '\0') return -1;
  }
}

static int read_name(int *place, int found, const char *expected, const char *command,
                     const char *option, const char *text) {
  *place = found;
  if (found >= 0) return -1;
  return em_millpost_usage(command, "--%s: unknown '%s', expected one of:%s", option, text,
                           expected);
}

static int read_view(void *place, const char *command, const char *option, const char *text) {
  return read_name(place, em_camera_find(text), EM_CAMERA_LIST(EM_MILLPOST_WORD), command, option,
                   text);
}

static int read_by(void *place, const char *command, const char *option, const char *text) {
  return read_name(place, em_picture_find(text), EM_PICTURE_LIST(EM_MILLPOST_WORD), command, option,
                   text);
}

static int read_map(void *place, const char *command, const char *option, const char *text) {
  return read_name(place, em_colour_find(text), EM_COLOUR_LIST(EM_MILLPOST_WORD), command, option,
                   text);
}

static int read_quality(void *place, const char *command, const char *option, const char *text) {
  double value;
  if (em_millpost_line_number(text, '\0', &value, NULL) && value >= 1.0 && value <= 51.0 &&
      value == floor(value)) {
    *(long *)place = (long)value;
    return -1;
  }
  return em_millpost_usage(command, "--%s: '%s' is not a whole number from 1 to 51", option, text);
}

static const struct em_millpost_option options[] = {
    OPTION("at", "T", "the moment, in seconds; default: the last one that can be shown", NUMBER,
           at),
    OPTION("triple", "DT", "three moments, DT seconds apart, as red, green and blue", POSITIVE,
           triple),
    OPTION("from", "T", "begin at T seconds; default: the first frame", NUMBER, from),
    OPTION("to", "T", "end at T seconds; default: the last frame", NUMBER, to),
    OPTION("fps", "N", "frames per second of film; default: 25", POSITIVE, fps),
    OPTION("slow", "X",
           "slow motion: X seconds of film for one of the mill; default: every stored\n"
           "                     frame once, or 1 ms per frame with a collision table",
           POSITIVE, slow),
    OPTION("orbit", "DEG", "the camera goes round, DEG degrees per second of film", NUMBER, orbit),
    {"camera", "VIEW", "one of:" EM_CAMERA_LIST(EM_MILLPOST_WORD) "; default: three-quarter",
     EM_MILLPOST_OTHER, AT(view), NULL, 0, read_view},
    OPTION("turn", "DEG", "where the camera stands: 0 sees along the axis, 90 from the side",
           NUMBER, turn),
    OPTION("tilt", "DEG", "how high the camera stands, -90 to 90", NUMBER, tilt),
    OPTION("zoom", "X", "closer: 2 shows everything twice as large", POSITIVE, zoom),
    OPTION("parallel", NULL, "without perspective", FLAG, parallel),
    {"size", "WxH", "pixels; default: 1280x720", EM_MILLPOST_OTHER, AT(width), NULL, 0, read_size},
    {"colour", "WHAT",
     "what colours tell:" EM_PICTURE_LIST(
         EM_MILLPOST_WORD) ";\n"
                           "                     default: speed; class is of the last contact, by "
                           "the collision table",
     EM_MILLPOST_OTHER, AT(by), NULL, 0, read_by},
    {"color", "WHAT", NULL, EM_MILLPOST_OTHER, AT(by), NULL, 0, read_by},
    {"map", "NAME", "one of:" EM_COLOUR_LIST(EM_MILLPOST_WORD) "; default: lagoon",
     EM_MILLPOST_OTHER, AT(map), NULL, 0, read_map},
    {"scale", "LOW:HIGH", "ends of the colour scale; default: 0 to 110 % of the tip speed",
     EM_MILLPOST_OTHER, AT(low), NULL, 0, em_millpost_line_range},
    {"speeds", "LOW:HIGH", "only balls as fast as this, in m/s", EM_MILLPOST_OTHER, AT(show_low),
     NULL, 0, em_millpost_line_range},
    OPTION("balls", "N", "no more than N balls", WHOLE, balls),
    {"hide", "WHAT,...", "any of:" EM_MILLPOST_HIDDEN_LIST(HIDDEN_WORD), EM_MILLPOST_OTHER,
     AT(hide), NULL, 0, read_hide},
    {"trail", "BALL,...", "these balls (numbers from 0) draw a trail", EM_MILLPOST_OTHER, AT(show),
     NULL, 0, read_trail},
    OPTION("trail-time", "T", "how long a trail is, in seconds; default: 0.05", POSITIVE,
           show.trail_time),
    OPTION("marks", "T",
           "mark the collisions of the last T seconds, at most 4000 (needs a collision\n"
           "                     table)",
           POSITIVE, show.mark_time),
    OPTION("smooth", "N", "samples per pixel each way, 1 to 4; default: 2 for frames, 1 for film",
           WHOLE, smooth),
    OPTION("dark", NULL, "on a dark ground", FLAG, dark),
    OPTION("workers", "N", "processes that draw; default: one per core", WHOLE, workers),
    {"quality", "Q", "H.264's rate factor, 1 (best) to 51; default: 20", EM_MILLPOST_OTHER,
     AT(quality), NULL, 0, read_quality},
    OPTION("output", "FILE", "-o FILE: what to write; default: the run's name, in this folder",
           TEXT, out),
};

#define BOTH                                                                               \
  "camera", "turn", "tilt", "zoom", "parallel", "size", "colour", "color", "map", "scale", \
      "speeds", "balls", "hide", "trail", "trail-time", "marks", "smooth", "dark", "output"
static const char *const frame_options[] = {"at", "triple", BOTH, ""};
static const char *const film_options[] = {"from",    "to",      "fps", "slow", "orbit",
                                           "workers", "quality", BOTH,  ""};

#define PATHS                                                                              \
  "Between stored frames, balls move on exact paths when the run has a collision table,\n" \
  "else on smooth curves."

static const struct em_millpost_help frame_help = {
    .name = "frame",
    .arguments = "RUN [--at T] [-o FILE.png]",
    .summary = "Draws a picture of a moment of a run.",
    .details = PATHS,
    .examples = "  millpost frame run.h5 --at 0.25\n"
                "  millpost frame run.h5 --camera axial --speeds 3:9 -o fast-balls.png\n"
                "  millpost frame run.h5 --at 0.2 --trail 17,256 --hide balls --dark\n"
                "  millpost frame run.h5 --at 0.2 --triple 0.002 --camera axial -o triple.png",
    .options = frame_options,
    .least = 1,
    .most = 1,
};

static const struct em_millpost_help film_help = {
    .name = "film",
    .arguments = "RUN [--fps N] [-o FILE.mp4]",
    .summary = "Makes a film of a run (H.264, plays everywhere).",
    .details = PATHS,
    .examples = "  millpost film run.h5\n"
                "  millpost film run.h5 --slow 40 --orbit 10 -o mill.mp4\n"
                "  millpost film run.h5 --camera axial --from 0.2 --to 0.4 --size 1920x1080",
    .options = film_options,
    .least = 1,
    .most = 1,
};

int em_millpost_look_read(struct em_millpost_look *look, enum em_millpost_kind kind, int argc,
                          char **argv) {
  const struct em_millpost_line line = {options, sizeof options / sizeof *options, AT(quiet)};
  const struct em_millpost_help *help = kind == EM_LOOK_FRAME ? &frame_help : &film_help;
  int words;
  char **word;
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
  const int code = em_millpost_line_read(look, &line, help, argc, argv, &words, &word);
  if (code >= 0) return code;
  look->run = word[0];
  if (isfinite(look->triple) && (look->by == EM_PICTURE_CLASS || look->by == EM_PICTURE_SPECIES))
    return em_millpost_usage(help->name, "--triple uses up the colours: --colour %s cannot be seen",
                             em_picture_name((enum em_picture_by)look->by));
  look->show.classes = look->by == EM_PICTURE_CLASS;
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
  if (look->smooth > 0) o.smooth = (int)look->smooth;
  o.hide_rotor = look->hide.rotor;
  o.hide_drum = look->hide.drum;
  o.hide_balls = look->hide.balls;
  o.hide_legend = look->hide.legend;
  o.histogram = !look->hide.histogram;
  o.dark = look->dark;
  o.marked = look->show.mark_time;
  return o;
}
