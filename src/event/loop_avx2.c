/* The loop for processors with AVX2. */
#include "event/loop_parts.h"

#define LOOP_AVX2 true
#include "event/loop_variants.h"

const struct em_loop_kind *em_loop_avx2_find(unsigned flags) {
  return find(flags);
}
