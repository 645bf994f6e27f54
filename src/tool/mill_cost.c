/* mill cost: what accuracy, effects and statistics cost in time, measured on the user's scene. */
#include "tool/mill_cost.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "tool/mill.h"

static const struct em_mill_help help = {
    .name = "cost",
    .takes = "jq",
    .text =
        "Usage: mill cost SCENE [KEY=VALUE ...] [OPTION ...]\n\n"
        "Measures on this scene what accuracy, effects and statistics cost. Runs it to its steady\n"
        "state, then every variant from there, in turns with the scene as it is. Prints tables:\n\n"
        "  accuracy against time    knobs of the group engine: computing time, error of contact\n"
        "                           times, missed and invented contacts, energy, shift of the key\n"
        "                           figures\n"
        "  effects against time     what each effect costs, and what leaving it out changes\n"
        "  statistics against time  confidence intervals against simulated time\n\n"
        "  -t, --time T        simulated time of each run, s; default: what takes about 0.3 s of\n"
        "                      computing. A longer one narrows the shifts of the key figures\n"
        "  -s, --steady T      begin of the steady state, s; default: 0.5, or half the duration\n"
        "  -n, --rounds N      turns per variant, 1 to 64; default: 4\n"
        "  -f, --flights N     flights for the errors of contact times; default: 100000\n"
        "  -k, --only TEXT     only the variants with TEXT in their names\n"
        "  -c, --csv FILE      write the tables as CSV too\n"
        "  -o, --output PREFIX draw PREFIX-accuracy.png, PREFIX-effects.png, "
        "PREFIX-statistics.png\n"
        "  -j, --json          print one JSON object\n"
        "  -q, --quiet         no progress\n"
        "  -h, --help          this text\n\n"
        "Times are those of this process on this machine; ratios are what counts. "
        "docs/accuracy.md\n"
        "tells how to read the tables.\n\n"
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

/* Returns -1 to go on, or an exit code. */
static int take(struct options *o, int letter, char **argv) {
  switch (letter) {
  case 't':
    return number(&o->time, 1e-9, 1e9, "expected a time, found");
  case 's':
    return number(&o->steady, 0.0, 1e9, "expected a time, found");
  case 'n':
    return number(&o->rounds, 1.0, EM_COST_ROUNDS, "expected 1 to 64, found");
  case 'f':
    return number(&o->flights, 0.0, 1e8, "expected a number, found");
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

static double wall_clock(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double em_mill_cost_width(const struct em_interval *figure) {
  return figure->value != 0.0 ? figure->half / fabs(figure->value) : NAN;
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
  cost->steady = isnan(o->steady) ? fmin(0.5, 0.5 * scene->duration) : o->steady;
  cost->rounds = (int)o->rounds;
  cost->only = o->only;
  cost->flights = (size_t)o->flights;
  cost->begun = wall_clock();
  cost->progress = em_progress_new(o->scene.quiet);
  enum em_status status = measure(cost, &err);
  em_progress_end(cost->progress);
  if (!status) status = em_mill_cost_report(cost, o->scene.json, o->csv, &err);
  if (!status && o->scene.out) status = em_mill_cost_draw(cost, o->scene.out, &err);
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
