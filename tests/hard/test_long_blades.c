/* The long form of test_blades.c. */
#define LONG_FORM
#include "test_blades.c"
