/* The long form of test_inside.c. */
#define LONG_FORM
#include "test_inside.c"
