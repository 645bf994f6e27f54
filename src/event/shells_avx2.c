/* The search for near shells, for processors with AVX2. */
#include <immintrin.h>
#include <math.h>
#include <string.h>

#include "event/shells.h"

#define FIND em_shells_avx2_find
#include "event/shells_find.h"
