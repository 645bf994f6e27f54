/* The long form of test_roots.c. */
#define LONG_FORM
#include "test_roots.c"
