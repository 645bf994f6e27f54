/* The cases of test_accuracy.c in numbers. */
#define CASES 1000000
#include "test_accuracy.c"
