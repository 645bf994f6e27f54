/* The long form of test_simultaneous.c. */
#define LONG_FORM
#include "test_simultaneous.c"
