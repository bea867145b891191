#include "record/integers.h"

#include <math.h>
#include <string.h>

/* ---- values and integers ---- */

int64_t ll_field_integer(const ll_record_field *f, const void *row)
{
    return ll_integer_of(f, row);
}

double ll_field_value(const ll_record_field *f, int64_t integer)
{
    if (f->coding == LL_CODE_INT)
        return (double)integer;
    if (integer == LL_INTEGER_NONE)
        return NAN;
    if (integer == LL_INTEGER_MAX || integer == -LL_INTEGER_MAX)
        return integer < 0 ? -INFINITY : INFINITY;
    if (f->coding == LL_CODE_STEP)
        return (double)integer * ll_power_of_2(-f->bits);
    uint64_t pattern = (uint64_t)(integer < 0 ? -integer : integer) << (52 - f->bits);
    double size;
    memcpy(&size, &pattern, sizeof size);
    return integer < 0 ? -size : size;
}
