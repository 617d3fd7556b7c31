/* The program for boards without a framework of their own. */
#include "port.h"
#include "program.h"

const cw_settings cw_robot_settings = CW_SETTINGS;

int main(int argc, char **argv)
{
    if (!cw_port_begin(argc, argv)) {
        return 2;
    }
    cw_program_begin();
    do {
        cw_program_round();
    } while (cw_port_idle());
    return 0;
}
