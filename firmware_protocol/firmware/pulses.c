#include "pulses.h"

#include "fixed.h"
#include "settings.h"

#define PULSE ((int32_t)CW_LEAST_WHEEL * CW_PULSE_US)

int16_t cw_pulsed(int16_t order, int16_t driven, int32_t owed, bool ahead)
{
    int16_t least = CW_LEAST_WHEEL;
    if (order == 0 || cw_short_size(order) >= (uint16_t)least) {
        return order;
    }
    if (order < 0) {
        owed = -owed;
        driven = (int16_t)-driven;
        least = (int16_t)-least;
    }
    if (ahead) {
        owed += PULSE >> 1;
    }
    return owed >= PULSE || (driven > 0 && owed > 0) ? least : 0;
}
