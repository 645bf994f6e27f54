/* The long form of test_extremes.c. */
#define LONG_FORM
#include "test_extremes.c"
