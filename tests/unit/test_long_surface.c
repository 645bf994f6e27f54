/* The cases of test_surface.c in numbers. */
#define CASES 300000
#include "test_surface.c"
