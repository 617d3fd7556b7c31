/* Constant tables stay in flash on processors that keep data and program apart. */
#ifndef CLEARWAY_FLASH_H
#define CLEARWAY_FLASH_H

/* Lets the compiler forget what a pointer points to: on AVR an access by pointer takes half the
 * flash of one by address, but a compiler that knows the address prefers it. */
#ifdef __AVR__
#define CW_FORGET(pointer) __asm__("" : "+r"(pointer))
#else
#define CW_FORGET(pointer) ((void)(pointer))
#endif

/* A function to be called and not copied into its callers: which of them need it to save flash was
 * found by trying, with `make avr`. */
#ifdef __AVR__
#define CW_APART __attribute__((noinline))
#else
#define CW_APART
#endif

#ifdef __AVR__
#include <avr/pgmspace.h>
#define CW_IN_FLASH PROGMEM
#define CW_FLASH_WORD(address) pgm_read_dword(address)
#define CW_FLASH_SHORT(address) pgm_read_word(address)
#define CW_FLASH_BYTE(address) pgm_read_byte(address)
#else
#define CW_IN_FLASH
#define CW_FLASH_WORD(address) (*(address))
#define CW_FLASH_SHORT(address) (*(address))
#define CW_FLASH_BYTE(address) (*(address))
#endif

#endif
