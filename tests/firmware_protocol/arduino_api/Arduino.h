/* Stands in for Arduino's API on a Linux host, in one header: a board with two geared motors, their
 * encoders, a stop button and a serial port, which is a socket that the parent leaves open. Test
 * only.
 *
 * Time is the parent's: "run 1000" on stdin lets 1000 microseconds pass in rounds of ROUND_US. The
 * other lines are what hands do: "press", "release". Each line is answered by the PWM of both motors.
 * run_board() lets a round pass, the motors turn, and raises the interrupts that are due: call it
 * between two rounds of loop().
 */
#ifndef ARDUINO_STAND_IN_H
#define ARDUINO_STAND_IN_H

#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { LOW, HIGH };
enum { INPUT, OUTPUT, INPUT_PULLUP };
enum { CHANGE = 1, FALLING, RISING };
enum { A0 = 14, STAND_IN_PINS = 20 };
enum { ROUND_US = 250 };

struct StandInBoard {
    int level[STAND_IN_PINS];
    int pwm[STAND_IN_PINS];
    void (*handler[STAND_IN_PINS])();
    int edge[STAND_IN_PINS];
    bool masked;
    uint32_t now_us;
    long left_us; /* of what may pass */
    bool asked;   /* a line waits for its answer */
};

inline StandInBoard &board()
{
    static StandInBoard the_board;
    return the_board;
}

/* Of the wall's clock: no two boots are alike. */
inline uint32_t wall_us()
{
    timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<uint32_t>(now.tv_sec * 1000000 + now.tv_nsec / 1000);
}

inline unsigned long micros()
{
    return board().now_us;
}

inline void pinMode(uint8_t pin, uint8_t mode)
{
    if (mode == INPUT_PULLUP && board().handler[pin] == nullptr) {
        board().level[pin] = HIGH;
    }
}

inline int digitalRead(uint8_t pin)
{
    return board().level[pin];
}

inline void digitalWrite(uint8_t pin, uint8_t level)
{
    board().level[pin] = level;
    board().pwm[pin] = level == HIGH ? 255 : 0;
}

inline void analogWrite(uint8_t pin, int duty)
{
    board().pwm[pin] = duty;
}

inline int analogRead(uint8_t)
{
    return static_cast<int>(wall_us() * 2654435761u >> 22 & 1023u);
}

inline uint8_t digitalPinToInterrupt(uint8_t pin)
{
    return pin;
}

inline void attachInterrupt(uint8_t pin, void (*handler)(), int edge)
{
    board().handler[pin] = handler;
    board().edge[pin] = edge;
}

inline void noInterrupts()
{
    board().masked = true;
}

inline void interrupts()
{
    board().masked = false;
}

/* A level that comes from outside. */
inline void set_pin(int pin, int level)
{
    int before = board().level[pin];
    board().level[pin] = level;
    if (before != level && board().handler[pin] != nullptr &&
        (board().edge[pin] == CHANGE || (board().edge[pin] == FALLING && level == LOW))) {
        board().handler[pin]();
    }
}

class StandInSerial {
public:
    void begin(unsigned long baud)
    {
        baud_ = baud;
    }
    int available()
    {
        fill();
        return static_cast<int>(length_ - at_);
    }
    int read()
    {
        fill();
        return at_ < length_ ? waiting_[at_++] : -1;
    }
    int availableForWrite()
    {
        double sent = static_cast<double>(static_cast<uint32_t>(micros()) - written_us_) * 1e-6 *
                      static_cast<double>(baud_) / 10.0;
        double left = static_cast<double>(queued_) - sent;
        return left > 0.0 ? (left > 63.0 ? 0 : 63 - static_cast<int>(left)) : 63;
    }
    size_t write(const uint8_t *data, size_t length)
    {
        while (availableForWrite() < 63) {
            board().now_us += 50; /* as the real one waits */
        }
        written_us_ = static_cast<uint32_t>(micros());
        queued_ = length;
        return ::write(line_, data, length) < 0 ? 0u : length;
    }
    void open(int line)
    {
        line_ = line;
        fcntl(line_, F_SETFL, O_NONBLOCK);
    }

private:
    void fill()
    {
        if (at_ == length_) {
            ssize_t got = ::read(line_, waiting_, sizeof waiting_);
            at_ = 0;
            length_ = got > 0 ? static_cast<size_t>(got) : 0u;
        }
    }
    int line_ = -1;
    unsigned long baud_ = 9600;
    uint8_t waiting_[64];
    size_t at_ = 0;
    size_t length_ = 0;
    size_t queued_ = 0;
    uint32_t written_us_ = 0;
};

inline StandInSerial &stand_in_serial()
{
    static StandInSerial the_serial;
    return the_serial;
}
#define Serial stand_in_serial()

/* A motor with its driver's inputs and its encoder's outputs. */
struct StandInMotor {
    int pwm_pin, back_pin, a_pin, b_pin;
    double full_um_s, um_per_edge; /* travel from one edge of A to the next of B */
    double speed_um_s, rest_um;
    int phase;

    void run(double seconds)
    {
        static const int code[4] = {0, 1, 3, 2}; /* bit 0 is A, bit 1 is B: A leads forwards */
        double sign = board().level[back_pin] == HIGH ? -1.0 : 1.0;
        double wanted = sign * board().pwm[pwm_pin] / 255.0 * full_um_s;
        speed_um_s += seconds / (0.05 + seconds) * (wanted - speed_um_s);
        rest_um += speed_um_s * seconds;
        while (rest_um >= um_per_edge || rest_um <= -um_per_edge) {
            int step = rest_um > 0.0 ? 1 : -1;
            rest_um -= step * um_per_edge;
            phase = (phase + step) & 3;
            set_pin(a_pin, code[phase] & 1);
            set_pin(b_pin, code[phase] >> 1);
        }
    }
};

inline void begin_board(int line)
{
    stand_in_serial().open(line);
    board().now_us = wall_us();
}

/* The next round; false where stdin has ended. */
inline bool run_board(StandInMotor *motors, int stop_pin)
{
    while (board().left_us <= 0) {
        if (board().asked) {
            printf("%d %d\n", board().pwm[motors[0].pwm_pin], board().pwm[motors[1].pwm_pin]);
            fflush(stdout);
        }
        char line[80];
        if (fgets(line, sizeof line, stdin) == nullptr) {
            return false;
        }
        board().asked = true;
        if (strncmp(line, "run ", 4) == 0) {
            board().left_us += strtol(line + 4, nullptr, 10);
        } else {
            set_pin(stop_pin, strncmp(line, "press", 5) == 0 ? LOW : HIGH);
        }
    }
    board().left_us -= ROUND_US;
    board().now_us += ROUND_US;
    for (int side = 0; side < 2; side++) {
        motors[side].run(ROUND_US * 1e-6);
    }
    return true;
}

#endif
