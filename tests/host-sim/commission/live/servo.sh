#!/usr/bin/env bash
# servo.sh BUILD: host-sim commission with a real daemon on a simulated wire. A run that is ended by a signal, by kill -9
# or by a lost bus leaves no heat and no file; a wire of another length is named.
# Runs in a network of its own (tests/can/own_network.sh).
set -euo pipefail

build=$(realpath "$1")
cd "$(dirname "$0")/../../../.."
# shellcheck source=tests/patience.sh
. tests/patience.sh
answers=$PWD/tests/host-sim/commission/live/answers.py
work=$(mktemp -d)
daemon=''
end() {
  [[ -z $daemon ]] || kill "$daemon" 2>/dev/null || true
  rm -rf "$work"
}
trap end EXIT

host_sim=$build/host-sim/host-sim
cd "$work"
is_there() {
  kill -0 "$daemon" || exit 1
  "$host_sim" can --can udp scan 2>&1 | grep smaservo >/dev/null
}
start_daemon() {
  on_one_processor "$build/firmware/daemon/smaservod" --board sim --bus udp >daemon.log 2>&1 &
  daemon=$!
  becomes is_there
}
get() { "$host_sim" can --can udp get "$@"; }
is_off() { [[ $(get device.state) == 0x0[15] && $(get live.drive_current_A) == 0 ]]; }
# The careful cycle: more than the 20 mA of the rest.
is_heated() {
  kill -0 "$run" || exit 1
  awk "BEGIN { exit !($(get live.drive_current_A) > 0.05) }"
}
commission() { "$host_sim" commission --can udp --node 1 "$@"; }
nothing_is_left() { [[ -z $(find . -name 'run*') ]]; }
start_daemon

# The whole sequence at a third of its durations, with a person at a terminal; replay takes the file.
"$answers" "$host_sim" commission --can udp --record whole.csv --anchors anchors.csv --pace 0.3
is_off
[[ $(get 6060) == 0 ]]
head -n 1 whole.csv | grep -x 'time_s,current_A,voltage_V,stress_Pa,servo_strain,servo_wire_temperature_K'
(($(wc -l <whole.csv) > 2500))
[[ $(wc -l <anchors.csv) == 3 && $(sed -n 2p anchors.csv) == 0.000000,0,* ]]
[[ $(sed -n 3p anchors.csv | cut -d , -f 2) == 0.0035 ]]
"$host_sim" replay --wire smartflex-76um whole.csv

begin() {
  env --default-signal=INT,TERM,HUP "$host_sim" commission --can udp --record run.csv --no-questions 2>err </dev/null &
  run=$!
  becomes is_heated
}
ends_with() {
  local status=0
  wait "$run" || status=$?
  cat err
  [[ $status == "$1" ]]
}

# A signal in the middle: the heat is off when the program has ended.
for signal in INT TERM HUP; do
  begin
  kill "-$signal" "$run"
  ends_with $((128 + $(kill -l "$signal")))
  grep 'ended by a signal; nothing is written; the heat is off' err
  is_off
  nothing_is_left
done

# Killed: the servo ends the heat by itself, 5 s later. At most a file beside the name is left.
begin
kill -KILL "$run"
ends_with 137
becomes is_off
[[ ! -e run.csv ]]
rm -f run.csv.*.part
ends_in_error() {
  local status=0
  commission --record run.csv --no-questions 2>err </dev/null || status=$?
  cat err
  [[ $status == 1 ]]
}
ends_in_error
grep 'has a fault: bus_lost' err
nothing_is_left
"$host_sim" can --can udp --quiet reset-faults

# Settings of another length: it stops before it heats.
"$host_sim" can --can udp --quiet set wire.length=87mm
ends_in_error
grep -E 'wire.length of (99|100|101) to 10[0-9] mm instead of 87 mm would explain it' err
is_off
nothing_is_left
"$host_sim" can --can udp --quiet set wire.length=100mm
"$host_sim" can --can udp --quiet reset-faults

# The daemon is gone in the middle.
begin
kill -KILL "$daemon"
daemon=''
ends_with 1
grep 'the servo ends it by itself 5 s after the last command' err
nothing_is_left
