/* Tables of numbers: what component/tables.py looks up, for one number or as many as a register holds. */

#ifndef TABLES_H
#define TABLES_H

#include "real.h"

/* The entry `offset` behind the place `at`, an integer within the array. */
static inline real gc_entry(const double *array, real at, int offset) {
    real result = gc_real(0.0);
    for (int lane = 0; lane < LANES; lane++) gc_set_lane(&result, lane, array[(int64_t)gc_lane(at, lane) + offset]);
    return result;
}

/* The interval of n rising points in which x lies: 0 to n - 2, those at the ends for what is beyond them, the last for NaN. */
static inline real gc_interval(const double *points, int n, real x) {
    real result = gc_real(0.0);
    for (int lane = 0; lane < LANES; lane++) {
        const double at = gc_lane(x, lane);
        int low = 0, high = n - 1;
        while (high - low > 1) {
            const int middle = (low + high) / 2;
            if (at < points[middle]) high = middle;
            else low = middle;
        }
        gc_set_lane(&result, lane, (double)low);
    }
    return result;
}

#endif
