/* mill cost: what accuracy, effects and statistics cost in time, measured on the user's scene. */
#include "tool/mill_cost.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "tool/mill.h"

static const char help[] =
    "Usage: mill cost SCENE [KEY=VALUE ...] [OPTION ...]\n\n"
    "Measures on this scene what accuracy, effects and statistics cost. Runs it to its steady\n"
    "state, then every variant from there, in turns with the scene as it is. Prints tables:\n\n"
    "  accuracy against time    knobs of the group engine: computing time, error of contact "
    "times,\n"
    "                           missed and invented contacts, energy, shift of the key figures\n"
    "  effects against time     what each effect costs, and what leaving it out changes\n"
    "  statistics against time  confidence intervals against simulated time\n\n"
    "  -t, --time T        simulated time of each run, s; default: about 1 s of computing\n"
    "  -s, --steady T      begin of the steady state, s; default: 0.2, or half the duration\n"
    "  -n, --rounds N      turns per variant, 1 to 64; default: 8\n"
    "  -f, --flights N     flights for the errors of contact times; default: 200000\n"
    "  -c, --csv FILE      write the tables as CSV too\n"
    "  -o, --output PREFIX draw PREFIX-accuracy.png, PREFIX-effects.png, PREFIX-statistics.png\n"
    "  -j, --json          print one JSON object\n"
    "  -q, --quiet         no progress\n"
    "  -h, --help          this text\n\n"
    "Times are those of this process on this machine; ratios are what counts. docs/accuracy.md\n"
    "tells how to read the tables.\n\n"
    "Examples:\n"
    "  mill cost geometries/simoloyer-2l.cfg\n"
    "  mill cost geometries/simoloyer-2l.cfg rotor.rpm=1700 --time 0.2 --csv cost.csv -o cost\n";

static const struct option known[] = {
    {"time", required_argument, NULL, 't'},   {"steady", required_argument, NULL, 's'},
    {"rounds", required_argument, NULL, 'n'}, {"flights", required_argument, NULL, 'f'},
    {"csv", required_argument, NULL, 'c'},    {"output", required_argument, NULL, 'o'},
    {"json", no_argument, NULL, 'j'},         {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},         {NULL, 0, NULL, 0},
};

struct options {
  struct em_mill_options scene;
  double time, steady, rounds, flights;
  const char *csv, *prefix;
  bool json, quiet;
};

static int usage(const char *what, const char *word) {
  fprintf(stderr, "mill cost: error: %s '%s'\nTry 'mill cost --help'.\n", what, word);
  return EM_MILL_USAGE;
}

static bool read_number(const char *text, double low, double high, double *value) {
  char *end;
  *value = strtod(text, &end);
  return end != text && *end == '\0' && *value >= low && *value <= high;
}

/* Returns -1 to go on, or an exit code. */
static int take(struct options *o, int letter, char **argv) {
  switch (letter) {
  case 't':
    return read_number(optarg, 1e-9, 1e9, &o->time) ? -1 : usage("expected a time, found", optarg);
  case 's':
    return read_number(optarg, 0.0, 1e9, &o->steady) ? -1 : usage("expected a time, found", optarg);
  case 'n':
    return read_number(optarg, 1.0, 64.0, &o->rounds) ? -1
                                                      : usage("expected 1 to 64, found", optarg);
  case 'f':
    return read_number(optarg, 0.0, 1e8, &o->flights) ? -1
                                                      : usage("expected a number, found", optarg);
  case 'c':
    o->csv = optarg;
    return -1;
  case 'o':
    o->prefix = optarg;
    return -1;
  case 'j':
    o->json = true;
    return -1;
  case 'q':
    o->quiet = true;
    return -1;
  case 'h':
    fputs(help, stdout);
    return EM_MILL_DONE;
  case ':':
    return usage("a value is missing after", argv[optind - 1]);
  default:
    return usage("unknown option", argv[optind - 1]);
  }
}

static int read_options(struct options *o, int argc, char **argv) {
  *o = (struct options){.time = NAN, .steady = NAN, .rounds = 8.0, .flights = 2e5};
  opterr = 0;
  optind = 1;
  int code = -1;
  for (int letter;
       code < 0 && (letter = getopt_long(argc, argv, ":t:s:n:f:c:o:jqh", known, NULL)) != -1;)
    code = take(o, letter, argv);
  if (code >= 0) return code;
  o->scene.overrides = calloc((size_t)argc + 1, sizeof *o->scene.overrides);
  if (!o->scene.overrides) return EM_MILL_FAILED;
  for (int i = optind; i < argc; i++) {
    const char *equal = strchr(argv[i], '=');
    if (!o->scene.scene)
      o->scene.scene = argv[i];
    else if (equal && equal != argv[i])
      o->scene.overrides[o->scene.override_count++] = argv[i];
    else
      return usage("expected KEY=VALUE, found", argv[i]);
  }
  return o->scene.scene ? -1 : usage("no scene given, expected", "SCENE [KEY=VALUE ...]");
}

static double wall_clock(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void em_mill_cost_tell(const struct em_cost *cost, double done, const char *what) {
  const struct em_progress_state state = {
      .fraction = done, .whole = done, .wall = wall_clock() - cost->begun};
  em_progress_show(cost->progress, &state, what);
}

static enum em_status measure(struct em_cost *cost, struct em_error *err) {
  enum em_status status = em_mill_cost_run_steady(cost, err);
  if (!status) status = em_mill_cost_run_base(cost, err);
  if (status) return status;
  em_mill_cost_variants(cost);
  status = em_mill_cost_flights(cost, err);
  for (size_t k = 0; k < cost->count && !status; k++) {
    em_mill_cost_tell(cost, (double)(k + 1) / (double)(cost->count + 1),
                      cost->result[k].variant.name);
    status = em_mill_cost_run_variant(cost, &cost->result[k], err);
  }
  return status;
}

static int cost_of(const struct options *o, struct em_scene *scene) {
  struct em_error err = {0};
  struct em_cost *cost = calloc(1, sizeof *cost);
  if (!cost) return EM_MILL_FAILED;
  cost->path = o->scene.scene;
  cost->overrides = o->scene.overrides;
  cost->override_count = o->scene.override_count;
  cost->scene = scene;
  cost->time = o->time;
  cost->steady = isnan(o->steady) ? fmin(0.2, 0.5 * scene->duration) : o->steady;
  cost->rounds = (int)o->rounds;
  cost->flights = (size_t)o->flights;
  cost->begun = wall_clock();
  cost->progress = em_progress_new(o->quiet);
  enum em_status status = measure(cost, &err);
  em_progress_end(cost->progress);
  if (!status) status = em_mill_cost_report(cost, o->json, o->csv, o->prefix, &err);
  if (status) em_mill_complain(&err);
  em_precision_free(cost->precision);
  em_world_snapshot_free(cost->snapshot);
  free(cost);
  return status ? EM_MILL_FAILED : EM_MILL_DONE;
}

int em_mill_cost(int argc, char **argv) {
  struct options o;
  struct em_scene *scene = NULL;
  int code = read_options(&o, argc, argv);
  if (code < 0) code = em_mill_scene(&scene, &o.scene);
  if (code < 0) code = cost_of(&o, scene);
  em_scene_free(scene);
  free(o.scene.overrides);
  return code;
}
