/* A run that is stuck. */
#ifndef EVENTMILL_EVENT_COLLAPSE_H
#define EVENTMILL_EVENT_COLLAPSE_H

#include "event/body.h"

/* The error of a run that is stuck on ball i and its partner at t (s within the epoch): EM_JAM
 * where the balls that touch each other there also touch both a blade and a wall, else EM_COLLAPSE.
 */
enum em_status em_collapse_report(const struct em_world *world, uint32_t i, uint32_t partner,
                                  double t, struct em_error *err);

/* Is a contact of balls so slow, v_n < 2^-30 m/s, a collapse? It is when it loses energy, the balls
 * of the world fly 1e5 times as fast and there have been several such: chance makes none of them,
 * balls that hit each other without end make dozens, until their relative speed is rounded away. */
bool em_collapse_sticks(const struct em_world *world, const struct em_contact_law *law, double vn);

/* The error of such a collapse, of balls i and j at t (s within the epoch): EM_COLLAPSE. */
enum em_status em_collapse_stuck(const struct em_world *world, uint32_t i, uint32_t j, double t,
                                 double vn, struct em_error *err);

/* The name of a partner ("ball 3", "blade 0", "the drum"). */
void em_collapse_partner(uint32_t partner, char *text, size_t room);

#endif
