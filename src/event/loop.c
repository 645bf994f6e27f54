/* The loop for any processor. */
#include "event/loop_ahead.h"
#include "event/loop_parts.h"

#define LOOP_LANES 1
#include "event/loop_variants.h"

const struct em_loop_kind *em_loop_find(unsigned flags, unsigned lanes) {
#ifdef EM_HAVE_AVX2
  if (lanes >= 8) return em_loop_avx512_find(flags);
  if (lanes >= 4) return em_loop_avx2_find(flags);
#endif
  (void)lanes;
  return find(flags);
}
