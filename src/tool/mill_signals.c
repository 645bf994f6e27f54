/* Signals to commands that take long. */
#include <stddef.h>

#include "tool/mill.h"

static volatile sig_atomic_t stop;

static void on_signal(int number) {
  stop = number;
}

const volatile sig_atomic_t *em_mill_signals(void) {
  struct sigaction action = {.sa_handler = on_signal}, old;
  sigemptyset(&action.sa_mask);
  sigaction(SIGTERM, &action, NULL);
  sigaction(SIGHUP, NULL, &old);
  if (old.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, NULL);
  action.sa_flags = (int)SA_RESETHAND;
  sigaction(SIGINT, &action, NULL);
  return &stop;
}
