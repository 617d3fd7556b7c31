/* The library's example AnyBoard on the stand-in of Arduino's API, with a stop button.
 * The only argument is the descriptor of its serial line. */
#include "Arduino.h"

#include "sketch.h"

int main(int, char **arguments)
{
    StandInMotor motors[2] = {{5, 4, 2, 7, 800000.0, 250.0, 0.0, 0.0, 0},
                              {6, 8, 3, 9, 800000.0, 250.0, 0.0, 0.0, 0}};
    begin_board(atoi(arguments[1]));
    setup();
    while (run_board(motors, 10)) {
        loop();
    }
    return 0;
}
