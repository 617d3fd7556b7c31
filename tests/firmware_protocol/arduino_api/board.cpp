/* The library's example AnyBoard on the stand-in of Arduino's API, with a stop button. */
#include "Arduino.h"

#include "sketch.h"

int main()
{
    StandInMotor motors[2] = {{5, 4, 2, 7, 800000.0, 250.0, 0.0, 0.0, 0},
                              {6, 8, 3, 9, 800000.0, 250.0, 0.0, 0.0, 0}};
    begin_board();
    setup();
    unsigned long before_us = micros();
    for (;;) {
        unsigned long now_us = micros();
        double seconds = static_cast<uint32_t>(now_us - before_us) * 1e-6;
        before_us = now_us;
        if (!run_board(motors, seconds, 10)) {
            return 0;
        }
        loop();
        usleep(300);
    }
}
