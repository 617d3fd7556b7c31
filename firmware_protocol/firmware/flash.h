/* Constant tables stay in flash on processors that keep data and program apart. */
#ifndef CLEARWAY_FLASH_H
#define CLEARWAY_FLASH_H

#ifdef __AVR__
#include <avr/pgmspace.h>
#define CW_IN_FLASH PROGMEM
#define CW_FLASH_WORD(address) pgm_read_dword(address)
#define CW_FLASH_BYTE(address) pgm_read_byte(address)
#else
#define CW_IN_FLASH
#define CW_FLASH_WORD(address) (*(address))
#define CW_FLASH_BYTE(address) (*(address))
#endif

#endif
