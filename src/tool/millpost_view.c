/* millpost view: a run as one HTML file that plays it in a browser. */
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "eventmill/run_file.h"
#include "eventmill/view.h"
#include "tool/millpost.h"

static const char help[] =
    "Usage: millpost view RUN [-o FILE.html] [OPTION ...]\n\n"
    "Writes one HTML file that plays a run in a browser: turn and zoom with mouse or fingers, go "
    "to\n"
    "any time, show only some speeds, click balls to follow them. It needs no network: open it, "
    "mail\n"
    "it, put it on a website.\n\n"
    "A run with a collision table is shown on its exact paths, at steps of 1 ms; another one with "
    "its\n"
    "stored frames and smooth curves between them. Frames are thinned when they would take too "
    "much\n"
    "room.\n\nOptions:\n"
    "  --from T           begin at T seconds; default: the first frame\n"
    "  --to T             end at T seconds; default: the last frame\n"
    "  --step T           a frame every T seconds\n"
    "  --max-balls N      no more than N balls, evenly chosen\n"
    "  --max-size MB      room for the frames in the file; default: 48\n"
    "  --scale V          speed at the upper end of the colours, in m/s\n"
    "  --dark             on a dark ground\n"
    "  --output FILE      -o FILE: what to write; default: the run's name, in this folder\n"
    "  --quiet            no report\n"
    "  --help             print this\n\n"
    "An address can say where to begin: mill.html#t=0.3&paused&turn=20&tilt=10&zoom=2&hide=drum\n"
    "&speeds=2:6&trail=17,256&rate=50&dark\n\n"
    "Examples:\n"
    "  millpost view run.h5\n"
    "  millpost view run.h5 --from 0.3 --to 0.35 --max-balls 1000 -o start.html\n";

static const struct option options[] = {
    {"from", required_argument, NULL, 'f'},
    {"to", required_argument, NULL, 't'},
    {"step", required_argument, NULL, 's'},
    {"max-balls", required_argument, NULL, 'b'},
    {"max-size", required_argument, NULL, 'm'},
    {"scale", required_argument, NULL, 'c'},
    {"dark", no_argument, NULL, 'd'},
    {"output", required_argument, NULL, 'o'},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

struct wish {
  struct em_view_options view;
  const char *run, *out;
  bool quiet;
};

/* A number that is at least (above: more than) `least`. */
static int read_number(const char *name, const char *text, double least, bool above,
                       double *value) {
  char *end;
  *value = strtod(text, &end);
  if (end == text || *end != '\0' || !isfinite(*value))
    return em_millpost_usage("view", "--%s: '%s' is not a number", name, text);
  if (*value < least || (above && *value <= least))
    return em_millpost_usage("view", "--%s: %s is not %s %g", name, text,
                             above ? "above" : "at least", least);
  return -1;
}

static int store(struct wish *wish, int option, const char *text) {
  double value;
  int code = -1;
  switch (option) {
  case 'f':
    return read_number("from", text, -INFINITY, false, &wish->view.from);
  case 't':
    return read_number("to", text, -INFINITY, false, &wish->view.to);
  case 's':
    return read_number("step", text, 0.0, true, &wish->view.step);
  case 'c':
    return read_number("scale", text, 0.0, true, &wish->view.scale);
  case 'b':
    code = read_number("max-balls", text, 1.0, false, &value);
    if (code < 0) wish->view.balls = (size_t)fmin(value, 1e9);
    return code;
  case 'm':
    code = read_number("max-size", text, 0.0, true, &value);
    if (code < 0) wish->view.largest = (size_t)(fmin(value, 1e6) * 1024.0 * 1024.0);
    return code;
  case 'd':
    wish->view.dark = true;
    return -1;
  case 'o':
    wish->out = text;
    return -1;
  default:
    wish->quiet = true;
    return -1;
  }
}

static int read_command_line(struct wish *wish, int argc, char **argv) {
  *wish = (struct wish){.view = {.from = NAN, .to = NAN, .step = NAN, .scale = NAN}};
  opterr = 0;
  optind = 0; /* glibc: start afresh */
  for (int c; (c = getopt_long(argc, argv, ":ho:", options, NULL)) != -1;) {
    const char *asked = optind > 0 ? argv[optind - 1] : "";
    if (c == 'h') {
      fputs(help, stdout);
      return EM_MILLPOST_DONE;
    }
    if (c == ':') return em_millpost_usage("view", "'%s' needs a value", asked);
    if (c == '?') return em_millpost_usage("view", "unknown option '%s'", asked);
    const int code = store(wish, c, optarg);
    if (code >= 0) return code;
  }
  if (optind == argc) return em_millpost_usage("view", "expected RUN, a run file");
  if (optind + 1 < argc)
    return em_millpost_usage("view", "unexpected argument '%s'", argv[optind + 1]);
  wish->run = argv[optind];
  return -1;
}

int em_millpost_view(int argc, char **argv) {
  struct wish wish;
  struct em_error err = {.code = EM_OK};
  struct em_run_file *run = NULL;
  struct em_view_report report;
  char name[256], out[272];
  const int code = read_command_line(&wish, argc, argv);
  if (code >= 0) return code;
  em_millpost_label(wish.run, name, sizeof name);
  snprintf(out, sizeof out, "%s.html", name);
  if (wish.out == NULL) wish.out = out;
  enum em_status status = em_run_file_open(&run, wish.run, &err);
  if (status == EM_OK) status = em_view_write(run, &wish.view, wish.out, &report, &err);
  if (run != NULL) em_run_file_close(run);
  if (status != EM_OK) return em_millpost_fail(&err);
  if (wish.quiet) return EM_MILLPOST_DONE;
  if (report.frames < report.wanted)
    fprintf(stderr,
            "millpost: %zu of %zu frames are kept, for the file's size; --max-size, --max-balls or "
            "a\nshorter time keep more\n",
            report.frames, report.wanted);
  fprintf(stderr, "%s: %zu frames of %zu balls, %.4g to %.4g s, %.1f MB\n", wish.out, report.frames,
          report.balls, report.first, report.last, (double)report.bytes / 1e6);
  return EM_MILLPOST_DONE;
}
