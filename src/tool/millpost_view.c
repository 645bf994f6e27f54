/* millpost view: a run as one HTML file that plays it in a browser. */
#include <math.h>
#include <stdio.h>

#include "eventmill/run_file.h"
#include "eventmill/view.h"
#include "tool/millpost.h"

struct wish {
  struct em_view_options view;
  const char *out;
  long balls;       /* 0: not said */
  double megabytes; /* 0: not said */
  bool quiet;
};

#define OPTION(key, argument, help, target, field) \
  EM_MILLPOST_OPTION(struct wish, key, argument, help, target, field)

/* V alone is 0:V. */
static int read_scale(void *place, const char *command, const char *option, const char *text) {
  double *low = place;
  if (!em_millpost_line_number(text, '\0', &low[1], NULL) || !(low[1] > 0.0))
    return em_millpost_line_range(place, command, option, text);
  low[0] = 0.0;
  return -1;
}

static const struct em_millpost_option options[] = {
    OPTION("from", "T", "begin at T seconds; default: the first frame", NUMBER, view.from),
    OPTION("to", "T", "end at T seconds; default: the last frame", NUMBER, view.to),
    OPTION("step", "T", "a frame every T seconds", POSITIVE, view.step),
    OPTION("balls", "N", "no more than N balls, evenly chosen", WHOLE, balls),
    OPTION("max-balls", "N", NULL, WHOLE, balls),
    OPTION("max-size", "MB", "room for the frames in the file; default: 48", POSITIVE, megabytes),
    {"scale", "LOW:HIGH", "ends of the colour scale; default: 0 to 110 % of the tip speed",
     EM_MILLPOST_OTHER, offsetof(struct wish, view.low), NULL, 0, read_scale},
    OPTION("dark", NULL, "on a dark ground", FLAG, view.dark),
    OPTION("output", "FILE", "-o FILE: what to write; default: the run's name, in this folder",
           TEXT, out),
};

static const struct em_millpost_help help = {
    .name = "view",
    .arguments = "RUN [-o FILE.html]",
    .summary = "Writes one HTML file that plays a run in a browser.",
    .details =
        "Turn and zoom with mouse or fingers, go to any time, show only some speeds, click balls\n"
        "to follow them. The file needs no network: open it, mail it, put it on a website.\n\n"
        "A run with a collision table is shown on its exact paths, at steps of 1 ms; another one\n"
        "with its stored frames and smooth curves between them. Frames are thinned when they\n"
        "would take too much room.\n\n"
        "An address can say where to begin:\n"
        "  mill.html#t=0.3&paused&turn=20&tilt=10&zoom=2&hide=drum&speeds=2:6&trail=17,256\n"
        "           &rate=50&colour=spin&dark",
    .examples = "  millpost view run.h5\n"
                "  millpost view run.h5 --from 0.3 --to 0.35 --balls 1000 -o start.html",
    .least = 1,
    .most = 1,
};

int em_millpost_view(int argc, char **argv) {
  static const struct em_millpost_line line = {options, sizeof options / sizeof *options,
                                               offsetof(struct wish, quiet)};
  struct wish wish = {.view = {.from = NAN, .to = NAN, .step = NAN, .low = NAN, .high = NAN}};
  struct em_error err = {.code = EM_OK};
  struct em_run_file *run = NULL;
  struct em_view_report report;
  char name[256], out[272];
  int words;
  char **word;
  const int code = em_millpost_line_read(&wish, &line, &help, argc, argv, &words, &word);
  if (code >= 0) return code;
  wish.view.balls = (size_t)wish.balls;
  wish.view.largest = (size_t)(fmin(wish.megabytes, 1e6) * 1024.0 * 1024.0);
  em_millpost_label(word[0], name, sizeof name);
  snprintf(out, sizeof out, "%s.html", name);
  if (wish.out == NULL) wish.out = out;
  enum em_status status = em_millpost_open(&run, word[0], &err);
  if (status == EM_OK) status = em_view_write(run, &wish.view, wish.out, &report, &err);
  if (run != NULL) em_run_file_close(run);
  if (status != EM_OK) return em_millpost_fail(&err);
  if (wish.quiet) return EM_MILLPOST_DONE;
  if (report.frames < report.wanted)
    fprintf(stderr,
            "millpost: %zu of %zu frames are kept, for the file's size; --max-size, --balls or a\n"
            "shorter time keep more\n",
            report.frames, report.wanted);
  fprintf(stderr, "%s: %zu frames of %zu balls, %.4g to %.4g s", wish.out, report.frames,
          report.balls, report.first, report.last);
  if (report.bytes > 0) fprintf(stderr, ", %.1f MB", (double)report.bytes / 1e6);
  fputc('\n', stderr);
  return EM_MILLPOST_DONE;
}
