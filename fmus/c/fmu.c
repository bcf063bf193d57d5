/* The file to compile: the generated model, the core that uses it, and the interfaces of FMI 2.0 and FMI 3.0. Large
   parts of the model (equations.c, *_derivatives.c) are compiled separately. */

#include "core.h"

#include "model.c"
#ifdef STEP_BY_RK4
#include "rk4.c"
#endif
#include "internal_step.c"
#include "core.c"
#include "derivatives.c"
#include "step.c"
#include "fmi2.c"
#include "fmi2_exchange.c"
#include "fmi3.c"
#include "fmi3_exchange.c"
