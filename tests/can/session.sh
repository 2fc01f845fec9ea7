#!/usr/bin/env bash
# session.sh BUILD CLIENTS: independent clients talk to the daemon, its wires simulated, on a kernel's
# CAN. Runs in a guest (toolchain/can/uml), from the project's folder. BUILD has our programs,
# CLIENTS node_modules.
set -uo pipefail

# shellcheck source=tests/patience.sh
. tests/patience.sh

build=$1
clients=$2
host_sim=$build/host-sim/host-sim
sheet=firmware/reference/smaservo.eds
log=$(mktemp -d)
trap 'rm -rf "$log"' EXIT
failed=0
servo=''

# servo INTERFACE NODE: in place of the one before. It and a client share the guest's one processor, where a
# system call costs 50 us and a change of process more: one loop at a time, of 250 Hz.
servo() {
  end_servo
  mkdir "$log/store$2"
  {
    cat tests/can/device.toml
    printf '\n[identity]\nnode_id = %d\nserial_number = %d\n' "$2" $((1000 + $2))
    printf '\n[timing]\nperiod_ms = 4\nsample_timeout_ms = 20\n'
  } >"$log/$2.toml"
  "$build/firmware/daemon/smaservod" --board sim --bus "$1" --device "$log/$2.toml" \
    --settings "$log/store$2" --no-real-time >"$log/servo$2" 2>&1 &
  servo=$!
  becomes is_there "$1" "$2"
}

# is_there INTERFACE NODE: it answers; when it has ended, so does all.
is_there() {
  kill -0 "$servo" || {
    cat "$log/servo$2"
    exit 1
  }
  "$host_sim" can --can "$1" scan 2>&1 | grep -E "^ *$2 .*smaservo" >/dev/null
}

# gain VALUE: what is in force of strain.proportional_W.
gain() {
  [[ $("${ours[@]}" get strain.proportional_W 2>/dev/null) == "$1" ]]
}

end_servo() {
  [[ -n $servo ]] || return 0
  kill "$servo" && wait "$servo"
  servo=''
}

# step NAME COMMAND...
step() {
  local name=$1 start=$SECONDS
  shift
  if "$@" >"$log/out" 2>&1; then
    printf 'ok      %s, %d s\n' "$name" $((SECONDS - start))
  else
    printf 'FAILED  %s, %d s\n' "$name" $((SECONDS - start))
    sed 's/^/        /' "$log/out"
    failed=1
  fi
}

can_utils() {
  # The lines of the README, as they stand.
  sed -n '/executed by tests\/can\/session.sh/,/^```$/p' host-sim/can/README.md |
    sed '/^```/d; /^<!--/d' >"$log/one-liners.sh"
  [[ -s $log/one-liners.sh ]] || return
  bash "$log/one-liners.sh" | tee "$log/answers"
  grep -q '43 00 21 01' "$log/answers" || return
  grep -q '60 00 21 01 00 00 00 00' "$log/answers" || return
  local bytes
  bytes=$(sed -nE 's/.* 43 64 60 00 (..) (..) (..) (..).*/\4\3\2\1/p' "$log/answers")
  local position=$((0x${bytes:-0}))
  printf 'position %d um\n' "$position"
  ((position > 650 && position < 950))
}

tool() {
  local ours=("$host_sim" can --can vcan0 --node 5 --timeout 10)
  "${ours[@]}" scan --listen 2 | grep -E '^ *5 .*smaservo' || return
  "${ours[@]}" info || return
  "${ours[@]}" set limits.current_mA=350 strain.proportional_W=6 || return
  [[ $("${ours[@]}" get strain.proportional_W) == 6 ]] || return
  "${ours[@]}" dump "$log/dump.toml" || return
  "${ours[@]}" set strain.proportional_W=8 || return
  ! "${ours[@]}" diff "$log/dump.toml" || return
  "${ours[@]}" restore "$log/dump.toml" || return
  "${ours[@]}" diff "$log/dump.toml" || return
  "${ours[@]}" enable && "${ours[@]}" move 600 --patience 40 && "${ours[@]}" disable || return
  "${ours[@]}" record --seconds 0.5 --out "$log/recording.csv" || return
  local rows
  rows=$(wc -l <"$log/recording.csv")
  printf 'recording of %d rows\n' "$rows"
  ((rows > 100)) || return
  # A reset is a new start: what is stored is in force, nothing else, and its loop counts anew.
  "${ours[@]}" set strain.proportional_W=9 && "${ours[@]}" store || return
  "${ours[@]}" set strain.proportional_W=5 && "${ours[@]}" reset || return
  becomes gain 9 || return
  "${ours[@]}" info | tee "$log/info" || return
  grep -E '^loop +[1-9][0-9]{0,3} steps' "$log/info" || return
  ! "${ours[@]}" set limits.current_A=99 2>"$log/refusal" || return
  grep 'must be 0.001 to 20 A' "$log/refusal"
}

decoded() {
  tshark -r "$1" -d can.subdissector,canopen 2>/dev/null >"$log/decoded" || return
  local frames malformed
  frames=$(wc -l <"$log/decoded")
  malformed=$(grep -ciE 'malformed|unknown or malformed' "$log/decoded")
  printf '%d frames, %d malformed\n' "$frames" "$malformed"
  grep -E 'SDO|NMT|PDO|EMCY' "$log/decoded" | head -n 3
  ((frames > 50 && malformed == 0))
}

main() {
  ip link add can0 type vcan && ip link set can0 up
  servo can0 1
  candump -L can0 >"$log/can0.log" &
  step 'can-utils, as the README prints it' can_utils
  step 'canmatrix' tests/can/live_by_dbc.py can0 1 firmware/reference/smaservo.dbc "$host_sim"
  servo vcan0 5
  step 'host-sim can' tool
  step 'conformance, python-can' tests/can/conformance.py vcan0 5
  sed -n '/^conformance/p' "$log/out"
  servo vcan1 6
  candump -L vcan1 >"$log/vcan1.log" &
  NODE_PATH=$clients/node_modules step 'canopen (npm)' \
    node tests/can/canopen_by_node.js vcan1 6 "$sheet"
  end_servo
  step 'tshark, can-utils session' decoded "$log/can0.log"
  step 'tshark, npm session' decoded "$log/vcan1.log"
  ((failed == 0)) || tail -n 20 "$log"/servo?
  return "$failed"
}

main
