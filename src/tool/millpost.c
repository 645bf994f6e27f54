/* millpost: reads run files and answers questions about them. */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_version.h>
#include <hdf5.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "tool/millpost.h"
#include "version.h"

struct command {
  const char *name, *summary;
  int (*run)(int argc, char **argv);
};

static const struct command commands[] = {
    {"info", "provenance, scene, effects, counts", em_millpost_info},
    {"hist", "how often and how hard: distributions, quartiles, rates", em_millpost_hist},
    {"map", "where: sectors or rings of the drum", em_millpost_map},
    {"verify", "the laws of an ideal gas, by χ² and Kolmogorov-Smirnov", em_millpost_verify},
    {"power", "torque, energy balance, dissipation per class", em_millpost_power},
    {"steady", "from when on a run is stationary", em_millpost_steady},
    {"compare", "runs side by side, and what differs significantly", em_millpost_compare},
    {"scale", "which speed gives the same impacts", em_millpost_scale},
    {"table", "key figures of all runs of a sweep", em_millpost_table},
    {"fit", "laws of restitution fitted to measured pairs", em_millpost_fit},
    {"track", "restitution from films of a ball that hits a plate", em_millpost_track},
    {"frame", "a picture of one moment", em_millpost_frame},
    {"film", "a film", em_millpost_film},
    {"view", "a page that plays a run in a browser", em_millpost_view},
    {"export", "files for ParaView, OVITO, POV-Ray and others", em_millpost_export},
};

enum { COMMANDS = sizeof commands / sizeof *commands };

static void print_help(FILE *out) {
  fprintf(out, "Usage: millpost COMMAND RUN [OPTION ...]\n\n"
               "Reads run files of mill and answers questions about them.\n\nCommands:\n");
  for (int k = 0; k < COMMANDS; k++)
    fprintf(out, "  %-8s %s\n", commands[k].name, commands[k].summary);
  fprintf(out,
          "\n'millpost COMMAND --help' tells more, with examples. Tables go to standard output\n"
          "(--csv, --json for programs), pictures to -o FILE.png.\n"
          "Exit codes: 0 done, 1 failed, 2 wrong usage or input, 3 verify: does not pass.\n");
}

static void print_version(void) {
  unsigned major, minor, release;
  H5get_libversion(&major, &minor, &release);
  printf("millpost (Eventmill) %s (%s)\n%s\nGSL %s, HDF5 %u.%u.%u\n", EM_VERSION, EM_VERSION_GIT,
         EM_VERSION_COMPILER, gsl_version, major, minor, release);
}

int main(int argc, char **argv) {
  gsl_set_error_handler_off(); /* statuses are checked where they are returned */
  signal(SIGXFSZ, SIG_IGN);    /* so that a limit is an error of writing, and tidied up after */
  if (argc < 2) {
    print_help(stderr);
    return EM_MILLPOST_USAGE;
  }
  if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
    print_help(stdout);
    return EM_MILLPOST_DONE;
  }
  if (strcmp(argv[1], "--version") == 0) {
    print_version();
    return EM_MILLPOST_DONE;
  }
  for (int k = 0; k < COMMANDS; k++)
    if (strcmp(argv[1], commands[k].name) == 0) return commands[k].run(argc - 1, argv + 1);
  fprintf(stderr, "millpost: error: unknown command '%s'\nTry 'millpost --help'.\n", argv[1]);
  return EM_MILLPOST_USAGE;
}
