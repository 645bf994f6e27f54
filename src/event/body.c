/* Storage of the balls, and the change of epoch. */
#include "event/body.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "event/partition.h"

void *em_body_array(size_t count, size_t size) {
  const size_t huge = (size_t)1 << 21;
  size_t bytes = count * size;
  if (size && bytes / size != count) return NULL;
  const size_t align = bytes >= huge ? huge : 64;
  bytes = (bytes + align - 1) / align * align;
  void *p = aligned_alloc(align, bytes ? bytes : align);
  if (!p) return NULL;
  if (align == huge) (void)madvise(p, bytes, MADV_HUGEPAGE);
  return memset(p, 0, bytes ? bytes : align);
}

bool em_body_next_epoch(struct em_world *w) {
  for (uint32_t i = 0; i < w->count; i++) {
    w->body[i].t -= w->epoch_length;
    w->plan[i].leave -= w->epoch_length;
  }
  for (uint32_t k = 0; k < w->blade_count; k++) {
    struct em_turning *b = &w->blade[k];
    b->blade.angle = fmod(b->blade.angle + b->blade.omega * w->epoch_length, 2.0 * M_PI);
    b->cos = cos(b->blade.angle);
    b->sin = sin(b->blade.angle);
    b->at = 0.0;
  }
  w->clock -= w->epoch_length;
  w->epoch++;
  w->tally.epochs++;
  if (w->partition_kind->renew && !w->partition_kind->renew(w)) return false;
  return w->loop->predict_all(w);
}
