/* The long form of test_gas.c: the energy over 10⁷ collisions. */
#define LONG_FORM
#include "test_gas.c"
