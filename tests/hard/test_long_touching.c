/* The long form of test_touching.c. */
#define LONG_FORM
#include "test_touching.c"
