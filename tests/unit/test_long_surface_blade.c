/* The flights of test_surface_blade.c in numbers. */
#define CASES 300000
#include "test_surface_blade.c"
