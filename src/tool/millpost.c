/* millpost: reads run files and answers questions about them. */
#include "tool/millpost.h"

#include "tool/command.h"

static const struct em_command commands[] = {
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

static const struct em_command_program program = {
    .name = "millpost",
    .usage = "COMMAND RUN [OPTION ...]",
    .about = "Reads run files of mill and answers questions about them.",
    .details =
        "'millpost COMMAND --help' tells more, with examples; 'millpost --version' what this is.\n"
        "Tables go to standard output (--csv, --json for programs), pictures to -o FILE.png.\n"
        "Exit codes: 0 done, 1 failed, 2 wrong usage or input, 3 verify: does not pass.",
    .count = sizeof commands / sizeof *commands,
    .command = commands,
};

int main(int argc, char **argv) {
  return em_command_main(&program, argc, argv);
}
