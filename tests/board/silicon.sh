#!/bin/sh
# The rig itself, without a daemon: heat ends with the kicks, the enable line, the PWM, its device.
# shellcheck source=tests/board/rig.sh
. ./rig.sh
make_inputs
make_trigger 1000
expect 'channels of the ADC' "$(find "$(iio_device)/" -name "in_voltage*_raw" | wc -l)" 8
pwm=$(pwm_chip)/pwm0
echo 0 >"$(pwm_chip)/export"
echo 50000 >"$pwm/period"
echo 10000 >"$pwm/duty_cycle"
echo 1 >"$pwm/enable"
gpioset heat-enable=1 &
echo $! >/tmp/enable
gpioset --toggle 1ms heat-kick=1 &
echo $! >/tmp/kick
/plant hold.toml 1 0.5 pid:/tmp/kick 9 >/tmp/plant
cat /tmp/plant
within 'the one-shot cuts' "$(sed -n 's/OFF after_us=\(.*\) by=one-shot.*/\1/p' /tmp/plant)" 6000 8000
gpioset --toggle 1ms heat-kick=1 2>/dev/null &
ends_at_once() {
  /plant hold.toml 0.8 0.2 "$2" "$3" >/tmp/plant
  cat /tmp/plant
  within "$1 ends it at once" "$(sed -n 's/OFF after_us=\(.*\) by=program.*/\1/p' /tmp/plant)" 0 200
}
ends_at_once 'the duty' "$pwm/duty_cycle" 0
echo 10000 >"$pwm/duty_cycle"
ends_at_once 'the PWM' "$pwm/enable" 0
echo 1 >"$pwm/enable"
ends_at_once 'the device that goes' /sys/bus/platform/drivers/testboard-drive/unbind testboard-drive
echo 7 >"$(iio_device)/in_voltage7_code"
expect 'a code' "$(cat "$(iio_device)/in_voltage7_raw")" 7
echo 5 >"$(iio_device)/in_voltage7_fault"
expect 'a code that cannot be read' "$(cat "$(iio_device)/in_voltage7_raw" 2>/dev/null)" ''
finish
