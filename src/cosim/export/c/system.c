/* The file to compile: the inner loop, the coupled system around it, and the interfaces of FMI 2.0 and FMI 3.0. */

#include "system.h"

static int looks_back(const System *m);
static void prepare_loop(System *m);

#include "messages.c"
#include "carried.c"
#include "component3.c"
#include "modes3.c"
#include "components.c"
#include "outputs.c"
#include "states.c"
#include "cold.c"
#include "steps.c"
#include "derivatives.c"
#include "values.c"
#include "system_fmi2.c"
#include "system_fmi3.c"
#include "system_fmi3_more.c"
