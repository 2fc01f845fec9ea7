#!/usr/bin/env bash
# servo.sh BUILD: host-sim record from a real daemon on a simulated wire; a bus that is lost and Ctrl-C leave nothing.
# Runs in a network of its own (tests/can/own_network.sh).
set -euo pipefail

build=$(realpath "$1")
cd "$(dirname "$0")/../../.."
# shellcheck source=tests/patience.sh
. tests/patience.sh
work=$(mktemp -d)
daemon=''
end() {
  [[ -z $daemon ]] || kill "$daemon" 2>/dev/null || true
  rm -rf "$work"
}
trap end EXIT

host_sim=$build/host-sim/host-sim
cd "$work"
on_one_processor "$build/firmware/daemon/smaservod" --board sim --bus udp >daemon.log 2>&1 &
daemon=$!
is_there() {
  kill -0 "$daemon" || exit 1
  "$host_sim" can --can udp scan 2>&1 | grep smaservo >/dev/null
}
becomes is_there

# The daemon's wire, 100 mm of 76 um; the other values are the examples.
"$host_sim" record --new-card | sed -zE 's/# such as ([^\n]*)\n(\w+) = "unknown"/\2 = \1/g' |
  sed -E 's/^#!//; s/^(length_mm) = .*/\1 = 100/; s/^(cold_resistance_ohm) = .*/\1 = "unknown"/
    s/^sensor = .*/sensor = "none"/; /^(resolution_um|zero) = /d; s/^force_N = .*/force_N = "per run"/' >card.toml
record() { "$host_sim" record --card card.toml --out data --can udp "$@"; }

ends_with() {
  local status=0
  wait "$recording" || status=$?
  [[ $status == "$1" ]]
}

"$host_sim" can --can udp --quiet enable
"$host_sim" can --can udp --quiet move 1mm
record --seconds 1 --signals strain,wire_temperature_K
record --seconds 0.5 --run again
head -n 1 data/runs/run-001.csv | grep -x 'time_s,current_A,voltage_V,stress_Pa,servo_strain,servo_wire_temperature_K'
head -n 1 data/runs/again.csv | grep -x 'time_s,current_A,voltage_V,stress_Pa,servo_strain'
"$host_sim" record --check data | grep -E '^data: 2 runs, [0-9]+ rows: nothing is wrong$'
(cd data && sha256sum -c --strict --quiet SHA256SUMS)
"$host_sim" replay --wire data/wire.toml data/runs/run-001.csv >/dev/null || [[ $? == 3 ]]

# Somebody stops the recorder: what there is of the run is in the folder, and the exit status says so.
"$host_sim" record --card card.toml --out data --can udp --seconds 1000 --run short 2>err &
recording=$!
# So long a recording leaves rows out; the recorder is armed once before, to show its capacity.
has_begun() {
  kill -0 "$recording" || {
    cat err >&2
    exit 1
  }
  (($("$host_sim" can --can udp get recorder.divisor) > 1 && $("$host_sim" can --can udp get recorder.state) == 2))
}
becomes has_begun
"$host_sim" can --can udp --quiet set recorder.command=0
ends_with 3
grep 'the recording has ended after' err
"$host_sim" record --check data | grep '^data: 3 runs'
cp -r data before

fails() {
  local status=0
  "$@" >out 2>err || status=$?
  cat err
  echo "$status" >status
}
fails record --seconds 1 --run again
[[ $(<status) == 1 ]]
grep 'data/runs/again.csv: is there already' err

# Ctrl-C, and then a bus that is lost, while it waits for a trigger that does not come.
waits() { grep 'waiting for' err >/dev/null; }
begin() {
  : >err
  env --default-signal=INT "$host_sim" record --card card.toml --out "$1" --can udp --seconds 1 --run new \
    --trigger 'wire_temperature_K>2000' --patience 1000 2>err &
  recording=$!
  becomes waits
}
for folder in data fresh; do
  begin "$folder"
  kill -INT "$recording"
  ends_with 130
done
begin data
kill -KILL "$daemon"
daemon=''
ends_with 1
grep 'node 1' err
fails record --seconds 1 --run late
[[ $(<status) == 1 ]]
diff -r before data
[[ ! -e fresh && -z $(find . -name '*.part') && ! -e data-new.csv ]]
