/* The functions that models call, for every platform the same bits.

   Only + - * / and sqrt, which IEEE 754 rounds exactly, and operations on bits; no library of mathematics, no fused operation,
   no table. The same source serves one run and several in the lanes of a vector (real.h). Subnormal numbers count as any others,
   special values are those of C99's Annex F, truth values 1.0 and 0.0. How exact each function is stands in docs/mathematics.md;
   polynomials.h is computed by polynomials.py.

   What an SX graph of CasADi can hold is complete but for erfinv, and for printme, which has no value of its own:
     + - * / and what is made of them (negation, square, twice, inverse, lift), lt le eq ne and or not, if_else_zero,
     floor ceil fabs sign copysign fmin fmax fmod remainder hypot sqrt pow (constpow) exp expm1 log log1p
     sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh erf.
   Of the functions that one can call, those by which component/tables.py looks up numbers. */

#ifndef MATHEMATICS_H
#define MATHEMATICS_H

#include "arcs.h"
#include "error_function.h"
#include "exponentials.h"
#include "real.h"
#include "remainders.h"
#include "tables.h"
#include "trigonometry.h"

#endif
