/* The search for near shells, for processors with AVX2. */
#include <math.h>
#include <string.h>

#include "event/body.h"
#include "event/pack.h"
#include "event/shells.h"
#include "event/vectors.h"

#define FIND em_shells_avx2_find
#include "event/shells_find.h"
