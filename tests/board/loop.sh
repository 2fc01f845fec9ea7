#!/bin/sh
# The daemon on the kernel's own IIO, PWM and GPIO, with a simulated wire behind them.
# shellcheck source=tests/board/rig.sh
. ./rig.sh
# shellcheck source=tests/board/servo.sh
. ./servo.sh
make_inputs
daemon_arguments=--sandbox
adc=/sys/bus/platform/drivers/testboard-adc
drive=/sys/bus/platform/drivers/testboard-drive

echo '-- check'
/smaservod --board board.toml --check >/tmp/check
expect 'code of --check' $? 0
expect 'devices that --check has opened' "$(grep -c ' ok$' /tmp/check)" 8

echo '-- hold'
servo 4
within 'strain held, %' "$(held_strain)" 1.94 2.06
expect 'no fault' "$(first_cause)" none
expect 'the daemon ends well' "$daemon_code" 0

echo '-- settings beyond the board'
cp board.toml device.toml /tmp
printf '\n[ceilings]\ncurrent_mA = 420\n' >>board.toml
(
  sleep 1.5
  sed -i 's/^current_mA = 400/current_mA = 440/' device.toml
  kill -HUP "$(cat /tmp/daemon)"
) &
servo 3
expect 'what SIGHUP is told' "$(grep -c 'nothing is changed: limits.current_A = 0.44: .*ceiling, 0.42' /tmp/daemon.log)" 1
expect 'the daemon ends well' "$daemon_code" 0
cp /tmp/board.toml /tmp/device.toml .

# stops NAME CAUSE MOST_US PATH VALUE [OTHERWISE]: heat ends within this time of writing the value.
stops() {
  echo "-- $1"
  servo 2.3 1.9 "$4" "$5"
  within "$1: off after, us" "$(stop_us)" 1 "$3"
  expect "$1: cause" "$(first_cause)" "$2"
  echo "| $1 | $2 | $(stop_us) |" >>/tmp/stops
  [ -z "${6:-}" ] || echo "$6" >"${7:-$4}"
}
stops 'e-stop pressed' emergency_stop 2500 "$estop" pull-up pull-down
stops 'driver fault' driver_fault 5500 "$driver_fault" pull-up pull-down
stops 'ADC says I/O error' sample_stale 25000 "$(iio_device)/in_voltage1_fault" 5 0
stops 'ADC unbound' sample_stale 25000 $adc/unbind testboard-adc testboard-adc $adc/bind
stops 'drive unbound' driver_fault 5500 $drive/unbind testboard-drive testboard-drive $drive/bind

# bad NAME PATTERN WANTED: --check of a board file that has been changed.
bad() {
  sed "$2" board.toml >bad.toml
  if /smaservod --board bad.toml --check >/tmp/check 2>&1; then
    expect "$1" 'accepted' 'refused'
  fi
  expect "$1" "$(grep -c "$3" /tmp/check)" 1
}
echo '-- bad boards'
bad 'unknown key' 's/^frequency_Hz.*//; s/^supply_V/suply_V/' 'suply_V\|supply_V'
bad 'no such converter' 's/^device = .*/device = "ads1299"/' 'ads1299'
bad 'no such channel' 's/in_voltage1"/in_voltage9"/' 'in_voltage9'
bad 'no such line' 's/"heat-kick"/"kick"/' 'kick .*no such line'
bad 'no such PWM' 's/^type = "pwm"/type = "pwm"\nchannel = 7/' 'pwm'
bad 'out of range' 's/^supply_V = .*/supply_V = 5000/' 'supply_V = 5000.*0.5 to 1000\|supply_V.*1000'
bad 'sensor that is not there' 's/in_voltage3_raw/in_voltage33_raw/' 'in_voltage33_raw'

echo 'TABLE | what | cause | heat off after, us |'
echo 'TABLE |---|---|--:|'
sed 's/^/TABLE /' /tmp/stops
finish
