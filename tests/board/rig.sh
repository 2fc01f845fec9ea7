# Sourced by the scripts of guests: what stands on a board beside the daemon.
# shellcheck shell=sh

# Inputs of the board on gpio-sim, pulled down: the e-stop's loop is closed, the driver has no fault.
make_inputs() {
  sim=/sys/kernel/config/gpio-sim/inputs
  mkdir -p $sim/bank0/line0 $sim/bank0/line1
  echo 2 >$sim/bank0/num_lines
  echo e-stop >$sim/bank0/line0/name
  echo drive-fault >$sim/bank0/line1/name
  echo 1 >$sim/live
  inputs=/sys/devices/platform/$(cat $sim/dev_name)/$(cat $sim/bank0/chip_name)
  echo pull-down >"$inputs/sim_gpio0/pull"
  echo pull-down >"$inputs/sim_gpio1/pull"
  export estop="$inputs/sim_gpio0/pull"
  export driver_fault="$inputs/sim_gpio1/pull"
}

# Samples of the ADC's buffer at this rate.
make_trigger() {
  mkdir /sys/kernel/config/iio/triggers/hrtimer/board
  trigger=$(dirname "$(grep -l '^board$' /sys/bus/iio/devices/trigger*/name)")
  echo "$1" >"$trigger/sampling_frequency"
}

iio_device() { dirname "$(grep -l '^testboard$' /sys/bus/iio/devices/iio:device*/name)"; }

pwm_chip() { echo /sys/bus/platform/devices/testboard-drive/pwm/pwmchip*; }

failures=0
# expect WHAT IS WANTED
expect() {
  if [ "$2" = "$3" ]; then
    echo "ok: $1: $2"
  else
    echo "FAILED: $1: '$2', not '$3'"
    failures=$((failures + 1))
  fi
}
# within WHAT VALUE LOW HIGH
within() {
  if awk "BEGIN { exit !(\"$2\" != \"\" && $2 >= $3 && $2 <= $4) }" 2>/dev/null; then
    echo "ok: $1: $2"
  else
    echo "FAILED: $1: '$2', not $3 to $4"
    failures=$((failures + 1))
  fi
}
finish() { [ $failures = 0 ]; exit; }
