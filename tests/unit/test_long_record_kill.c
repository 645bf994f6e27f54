/* test_record_kill.c at every single call. */
#define EVERY_CALL
#include "test_record_kill.c"
