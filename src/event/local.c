/* The register of local lists. */
#include "event/local.h"

const struct em_local_kind *em_local_find(enum em_lists lists) {
  switch (lists) {
  case EM_LISTS_CALENDAR:
    return &em_local_first;
  case EM_LISTS_TREE:
  case EM_LISTS_ALL:
    return &em_local_tree;
  case EM_LISTS_COUNT:
    break;
  }
  return NULL;
}
