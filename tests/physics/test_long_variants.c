/* The long form of test_variants.c: 10⁶ collisions of the mill. */
#define LONG_FORM
#include "test_variants.c"
