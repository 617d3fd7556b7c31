#include "wire.h"

#ifdef __AVR__
#include <avr/pgmspace.h>
#define TABLE_WORD(i) pgm_read_dword(&nibble_table[i])
#define IN_FLASH PROGMEM
#else
#define TABLE_WORD(i) (nibble_table[i])
#define IN_FLASH
#endif

/* 16 words instead of 256: two steps a byte, 64 bytes of flash. Reflected 0x82F63B78. */
static const uint32_t nibble_table[16] IN_FLASH = {
    0x00000000ul, 0x105EC76Ful, 0x20BD8EDEul, 0x30E349B1ul, 0x417B1DBCul, 0x5125DAD3ul,
    0x61C69362ul, 0x7198540Dul, 0x82F63B78ul, 0x92A8FC17ul, 0xA24BB5A6ul, 0xB21572C9ul,
    0xC38D26C4ul, 0xD3D3E1ABul, 0xE330A81Aul, 0xF36E6F75ul};

uint32_t cw_crc32c(const uint8_t *data, uint16_t length, uint32_t running)
{
    uint32_t crc = ~running;
    while (length-- > 0u) {
        crc ^= *data++;
        crc = (crc >> 4) ^ TABLE_WORD(crc & 0x0Fu);
        crc = (crc >> 4) ^ TABLE_WORD(crc & 0x0Fu);
    }
    return ~crc;
}

uint16_t cw_get_u16(const uint8_t *from)
{
    return (uint16_t)(from[0] | (uint16_t)((uint16_t)from[1] << 8));
}

uint32_t cw_get_u32(const uint8_t *from)
{
    return (uint32_t)cw_get_u16(from) | (uint32_t)cw_get_u16(from + 2) << 16;
}

uint8_t *cw_put_u16(uint8_t *to, uint16_t value)
{
    to[0] = (uint8_t)(value & 0xFFu);
    to[1] = (uint8_t)(value >> 8);
    return to + 2;
}

uint8_t *cw_put_u32(uint8_t *to, uint32_t value)
{
    return cw_put_u16(cw_put_u16(to, (uint16_t)(value & 0xFFFFu)), (uint16_t)(value >> 16));
}
