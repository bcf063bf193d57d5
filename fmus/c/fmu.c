/* The one file to compile: the generated model, the core over it, and the faces of FMI 2.0 and FMI 3.0. */

#include "model.c"
#include "core.c"
#include "step.c"
#include "fmi2.c"
#include "fmi3.c"
