#!/bin/sh
# The rig on another architecture's kernel: converter, PWM, GPIO and CAN are there and answer.
# shellcheck source=tests/board/rig.sh
. ./rig.sh
make_inputs
make_trigger 1000
echo -5 >"$(iio_device)/in_voltage7_code"
expect 'a code' "$(cat "$(iio_device)/in_voltage7_raw")" -5
pwm=$(pwm_chip)/pwm0
echo 0 >"$(pwm_chip)/export"
echo 50000 >"$pwm/period"
echo 20000 >"$pwm/duty_cycle"
expect 'a duty' "$(cat "$pwm/duty_cycle")" 20000
echo pull-up >"$estop"
expect 'a line' "$(cat "${estop%/pull}/value")" 1
ip link add vcan0 type vcan
expect 'a CAN interface' "$(cat /sys/class/net/vcan0/type)" 280
finish
