/* All variants of the loop, a template: LOOP_LANES says how many doubles they work on at a time.
 */

#define LOOP       plain
#define LOOP_NAME  "plain"
#define LOOP_FLAGS (0)
#include "event/loop_template.h"

#define LOOP       spin
#define LOOP_NAME  "spin"
#define LOOP_FLAGS (EM_LOOP_SPIN)
#include "event/loop_template.h"

#define LOOP       gravity
#define LOOP_NAME  "gravity"
#define LOOP_FLAGS (EM_LOOP_GRAVITY)
#include "event/loop_template.h"

#define LOOP       gravity_spin
#define LOOP_NAME  "gravity+spin"
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_SPIN)
#include "event/loop_template.h"

#define LOOP       remedies
#define LOOP_NAME  "remedies"
#define LOOP_FLAGS (EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       spin_remedies
#define LOOP_NAME  "spin+remedies"
#define LOOP_FLAGS (EM_LOOP_SPIN | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       gravity_remedies
#define LOOP_NAME  "gravity+remedies"
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       gravity_spin_remedies
#define LOOP_NAME  "gravity+spin+remedies"
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       periodic
#define LOOP_NAME  "periodic"
#define LOOP_FLAGS (EM_LOOP_PERIODIC)
#include "event/loop_template.h"

#define LOOP       spin_periodic
#define LOOP_NAME  "spin+periodic"
#define LOOP_FLAGS (EM_LOOP_SPIN | EM_LOOP_PERIODIC)
#include "event/loop_template.h"

#define LOOP       gravity_periodic
#define LOOP_NAME  "gravity+periodic"
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_PERIODIC)
#include "event/loop_template.h"

#define LOOP       gravity_spin_periodic
#define LOOP_NAME  "gravity+spin+periodic"
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_PERIODIC)
#include "event/loop_template.h"

#define LOOP       periodic_remedies
#define LOOP_NAME  "periodic+remedies"
#define LOOP_FLAGS (EM_LOOP_PERIODIC | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       spin_periodic_remedies
#define LOOP_NAME  "spin+periodic+remedies"
#define LOOP_FLAGS (EM_LOOP_SPIN | EM_LOOP_PERIODIC | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       gravity_periodic_remedies
#define LOOP_NAME  "gravity+periodic+remedies"
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_PERIODIC | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       gravity_spin_periodic_remedies
#define LOOP_NAME  "gravity+spin+periodic+remedies"
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_PERIODIC | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       rotor
#define LOOP_NAME  "rotor"
#define LOOP_FLAGS (EM_LOOP_ROTOR)
#include "event/loop_template.h"

#define LOOP       spin_rotor
#define LOOP_NAME  "spin+rotor"
#define LOOP_FLAGS (EM_LOOP_SPIN | EM_LOOP_ROTOR)
#include "event/loop_template.h"

#define LOOP       gravity_rotor
#define LOOP_NAME  "gravity+rotor"
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_ROTOR)
#include "event/loop_template.h"

#define LOOP       gravity_spin_rotor
#define LOOP_NAME  "gravity+spin+rotor"
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_ROTOR)
#include "event/loop_template.h"

#define LOOP       rotor_remedies
#define LOOP_NAME  "rotor+remedies"
#define LOOP_FLAGS (EM_LOOP_ROTOR | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       spin_rotor_remedies
#define LOOP_NAME  "spin+rotor+remedies"
#define LOOP_FLAGS (EM_LOOP_SPIN | EM_LOOP_ROTOR | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       gravity_rotor_remedies
#define LOOP_NAME  "gravity+rotor+remedies"
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_ROTOR | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       gravity_spin_rotor_remedies
#define LOOP_NAME  "gravity+spin+rotor+remedies"
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_ROTOR | EM_LOOP_EXTRA)
#include "event/loop_template.h"

static const struct em_loop_kind *const kinds[] = {
    &kind_plain,
    &kind_spin,
    &kind_gravity,
    &kind_gravity_spin,
    &kind_remedies,
    &kind_spin_remedies,
    &kind_gravity_remedies,
    &kind_gravity_spin_remedies,
    &kind_periodic,
    &kind_spin_periodic,
    &kind_gravity_periodic,
    &kind_gravity_spin_periodic,
    &kind_periodic_remedies,
    &kind_spin_periodic_remedies,
    &kind_gravity_periodic_remedies,
    &kind_gravity_spin_periodic_remedies,
    &kind_rotor,
    &kind_spin_rotor,
    &kind_gravity_rotor,
    &kind_gravity_spin_rotor,
    &kind_rotor_remedies,
    &kind_spin_rotor_remedies,
    &kind_gravity_rotor_remedies,
    &kind_gravity_spin_rotor_remedies,
};

static const struct em_loop_kind *find(unsigned flags) {
  for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
    if (kinds[k]->flags == flags) return kinds[k];
  return NULL;
}
