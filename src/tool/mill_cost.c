/* mill cost: what accuracy, effects and statistics cost in time, measured on the user's scene. */
#include "tool/mill_cost.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "scene/scene_source.h"
#include "tool/mill.h"

static const struct em_mill_help help = {
    .name = "cost",
    .text =
        "Usage: mill cost SCENE [KEY=VALUE ...] [OPTION ...]\n\n"
        "Measures on this scene what accuracy, effects and statistics cost. Runs it to its steady\n"
        "state; from there every variant settles into its own, and runs in turns with the scene "
        "as\n"
        "it is. Takes some minutes. Prints tables:\n\n"
        "  accuracy against time    knobs of the group engine: computing time, error of contact\n"
        "                           times, missed and invented contacts, energy, shift of the key\n"
        "                           figures\n"
        "  effects against time     what each effect costs, and what leaving it out changes\n"
        "  recording against time   what writing a run file costs, by what it records\n"
        "  statistics against time  confidence intervals against simulated time, and what one per\n"
        "                           cent takes\n\n"
        "  -t, --time T        simulated time of each turn, s; default: what takes about 0.3 s of\n"
        "                      computing. Figures are taken over four times as long (default: "
        "about\n"
        "                      4 s of computing); a longer time narrows their shifts\n"
        "  -s, --steady T      begin of the steady state, s, and how long each variant settles "
        "from\n"
        "                      there into its own; default: 0.5, or half the duration\n"
        "  -n, --rounds N      turns per variant, 1 to 64, thrice as many of runs that record;\n"
        "                      default: 4\n"
        "  -f, --flights N     flights for the errors of contact times; default: 100000\n"
        "  -k, --only TEXT     only the variants with TEXT in their names\n"
        "  -c, --csv FILE      write the tables as CSV too\n"
        "  -o, --output PREFIX draw PREFIX-accuracy.png, PREFIX-effects.png,\n"
        "                      PREFIX-recording.png, PREFIX-statistics.png\n"
        "  -j, --json          print one JSON object\n"
        "  -q, --quiet         no progress\n"
        "  -h, --help          this text\n\n"
        "Times are those of this process on this machine; ratios are what counts.\n"
        "docs/accuracy.md tells how to read the tables. Ctrl-C ends it with what is measured so\n"
        "far (exit code 1). Runs that record go to TMPDIR, or /tmp.\n\n"
        "Examples:\n"
        "  mill cost geometries/simoloyer-2l.cfg\n"
        "  mill cost geometries/simoloyer-2l.cfg --only quartic --rounds 8\n"
        "  mill cost geometries/simoloyer-2l.cfg rotor.rpm=1700 --time 0.2 --csv cost.csv -o "
        "cost\n",
};

static const struct option known[] = {
    {"time", required_argument, NULL, 't'},
    {"steady", required_argument, NULL, 's'},
    {"rounds", required_argument, NULL, 'n'},
    {"flights", required_argument, NULL, 'f'},
    {"only", required_argument, NULL, 'k'},
    {"csv", required_argument, NULL, 'c'},
    {"output", required_argument, NULL, 'o'},
    {"json", no_argument, NULL, 'j'},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

static const char letters[] = ":t:s:n:f:k:c:o:jqh";

struct options {
  struct em_mill_options scene;
  double time, steady, rounds, flights;
  const char *csv, *only;
};

/* Returns -1 to go on, or an exit code. */
static int number(double *value, double low, double high, const char *expected) {
  char *end;
  *value = strtod(optarg, &end);
  if (end != optarg && *end == '\0' && *value >= low && *value <= high) return -1;
  return em_mill_usage(&help, expected, optarg);
}

static int whole(double *value, double low, double high, const char *expected) {
  const int code = number(value, low, high, expected);
  return code >= 0 || *value == floor(*value) ? code : em_mill_usage(&help, expected, optarg);
}

/* Returns -1 to go on, or an exit code. */
static int take(struct options *o, int letter, char **argv) {
  switch (letter) {
  case 't':
    return number(&o->time, 1e-9, 1e9, "expected a time, found");
  case 's':
    return number(&o->steady, 0.0, 1e9, "expected a time, found");
  case 'n':
    return whole(&o->rounds, 1.0, EM_COST_ROUNDS, "expected a whole number from 1 to 64, found");
  case 'f':
    return whole(&o->flights, 0.0, 1e8, "expected a whole number from 0 to 1e8, found");
  case 'k':
    o->only = optarg;
    return -1;
  case 'c':
    o->csv = optarg;
    return -1;
  case 'o':
    o->scene.out = optarg;
    return -1;
  case 'j':
    o->scene.json = true;
    return -1;
  case 'q':
    o->scene.quiet = true;
    return -1;
  case 'h':
    fputs(help.text, stdout);
    return EM_MILL_DONE;
  case ':':
    return em_mill_usage(&help, "a value is missing after", argv[optind - 1]);
  default:
    return em_mill_unknown(&help, letters, letter, NULL, argv[optind - 1]);
  }
}

static int read_options(struct options *o, int argc, char **argv) {
  *o = (struct options){.time = NAN, .steady = NAN, .rounds = 4.0, .flights = 1e5};
  opterr = 0;
  optind = 1;
  for (int letter; (letter = getopt_long(argc, argv, letters, known, NULL)) != -1;) {
    const int code = take(o, letter, argv);
    if (code >= 0) return code;
  }
  return em_mill_words(&o->scene, &help, argc - optind, argv + optind);
}

/* Relative half widths below this are rounding: the figure does not vary. */
static const double ROUNDING = 1e-12;

double em_mill_cost_width(const struct em_interval *figure) {
  if (figure->value == 0.0) return NAN;
  const double width = figure->half / fabs(figure->value);
  return width <= ROUNDING ? 0.0 : width;
}

void em_mill_cost_tell(const struct em_cost *cost, const char *what) {
  const struct em_progress_state state = {
      .fraction = cost->done, .whole = cost->done, .wall = em_progress_clock() - cost->begun};
  char text[128];
  snprintf(text, sizeof text, "%s: %s", cost->now, what);
  em_progress_show(cost->progress, &state, text);
}

/* ---------------------------------------------------------------- what can be told at once */

/* Can this file be written? It is not there afterwards when it was not before. */
static enum em_status try_file(const char *path, struct em_error *err) {
  const bool is_new = access(path, F_OK) != 0;
  FILE *file = fopen(path, "a");
  if (!file) return em_error_set(err, EM_FILE, path, 0, "cannot be written");
  fclose(file);
  if (is_new) remove(path);
  return EM_OK;
}

static enum em_status try_files(const struct options *o, struct em_error *err) {
  enum em_status status = o->csv ? try_file(o->csv, err) : EM_OK;
  for (unsigned k = 0; k < EM_COST_PICTURES && o->scene.out && !status; k++) {
    char path[EM_COST_PICTURE_PATH];
    em_mill_cost_draw_path(o->scene.out, k, path);
    status = try_file(path, err);
  }
  return status;
}

/* Does --only name a variant? */
static enum em_status try_only(struct em_cost *cost, struct em_error *err) {
  em_mill_cost_variants(cost);
  if (cost->count > 0) return EM_OK;
  const char *only = cost->only;
  char all[EM_COST_VARIANTS * 64] = "";
  cost->only = NULL;
  em_mill_cost_variants(cost);
  for (size_t k = 0; k < cost->count; k++)
    snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", k ? ", " : "",
             cost->result[k].variant.name);
  return em_error_set(err, EM_INPUT, NULL, 0,
                      "--only '%.60s' is in no variant's name, expected part of one of: %s", only,
                      all);
}

/* The scene, with messages about its own lines; from then on its text with all includes in place,
 * which a file that is changed meanwhile does not change. */
static enum em_status read_scene(struct em_cost *cost, struct em_error *err) {
  struct em_scene_source source = {0};
  enum em_status status = em_scene_source_load(&cost->text, cost->path, err);
  if (!status) status = em_mill_cost_scene_with(cost, 0, NULL, &cost->scene, err);
  if (!status) status = em_scene_source_join_whole(&source, cost->text, cost->path, err);
  if (!status) {
    free(cost->text);
    cost->text = source.text;
    source.text = NULL;
  }
  em_scene_source_free(&source);
  return status;
}

static enum em_status prepare(struct em_cost *cost, const struct options *o, struct em_error *err) {
  enum em_status status = read_scene(cost, err);
  if (status) return status;
  const double duration = cost->scene->duration;
  cost->steady = isnan(o->steady) ? fmin(0.5, 0.5 * duration) : o->steady;
  status = try_only(cost, err);
  return status ? status : try_files(o, err);
}

/* ---------------------------------------------------------------- all of it */

static enum em_status measure(struct em_cost *cost, struct em_error *err) {
  enum em_status status = em_mill_cost_run_steady(cost, err);
  if (!status) status = em_mill_cost_run_base(cost, err);
  if (status) return status;
  em_mill_cost_variants(cost);
  status = em_mill_cost_flights(cost, err);
  for (size_t k = 0; k < cost->count && !status; k++) {
    cost->now = cost->result[k].variant.name;
    cost->done = (double)(k + 1) / (double)(cost->count + 1);
    status = em_mill_cost_run_variant(cost, &cost->result[k], err);
  }
  return status;
}

static int tell_all(const struct em_cost *cost, const struct options *o, enum em_status status,
                    struct em_error *err) {
  const bool stopped = status == EM_STOPPED;
  if (cost->precision && (!status || stopped)) {
    status = em_mill_cost_report(cost, o->scene.json, o->csv, err);
    if (!status && o->scene.out) status = em_mill_cost_draw(cost, o->scene.out, err);
  }
  if (stopped) fprintf(stderr, "interrupted\n");
  if (status && status != EM_STOPPED) em_mill_complain(err);
  return status || stopped ? EM_MILL_FAILED : EM_MILL_DONE;
}

static int cost_of(struct em_cost *cost, const struct options *o) {
  struct em_error err = {0};
  enum em_status status = prepare(cost, o, &err);
  if (status) {
    em_mill_complain(&err);
    return status == EM_MEMORY ? EM_MILL_FAILED : EM_MILL_USAGE;
  }
  cost->stop = em_mill_signals();
  cost->begun = em_progress_clock();
  cost->progress = em_progress_new(o->scene.quiet);
  status = measure(cost, &err);
  em_progress_end(cost->progress);
  return tell_all(cost, o, status, &err);
}

static struct em_cost *new_cost(const struct options *o) {
  struct em_cost *cost = calloc(1, sizeof *cost);
  if (!cost) return NULL;
  cost->path = o->scene.scene;
  cost->overrides = o->scene.overrides;
  cost->override_count = o->scene.override_count;
  cost->time = o->time;
  cost->rounds = (int)o->rounds;
  cost->only = o->only;
  cost->flights = (size_t)o->flights;
  cost->now = "the scene as it is";
  return cost;
}

static void free_cost(struct em_cost *cost) {
  if (!cost) return;
  em_precision_free(cost->precision);
  em_world_snapshot_free(cost->snapshot);
  em_world_snapshot_free(cost->settled);
  em_scene_free(cost->scene);
  free(cost->text);
  free(cost);
}

int em_mill_cost(int argc, char **argv) {
  struct options o;
  int code = read_options(&o, argc, argv);
  if (code < 0) {
    struct em_cost *cost = new_cost(&o);
    code = cost ? cost_of(cost, &o) : EM_MILL_FAILED;
    free_cost(cost);
  }
  free(o.scene.overrides);
  return code;
}
