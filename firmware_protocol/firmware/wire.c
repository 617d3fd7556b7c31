#include "wire.h"

#include <string.h>

#include "fixed.h"
#include "flash.h"

/* The table of all bytes is the sum of two of 16 words, for a byte's lower and upper half: no
 * shifts but by whole bytes, which small processors do at once. Reflected 0x82F63B78. */
static const uint32_t lower_half[16] CW_IN_FLASH = {
    0x00000000ul, 0xF26B8303ul, 0xE13B70F7ul, 0x1350F3F4ul,
    0xC79A971Ful, 0x35F1141Cul, 0x26A1E7E8ul, 0xD4CA64EBul,
    0x8AD958CFul, 0x78B2DBCCul, 0x6BE22838ul, 0x9989AB3Bul,
    0x4D43CFD0ul, 0xBF284CD3ul, 0xAC78BF27ul, 0x5E133C24ul};
static const uint32_t upper_half[16] CW_IN_FLASH = {
    0x00000000ul, 0x105EC76Ful, 0x20BD8EDEul, 0x30E349B1ul,
    0x417B1DBCul, 0x5125DAD3ul, 0x61C69362ul, 0x7198540Dul,
    0x82F63B78ul, 0x92A8FC17ul, 0xA24BB5A6ul, 0xB21572C9ul,
    0xC38D26C4ul, 0xD3D3E1ABul, 0xE330A81Aul, 0xF36E6F75ul};

uint32_t cw_crc32c(const uint8_t *data, uint16_t length, uint32_t running)
{
    uint32_t crc = ~running;
    while (length-- > 0u) {
        uint8_t byte = (uint8_t)((uint8_t)crc ^ *data++);
        crc = crc >> 8 ^ CW_FLASH_WORD(&lower_half[byte & 0x0Fu]) ^
              CW_FLASH_WORD(&upper_half[byte >> 4]);
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

uint8_t *cw_put_u32(uint8_t *to, uint32_t value)
{
    memcpy(to, &value, sizeof value);
    return to + sizeof value;
}

int32_t cw_angle_of(int16_t heading)
{
    /* 2^32 over 20000 pi is 68356.53 */
    return cw_sum((int32_t)((uint32_t)(int32_t)heading * 68356u), heading >> 1);
}

int16_t cw_heading_of(int32_t angle)
{
    return (int16_t)((cw_scale(angle, 62832u) + 0x8000l) >> 16);
}
