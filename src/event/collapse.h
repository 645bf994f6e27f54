/* A run that is stuck. */
#ifndef EVENTMILL_EVENT_COLLAPSE_H
#define EVENTMILL_EVENT_COLLAPSE_H

#include "event/body.h"

/* The error of a run that is stuck on ball i and its partner at t (s within the epoch): EM_JAM
 * where the balls that touch each other there also touch both a blade and a wall, else EM_COLLAPSE.
 */
enum em_status em_collapse_report(const struct em_world *world, uint32_t i, uint32_t partner,
                                  double t, struct em_error *err);

/* The name of a partner ("ball 3", "blade 0", "the drum"). */
void em_collapse_partner(uint32_t partner, char *text, size_t room);

#endif
