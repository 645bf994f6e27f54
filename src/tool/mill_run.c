/* mill run: runs a scene and writes a run file. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tool/mill.h"
#include "tool/progress.h"

static const int options_taken[] = {'o', 'q', 'j', EM_MILL_RESUME, EM_MILL_FORCE, EM_MILL_PRECISION,
                                    0};

static const struct em_mill_help help = {
    .name = "run",
    .takes = options_taken,
    .text =
        "Usage: mill run SCENE [KEY=VALUE ...] [-o RUN.h5] [OPTION ...]\n\n"
        "Runs a scene and writes a run file (HDF5). Prints a summary at the end.\n\n"
        "  -o, --output RUN.h5  the run file; default: the scene's name with .h5, in the current\n"
        "                       folder. '-o none' writes no file\n"
        "      --resume         go on from the checkpoint in the run file, bit for bit as if\n"
        "                       nothing had happened; a longer duration extends a finished run; a\n"
        "                       file that is not there yet is begun\n"
        "      --force          replace a run file that exists; without it, that is an error. The\n"
        "                       old one stays until the new one is complete enough to be resumed\n"
        "      --until-precision FIGURE=PRECISION[,...]\n"
        "                       stop as soon as the confidence intervals (95 %) of these figures,\n"
        "                       over the steady part, are narrow enough: 'rate(vn>3)=1%',\n"
        "                       median(speed), median(vn), power. The duration stays the upper\n"
        "                       bound. Judged from 32 blocks of record.histograms on, four times\n"
        "                       while their number doubles; the median speed and the power need\n"
        "                       record.observables at least as often\n"
        "  -j, --json           print the summary as one JSON object, SI units; half widths of\n"
        "                       intervals in ci95\n"
        "  -q, --quiet          no progress\n"
        "  -h, --help           this text\n\n"
        "The run file is valid at every moment, whatever happens to the program. Ctrl-C ends the\n"
        "run with a checkpoint (exit code 1); a second one ends it at once. While it runs, a\n"
        "second copy RUN.h5.next and a lock RUN.h5.lock lie beside it; they can be deleted after\n"
        "a crash. One program at a time works on a run file.\n\n"
        "Examples:\n"
        "  mill run geometries/simoloyer-2l.cfg\n"
        "  mill run geometries/simoloyer-2l.cfg rotor.rpm=1700 duration=0.2 -o fast.h5\n"
        "  mill run geometries/simoloyer-2l.cfg rotor.rpm=1700 duration=0.5 -o fast.h5 --resume\n"
        "  mill run geometries/ideal-gas.cfg record.collisions=true --force\n"
        "  mill run geometries/simoloyer-2l.cfg duration=60 --until-precision 'rate(vn>3)=1%'\n"
        "  mill run geometries/ideal-gas.cfg -o none --json | jq .collisions_per_second\n",
};

/* Frames, samples or blocks, of which a user may not know. */
static const double MANY = 1e6;

/* 97 k, 1.04 M. */
static void per_second(double rate, char *text, size_t size) {
  if (rate < 1e3)
    snprintf(text, size, "%.0f", rate);
  else if (rate < 1e6)
    snprintf(text, size, "%.0f k", 1e-3 * rate);
  else
    snprintf(text, size, "%.2f M", 1e-6 * rate);
}

static void show(void *self, const struct em_recorder_progress *now) {
  const double span = now->duration - now->from, done = now->time - now->from;
  const struct em_progress_state state = {
      .fraction = span > 0.0 ? done / span : 1.0,
      .whole = now->duration > 0.0 ? now->time / now->duration : 1.0,
      .wall = now->wall,
  };
  char text[128], rate[32];
  per_second(now->wall > 0.0 ? (double)(now->collisions - now->at_begin) / now->wall : 0.0, rate,
             sizeof rate);
  snprintf(text, sizeof text, "%.4g/%.4g s  %s coll/s  %.2g x real time", now->time, now->duration,
           rate, now->wall > 0.0 ? done / now->wall : 0.0);
  em_progress_show(self, &state, text);
}

/* The command line as one text, for the provenance. */
static char *join(int argc, char **argv) {
  size_t size = sizeof "mill";
  for (int i = 0; i < argc; i++)
    size += strlen(argv[i]) + 1;
  char *text = malloc(size);
  if (!text) return NULL;
  strcpy(text, "mill");
  for (int i = 0; i < argc; i++) {
    strcat(text, " ");
    strcat(text, argv[i]);
  }
  return text;
}

/* From the last frame one can go on, unless there is none or the scene says where each ball is. */
static bool can_start_from(const struct em_scene *scene) {
  for (size_t k = 0; k < scene->species_count; k++)
    if (scene->species[k].start == EM_START_TABLE) return false;
  return scene->record.frames > 0.0;
}

static void advise(const struct em_error *err, const struct em_scene *scene, const char *path,
                   bool resumable) {
  em_mill_complain(err);
  if (path && err->code == EM_INPUT && strstr(err->text, "exists already"))
    fprintf(stderr, "use --resume or --force, or another name with -o\n");
  if (!path || !resumable) return;
  if (err->code != EM_COLLAPSE && err->code != EM_JAM) {
    fprintf(stderr, "%s is valid up to its last flush, and can be resumed with --resume\n", path);
    return;
  }
  fprintf(stderr, "%s is valid up to its last flush. To get beyond, begin anew with a remedy",
          path);
  if (can_start_from(scene))
    fprintf(stderr,
            ", or go on from its last frame with one: balls.start=run balls.from=%s -o NEW.h5",
            path);
  fprintf(stderr, "\n");
}

static int exit_code(enum em_status status, bool created) {
  if (status == EM_OK) return EM_MILL_DONE;
  const bool refused = status == EM_INPUT || status == EM_FILE || status == EM_FORMAT;
  return refused && !created ? EM_MILL_USAGE : EM_MILL_FAILED;
}

/* A figure, and how well it is known. */
static void tell_figure(const struct em_precision_target *target,
                        const struct em_precision_found *found) {
  const struct em_interval *got = &found->figure;
  const double width = got->half / fabs(got->value);
  char name[64];
  em_precision_name(target, name, sizeof name);
  fprintf(stderr, "  %-16s ", name);
  if (got->value == 0.0)
    fprintf(stderr, "none seen");
  else if (isnan(got->value))
    fprintf(stderr, "nothing seen to tell it from");
  else if (!isfinite(width))
    fprintf(stderr, "not known from so few blocks of record.histograms");
  else
    fprintf(stderr, "%.5g %s ± %.2g %%", got->value, em_precision_unit(target->kind),
            100.0 * width);
  if (width <= target->wanted && !found->reached)
    fprintf(stderr, ", from fewer than %d independent values", EM_PRECISION_LEAST);
  fprintf(stderr, " (asked for: %g %%)\n", 100.0 * target->wanted);
}

/* What was asked for, and what was reached. */
static void tell_found(const struct em_mill_precision *precision, double time) {
  bool all = true;
  for (size_t k = 0; k < precision->count; k++)
    all = all && precision->found[k].reached;
  fprintf(stderr, all ? "precision reached at %.6g s\n" : "precision not reached by %.6g s\n",
          time);
  for (size_t k = 0; k < precision->count; k++)
    tell_figure(&precision->target[k], &precision->found[k]);
}

/* What the command line asks for. Returns -1, or the exit code. */
static int read_precision(struct em_mill_precision *precision,
                          const struct em_mill_options *options) {
  struct em_error err = {0};
  precision->count = 0;
  if (!options->precision ||
      em_precision_read(precision->target, &precision->count, options->precision, &err) == EM_OK)
    return -1;
  fprintf(stderr, "mill run: --until-precision: %s\n", err.text);
  return EM_MILL_USAGE;
}

/* Rates are per simulated second, which in some scenes is next to nothing. */
static void warn_of_many(const struct em_scene *scene) {
  const struct em_recording *r = &scene->record;
  const struct {
    const char *name;
    double rate;
  } all[] = {{"frames", r->frames}, {"observables", r->observables}, {"histograms", r->histograms}};
  for (size_t k = 0; k < sizeof all / sizeof *all; k++)
    if (all[k].rate * scene->duration > MANY)
      fprintf(stderr,
              "warning: record.%s: %g a second are %.2g in all, and may take longer than the run "
              "itself\n",
              all[k].name, all[k].rate, all[k].rate * scene->duration);
}

static int run(const struct em_scene *scene, const struct em_mill_options *options,
               const char *path, char *command) {
  struct em_mill_precision precision;
  const int code = read_precision(&precision, options);
  if (code >= 0) return code;
  struct em_progress *progress = em_progress_new(options->quiet);
  const struct em_recorder_options record = {
      .path = path,
      .resume = options->resume,
      .force = options->force,
      .command = command,
      .stop = em_mill_signals(),
      .progress = options->quiet || !progress ? NULL : show,
      .self = progress,
      .target_count = precision.count,
      .target = precision.target,
      .found = precision.found,
  };
  struct em_summary summary = {0};
  struct em_error err = {0};
  bool created = false, begun = false;
  const enum em_status status = em_recorder_run(scene, &record, &summary, &created, &err);
  begun = summary.begun;
  em_progress_end(progress);
  if (status == EM_STOPPED && path && begun)
    fprintf(stderr, "interrupted at %.6g s; %s is valid and can be resumed with --resume\n",
            summary.simulated_time, path);
  else if (status)
    advise(&err, scene, path, created && begun);
  if (begun && summary.warning[0]) fprintf(stderr, "warning: %s\n", summary.warning);
  if (begun && precision.count > 0) tell_found(&precision, summary.simulated_time);
  if (begun && options->json)
    em_mill_report_json(&summary, scene, &precision);
  else if (begun && !options->quiet)
    em_mill_report_text(&summary, scene);
  return exit_code(status, created && begun);
}

/* Readers of run files take paths of this length. */
static int check_path(const char *path) {
  if (strlen(path) < EM_SCENE_PATH) return -1;
  fprintf(stderr, "%s: error: the path is too long, expected at most %d bytes\n", path,
          EM_SCENE_PATH - 1);
  return EM_MILL_USAGE;
}

/* Runs a scene that has been read. */
static int run_scene(const struct em_scene *scene, const struct em_mill_options *options,
                     char *command) {
  char name[EM_SCENE_PATH];
  em_recorder_default_path(scene, name, sizeof name);
  const char *path = options->out ? options->out : name;
  if (strcmp(path, "none") == 0 && options->out) path = NULL;
  const int code = path ? check_path(path) : -1;
  if (code >= 0) return code;
  if (!options->precision) warn_of_many(scene);
  if (!options->out && !options->quiet) fprintf(stderr, "writing %s\n", path);
  return run(scene, options, path, command);
}

int em_mill_run(int argc, char **argv) {
  struct em_mill_options options;
  struct em_scene *scene = NULL;
  char *command = join(argc, argv); /* before the options are put in order */
  int code = em_mill_options(&options, &help, argc, argv);
  if (code < 0) code = em_mill_read(&scene, &options);
  if (code < 0) code = run_scene(scene, &options, command);
  free(command);
  em_scene_free(scene);
  free(options.overrides);
  return code;
}
