/* The loop for any processor. */
#include "event/loop_parts.h"

#define LOOP_AVX2 false
#include "event/loop_variants.h"

/* A rotor always comes with the remedies compiled in. */
const struct em_loop_kind *em_loop_find(unsigned flags, bool avx2) {
  if (flags & EM_LOOP_ROTOR) flags |= EM_LOOP_EXTRA;
#ifdef EM_HAVE_AVX2
  if (avx2) return em_loop_avx2_find(flags);
#endif
  (void)avx2;
  return find(flags);
}
