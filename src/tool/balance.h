/* The energy balance of a run: what blades and drum put in, what is stored, what contacts
 * dissipate. */
#ifndef EVENTMILL_BALANCE_H
#define EVENTMILL_BALANCE_H

#include <stdbool.h>

#include "eventmill/contact.h"
#include "eventmill/interval.h"
#include "tool/trace.h"
#include "tool/window.h"

struct em_balance {
  double time;                              /* s between the first and the last sample */
  struct em_trace work, impulse, drum;      /* per blade: J, N m s; drum: J */
  struct em_trace lost, impact;             /* per class: J dissipated, J of Σ ½ m_eff v_n² */
  struct em_trace kinetic, spin, potential; /* J */
  double *omega;                            /* rad/s per blade */
  bool falls; /* gravity pulls balls across a periodic boundary: what is stored has no meaning */
  size_t blades;
};

/* Reads the observables of the window. Errors: EM_INPUT (fewer than 2 samples), EM_MEMORY, and
 * those of reading. */
enum em_status em_balance_new(struct em_balance *balance, const struct em_run_file *run,
                              const struct em_window *window, struct em_error *err);
void em_balance_free(struct em_balance *balance);

/* Mean power (W) of the blades over the window, in three ways that must agree: work done in the
 * contacts; torque times speed, Σ ω ΔL/Δt; energy balance, (ΔE + dissipated − work of the drum)/Δt
 * (NAN where potential energy has no meaning). */
double em_balance_by_work(const struct em_balance *balance);
double em_balance_by_torque(const struct em_balance *balance);
double em_balance_by_energy(const struct em_balance *balance);

/* Largest difference between the three, relative to the largest of the energies that took part. */
double em_balance_mismatch(const struct em_balance *balance);

double em_balance_stored(const struct em_balance *balance);     /* W, growth of the energy */
double em_balance_dissipated(const struct em_balance *balance); /* W, all classes */

/* Power between the samples k and k + 1 by torque, by energy; and what is dissipated there. */
double em_balance_torque_at(const struct em_balance *balance, size_t k);
double em_balance_energy_at(const struct em_balance *balance, size_t k);
double em_balance_dissipated_at(const struct em_balance *balance, size_t k);
double em_balance_drum_at(const struct em_balance *balance, size_t k); /* the drum's, by work */

#endif
