/* The waypoints that wait to be executed: a ring of the 16-byte records as they came.
 *
 * A record is read in place, so the processor has to be little-endian, as the wire is. */
#ifndef CLEARWAY_QUEUE_H
#define CLEARWAY_QUEUE_H

#include <stdint.h>

#include "fixed.h"

#if defined __BYTE_ORDER__ && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "the queue reads records in place: this needs a little-endian processor"
#endif

#define CW_QUEUE_SIZE 32u

/* One waypoint as the wire has it: no padding anywhere. */
typedef struct {
    int32_t place[2]; /* um */
    int16_t heading; /* 1e-4 rad, or CW_HEADING_FREE */
    uint16_t speed_mm_s;
    uint16_t acceptance; /* 0.1 mm */
    uint8_t dwell;       /* 0.1 s */
    uint8_t flags;
} cw_waypoint;

typedef struct {
    uint8_t head;
    uint8_t count;
    cw_waypoint ring[CW_QUEUE_SIZE];
} cw_queue;

/* The waypoint `index` places behind the one to be executed next. */
static inline cw_waypoint *cw_queue_at(cw_queue *queue, uint8_t index)
{
    return &queue->ring[(uint8_t)(queue->head + index) % CW_QUEUE_SIZE];
}

/* The acceptance radius as a length of 64 um: 100 um are 25/16 of it. */
static inline uint16_t cw_radius(const cw_waypoint *at)
{
    return (uint16_t)((uint32_t)at->acceptance * 25u >> 4);
}

#endif
