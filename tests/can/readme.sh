#!/usr/bin/env bash
# readme.sh BUILD: the lines of README.md with a daemon on a bus, as they stand, with the programs of this build.
# Runs in a network of its own (own_network.sh).
set -euo pipefail

build=$(realpath "$1")
cd "$(dirname "$0")/../.."
# shellcheck source=tests/patience.sh
. tests/patience.sh
work=$(mktemp -d)
daemon=''
end() {
  [[ -z $daemon ]] || kill "$daemon" 2>/dev/null || true
  rm -rf "$work"
}
trap end EXIT

ours=("$build/host-sim/host-sim" can --can udp --node 1)
is_there() {
  kill -0 "$daemon" || exit 1
  "$build/host-sim/host-sim" can --can udp scan 2>&1 | grep smaservo >/dev/null
}

lines=$(sed -n '/ by tests\/can\/readme.sh -->$/,/^[A-Z]/s/^    //p' README.md)
[[ $(grep -c 'host-sim can --can udp' <<<"$lines") -ge 7 ]]
eval "$(toolchain/dev 'do' shell_line "$build")"
cd "$work" # where step keeps its runs
while IFS= read -r line; do
  echo "+ $line"
  line=${line%% #*}
  case $line in
    *smaservod*\&)
      eval "${line%&} >$work/daemon 2>&1 &"
      daemon=$!
      becomes is_there
      ;;
    *\ watch*)
      # Without an end: one row of it.
      eval "timeout $patience_s $line --count 1"
      ;;
    *)
      eval "timeout $patience_s $line"
      ;;
  esac
done <<<"$lines"

[[ $("${ours[@]}" get strain.proportional_W) == 0 ]]
[[ -s can-steps/step-0001.csv ]]
"${ours[@]}" set strain.proportional_W 0.5
[[ $("${ours[@]}" get strain.proportional_W) == 0.5 ]]
grep -E 'smaservod: board sim, bus udp, node-id 1, wire .* current off until enabled$' "$work/daemon"
position=$("${ours[@]}" get 6064)
echo "position $position um"
((position > 900 && position < 1100))
# Its log may come a tenth of a second later.
becomes grep -F 'bus: strain.proportional_W (2100h:1): 0 -> 0.5, by SDO' "$work/daemon"

# What a command reports goes to the standard error output alone, and --quiet leaves it out.
says() {
  local text=$1
  shift
  [[ -z $("${ours[@]}" --quiet "$@" 2>&1) ]]
  [[ -z $("${ours[@]}" "$@" 2>"$work/said") ]]
  grep -E "$text" "$work/said"
}
says '^enabled: may be heated until 5 s after the last enable, move or set-point' enable
says '^within 100 um of 900 um after [0-9.]+ s: at [0-9]+ um$' move 0.9mm
says '^within 0.0001 m of 0.0011 m after [0-9.]+ s: at 0.00[0-9]+ m$' --units si move 0.0011m
says '^limits.temperature_degC: (120 -> 110|was 110 already)$' set limits.temperature=110degC
says '^disabled: current off' disable
says '^there was no fault to acknowledge; the drive is disabled, the wire.s state is ready$' reset-faults
says '^stop sent to node 1: heat ends, unless 6007h, 605Ah or 605Eh was set to keep it; what the' stop
says '^operational: node 1' start

# A trial: the values are in force, and as before when it is reverted; without one there is nothing to end.
fails() {
  local text=$1 status=0
  shift
  "${ours[@]}" "$@" 2>"$work/said" || status=$?
  [[ $status == 1 ]] && grep -F "$text" "$work/said"
}
"${ours[@]}" try --for 60 strain.proportional_W=2 limits.power=900mW
[[ $("${ours[@]}" get strain.proportional_W) == 2 ]]
fails 'has a trial already' try strain.proportional_W=3
"${ours[@]}" revert
[[ $("${ours[@]}" get strain.proportional_W) == 0.5 ]]
fails 'no trial to keep' keep
fails 'no trial to revert' revert
fails 'needs a unit, in the name or behind the number: W, mW' set limits.power=900
fails 'with a unit behind it: m, mm, um' move 1inch
fails 'position 1000: needs a unit behind it: m, mm, um' --units si move 1000
fails 'position 1m: node 1 allows ' move 1m
fails 'strain.proportional_W: given twice' set strain.proportional_W=3 strain.proportional_mW=4
fails 'limits.temperature: has no value' set limits.temperature
fails 'limits.temperature: has no value' set limits.temperature=
fails 'must be 0 to ' set limits.temperature=nandegC
ours[-1]=5 # no such node
fails 'no answer within' start
fails 'has not reported its start within 3 s' reset
ours[-1]=1
"${ours[@]}" get strain | grep -E '^live.strain_percent = [0-9.]+$'
"${ours[@]}" get strain_percent | grep -E '^[0-9.]+$'
"${ours[@]}" get setpoint | grep -E '^live.setpoint_um = [0-9.]+$'
"${ours[@]}" get setpoint_um | grep -E '^[0-9.]+$'
fails 'live.setpoint_mA: the mode in force has another unit: m, mm, um' get setpoint_mA
"${ours[@]}" watch wire_temperature live.wire_temperature_K --once |
  grep -x 'time_s,live.wire_temperature_degC,live.wire_temperature_K'
"${ours[@]}" record --signals live.strain,wire_temperature_K --seconds 0.1 --out "$work/run.csv"
head -n 1 "$work/run.csv" | grep -x 'time_s,strain,wire_temperature_K'
says '^reset: node 1 has started anew after' reset
[[ $("${ours[@]}" get strain.proportional_W) == 0 ]]
