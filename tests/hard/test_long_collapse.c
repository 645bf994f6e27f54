/* The long form of test_collapse.c. */
#define LONG_FORM
#include "test_collapse.c"
