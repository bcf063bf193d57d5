/* The one file of the interface: the generated model, the core over it, and the faces of FMI 2.0 and FMI 3.0. The model's
   derivatives (*_derivatives.c) are compiled apart. */

#include "model.c"
#include "core.c"
#include "step.c"
#include "fmi2.c"
#include "fmi2_exchange.c"
#include "fmi3.c"
#include "fmi3_exchange.c"
