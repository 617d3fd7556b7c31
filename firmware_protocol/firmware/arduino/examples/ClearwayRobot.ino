// A robot with two driven wheels on an Arduino Uno or Nano (ATmega328P, 16 MHz).
//
// The serial line is Clearway's: do not use Serial in this sketch. Pins (port_avr.c): left motor
// PWM on 6 and direction on 7, right motor PWM on 5 and direction on 8; encoders A and B of the
// left wheel on A0 and A1, of the right wheel on A2 and A3.
#include <Clearway.h>

// What this robot is and can do: the wheels' distance in um, then highest speed (mm/s),
// acceleration (mm/s2), acceleration in bends (mm/s2), turning (mrad/s), turn acceleration
// (mrad/s2), and how it follows: look ahead by mm and ms, hold beyond mm beside the line.
const cw_settings cw_robot_settings = {120000ul, 500, 500, 600, 2500, 8000, 40, 150, 150, 10};

void setup()
{
    cw_port_begin(0, nullptr);
    cw_program_begin();
}

void loop()
{
    cw_program_round();
    cw_port_idle();
}
