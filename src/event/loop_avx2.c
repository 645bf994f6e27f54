/* The loop for processors with AVX2. */
#include "event/loop_ahead.h"
#include "event/loop_parts.h"

#define LOOP_LANES 4
#include "event/loop_variants.h"

const struct em_loop_kind *em_loop_avx2_find(unsigned flags) {
  return find(flags);
}
