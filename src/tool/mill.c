/* mill: checks and runs scenes. */
#include "tool/mill.h"

#include "tool/command.h"

static const struct em_command commands[] = {
    {"run", "run a scene and write a run file", em_mill_run},
    {"check", "validate a scene; print it in full, with what it calls for", em_mill_check},
    {"cost", "measure what accuracy, effects and statistics cost on a scene", em_mill_cost},
};

static const struct em_command_program program = {
    .name = "mill",
    .usage = "COMMAND SCENE [KEY=VALUE ...] [OPTION ...]",
    .about = "Simulates ball mills as a sequence of collisions.",
    .details = "KEY=VALUE overrides any entry of the scene: rotor.rpm=1700 balls.count=2000\n"
               "'mill COMMAND --help' tells more, with examples; 'mill --version' what this is.\n"
               "Exit codes: 0 done, 1 the run failed or was interrupted, 2 wrong usage or scene.",
    .count = sizeof commands / sizeof *commands,
    .command = commands,
};

int main(int argc, char **argv) {
  return em_command_main(&program, argc, argv);
}
