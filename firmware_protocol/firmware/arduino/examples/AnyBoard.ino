// A robot with two driven wheels on any board that Arduino runs on (not Uno or Nano: their example
// is ClearwayRobot). The serial line is Clearway's: do not use Serial in this sketch.
#include <Clearway.h>

// How it is wired: for each wheel PWM, direction, encoder A (a pin that can interrupt) and B, and
// the travel in um between two edges of A. Then a wheel's speed at full PWM in mm/s, an analog pin
// with nothing on it, and a stop button to ground (CW_NO_PIN: none).
const cw_arduino_board cw_robot_board = {
    {5, 4, 2, 7, 500}, {6, 8, 3, 9, 500}, 800, A0, CW_NO_PIN};

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
