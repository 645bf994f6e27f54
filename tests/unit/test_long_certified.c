/* The cases of test_certified.c in numbers. */
#define CASES 1000000
#include "test_certified.c"
