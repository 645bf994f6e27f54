/* The register of global lists. */
#include "event/queue.h"

const struct em_queue_kind *em_queue_find(enum em_lists lists) {
  switch (lists) {
  case EM_LISTS_CALENDAR:
  case EM_LISTS_ALL:
    return &em_queue_calendar;
  case EM_LISTS_TREE:
    return &em_queue_tree;
  case EM_LISTS_COUNT:
    break;
  }
  return NULL;
}
