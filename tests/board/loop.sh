#!/bin/sh
# The daemon on the kernel's own IIO, PWM and GPIO, with a simulated wire behind them.
. ./rig.sh
. ./servo.sh
make_inputs

echo '-- check'
/smaservod --board board.toml --check >/tmp/check
expect '--check' $? 0
cat /tmp/check

echo '-- hold'
servo 3.5
cat /tmp/figures.json
within 'strain held' "$(held_strain)" 1.95 2.05
expect 'no fault' "$(first_cause)" none
expect 'the daemon ends well' "$daemon_code" 0

echo '-- e-stop'
servo 2.2 2 "$estop" pull-up
within 'off after the e-stop, us' "$(stop_us program)" 1 2500
expect 'cause' "$(first_cause)" emergency_stop
echo pull-down >"$estop"
finish
