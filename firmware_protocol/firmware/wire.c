#include "wire.h"

#include <stdbool.h>
#include <string.h>

#include "fixed.h"
#include "flash.h"

/* Bit by bit, reflected: on small processors as fast as a table of half bytes, whose shifts and
 * reads take as long, and 128 bytes of flash shorter. */
uint32_t cw_crc32c(const uint8_t *data, uint16_t length, uint32_t running)
{
    uint32_t crc = ~running;
    while (length-- > 0u) {
        uint8_t bits = 8;
        crc ^= *data++;
        do {
            bool odd = ((uint8_t)crc & 1u) != 0u;
            crc >>= 1;
            if (odd) {
                crc ^= 0x82F63B78ul;
            }
        } while (--bits > 0u);
    }
    return ~crc;
}

uint16_t cw_get_u16(const uint8_t *from)
{
    uint16_t value;
    memcpy(&value, from, sizeof value);
    return value;
}

uint32_t cw_get_u32(const uint8_t *from)
{
    uint32_t value;
    memcpy(&value, from, sizeof value);
    return value;
}

uint8_t *cw_put_u16(uint8_t *to, uint16_t value)
{
    memcpy(to, &value, sizeof value);
    return to + sizeof value;
}

CW_APART uint8_t *cw_put_u32(uint8_t *to, uint32_t value)
{
    memcpy(to, &value, sizeof value);
    return to + sizeof value;
}

CW_APART uint16_t cw_angle_of(int16_t heading)
{
    return (uint16_t)cw_scale(heading, 17089); /* 32768 over 31416 */
}

int16_t cw_heading_of(uint16_t angle)
{
    return (int16_t)cw_scale((int16_t)angle, 15708);
}
