/* All variants of the loop, a template: LOOP_LANES says how many doubles they work on at a time.
 */

#define LOOP       plain
#define LOOP_FLAGS (0)
#include "event/loop_template.h"

#define LOOP       spin
#define LOOP_FLAGS (EM_LOOP_SPIN)
#include "event/loop_template.h"

#define LOOP       gravity
#define LOOP_FLAGS (EM_LOOP_GRAVITY)
#include "event/loop_template.h"

#define LOOP       gravity_spin
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_SPIN)
#include "event/loop_template.h"

#define LOOP       remedies
#define LOOP_FLAGS (EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       spin_remedies
#define LOOP_FLAGS (EM_LOOP_SPIN | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       gravity_remedies
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       gravity_spin_remedies
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       periodic
#define LOOP_FLAGS (EM_LOOP_PERIODIC)
#include "event/loop_template.h"

#define LOOP       spin_periodic
#define LOOP_FLAGS (EM_LOOP_SPIN | EM_LOOP_PERIODIC)
#include "event/loop_template.h"

#define LOOP       gravity_periodic
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_PERIODIC)
#include "event/loop_template.h"

#define LOOP       gravity_spin_periodic
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_PERIODIC)
#include "event/loop_template.h"

#define LOOP       periodic_remedies
#define LOOP_FLAGS (EM_LOOP_PERIODIC | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       spin_periodic_remedies
#define LOOP_FLAGS (EM_LOOP_SPIN | EM_LOOP_PERIODIC | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       gravity_periodic_remedies
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_PERIODIC | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       gravity_spin_periodic_remedies
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_PERIODIC | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       rotor
#define LOOP_FLAGS (EM_LOOP_ROTOR)
#include "event/loop_template.h"

#define LOOP       spin_rotor
#define LOOP_FLAGS (EM_LOOP_SPIN | EM_LOOP_ROTOR)
#include "event/loop_template.h"

#define LOOP       gravity_rotor
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_ROTOR)
#include "event/loop_template.h"

#define LOOP       gravity_spin_rotor
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_ROTOR)
#include "event/loop_template.h"

#define LOOP       rotor_remedies
#define LOOP_FLAGS (EM_LOOP_ROTOR | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       spin_rotor_remedies
#define LOOP_FLAGS (EM_LOOP_SPIN | EM_LOOP_ROTOR | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       gravity_rotor_remedies
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_ROTOR | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define LOOP       gravity_spin_rotor_remedies
#define LOOP_FLAGS (EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_ROTOR | EM_LOOP_EXTRA)
#include "event/loop_template.h"

#define VARIANT(suffix, set, title)                                                        \
  {                                                                                        \
    .name = title, .flags = set, .lanes = LOOP_LANES, .predict_all = predict_all_##suffix, \
    .run = run_##suffix                                                                    \
  }
static const struct em_loop_kind kinds[] = {
    VARIANT(plain, 0, "plain"),
    VARIANT(spin, EM_LOOP_SPIN, "spin"),
    VARIANT(gravity, EM_LOOP_GRAVITY, "gravity"),
    VARIANT(gravity_spin, EM_LOOP_GRAVITY | EM_LOOP_SPIN, "gravity+spin"),
    VARIANT(remedies, EM_LOOP_EXTRA, "remedies"),
    VARIANT(spin_remedies, EM_LOOP_SPIN | EM_LOOP_EXTRA, "spin+remedies"),
    VARIANT(gravity_remedies, EM_LOOP_GRAVITY | EM_LOOP_EXTRA, "gravity+remedies"),
    VARIANT(gravity_spin_remedies, EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_EXTRA,
            "gravity+spin+remedies"),
    VARIANT(periodic, EM_LOOP_PERIODIC, "periodic"),
    VARIANT(spin_periodic, EM_LOOP_SPIN | EM_LOOP_PERIODIC, "spin+periodic"),
    VARIANT(gravity_periodic, EM_LOOP_GRAVITY | EM_LOOP_PERIODIC, "gravity+periodic"),
    VARIANT(gravity_spin_periodic, EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_PERIODIC,
            "gravity+spin+periodic"),
    VARIANT(periodic_remedies, EM_LOOP_PERIODIC | EM_LOOP_EXTRA, "periodic+remedies"),
    VARIANT(spin_periodic_remedies, EM_LOOP_SPIN | EM_LOOP_PERIODIC | EM_LOOP_EXTRA,
            "spin+periodic+remedies"),
    VARIANT(gravity_periodic_remedies, EM_LOOP_GRAVITY | EM_LOOP_PERIODIC | EM_LOOP_EXTRA,
            "gravity+periodic+remedies"),
    VARIANT(gravity_spin_periodic_remedies,
            EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_PERIODIC | EM_LOOP_EXTRA,
            "gravity+spin+periodic+remedies"),
    VARIANT(rotor, EM_LOOP_ROTOR, "rotor"),
    VARIANT(spin_rotor, EM_LOOP_SPIN | EM_LOOP_ROTOR, "spin+rotor"),
    VARIANT(gravity_rotor, EM_LOOP_GRAVITY | EM_LOOP_ROTOR, "gravity+rotor"),
    VARIANT(gravity_spin_rotor, EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_ROTOR,
            "gravity+spin+rotor"),
    VARIANT(rotor_remedies, EM_LOOP_ROTOR | EM_LOOP_EXTRA, "rotor+remedies"),
    VARIANT(spin_rotor_remedies, EM_LOOP_SPIN | EM_LOOP_ROTOR | EM_LOOP_EXTRA,
            "spin+rotor+remedies"),
    VARIANT(gravity_rotor_remedies, EM_LOOP_GRAVITY | EM_LOOP_ROTOR | EM_LOOP_EXTRA,
            "gravity+rotor+remedies"),
    VARIANT(gravity_spin_rotor_remedies,
            EM_LOOP_GRAVITY | EM_LOOP_SPIN | EM_LOOP_ROTOR | EM_LOOP_EXTRA,
            "gravity+spin+rotor+remedies"),
};

static const struct em_loop_kind *find(unsigned flags) {
  for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
    if (kinds[k].flags == flags) return &kinds[k];
  return NULL;
}
