# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# Building and replaying. Sourced by toolchain/dev.

# The part of a log that tells why: from the first error on, and the last lines.
show_end() {
  local log=$1 first
  first=$(grep -nEm 1 'error: |CMake Error|FAILED|\*\*\*' "$log" | cut -d: -f1) || :
  {
    printf -- '--- from %s\n' "$log"
    if [[ -n $first ]] && (($(wc -l <"$log") - first > 50)); then
      sed -n "$first,$((first + 30))p" "$log"
      printf -- '[...]\n'
      tail -n 15 "$log"
    else
      tail -n 50 "$log"
    fi
    printf -- '---\n'
  } >&2
}

# Seconds of processors that this shell and all that it has waited for have taken; into $used.
processor_time() {
  local -a stat
  read -r -a stat <"/proc/$BASHPID/stat"
  used=$(((stat[13] + stat[14] + stat[15] + stat[16]) / 100))
}

# took NAME COMMAND...: writes its seconds down, of processors and of the clock, and its name.
took() {
  local name=$1 clock=$SECONDS used before code=0
  shift
  processor_time
  before=$used
  "$@" || code=$?
  processor_time
  mkdir -p "$logs"
  printf '%d %d %s\n' $((used - before)) $((SECONDS - clock)) "$name" >>"$logs/steps"
  return "$code"
}

# step NAME COMMAND...: runs quietly, with its output in build/logs/NAME.log; shows the end of it
# when the command fails.
step() {
  local name=$1
  shift
  mkdir -p "$logs"
  if ! took "$name" "$@" >"$logs/$name.log" 2>&1; then
    say "failed: $name"
    show_end "$logs/$name.log"
    return 1
  fi
}

# configure PRESET: only what has changed.
configure() {
  (cd "$root" && step "$1-configure" cmake --preset "$1")
}

# build PRESET [TARGET...]: one at a time in each tree.
build() {
  local preset=$1
  shift
  mkdir -p "$root/build"
  {
    flock 9
    configure "$preset" || return
    say "building $preset${*:+: $*}"
    (cd "$root" &&
      step "$preset-build" \
        cmake --build --preset "$preset" --parallel "$(nproc)" ${1:+--target "$@"})
  } 9>"$root/build/$preset.lock"
}

near() { realpath --relative-to="$here" "$1"; }

value_of() { sed -nE "s/^$1 *= *\"(.*)\" *\$/\1/p" "$2" | head -n 1; }

# The command that replays a trace of the project, to be copied.
replay_command_of() {
  local scenario=$1 trace=${1%.toml}.csv
  local wire
  wire=$(value_of wire "$scenario")
  [[ $wire != *.toml ]] || wire=$(near "$(dirname "$scenario")/$wire")
  printf '%q replay --wire %q %q\n' "$(near "$root/toolchain/dev")" "$wire" "$(near "$trace")"
}

# list_traces FIRST: all but this one.
list_traces() {
  local scenario
  printf '\nThe other traces:\n'
  for scenario in "$root"/host-sim/traces/*.toml; do
    [[ -r ${scenario%.toml}.csv && ${scenario%.toml}.csv != "$1" ]] || continue
    printf '\n  %s\n    %s\n' "$(value_of note "$scenario")" "$(replay_command_of "$scenario")"
  done
  printf '\nAdd --report FILE.html for a report, --out FILE.csv for the estimate.\n'
}

# Every trace of the project: its report, and one row of a table.
replay_all() {
  local host_sim=$1 out=$2 scenario name wire
  printf '| trace | mean | 95 %% | maximum |\n|---|--:|--:|--:|\n'
  for scenario in "$root"/host-sim/traces/*.toml; do
    name=$(basename "$scenario" .toml)
    wire=$(value_of wire "$scenario")
    "$host_sim" replay --wire "$(dirname "$scenario")/$wire" --report "$out/$name.html" \
      "${scenario%.toml}.csv" |
      awk -v name="$name" '/^(kalman|model) / {
        printf "| %s | %s | %s | %s |%s\n", name, $2, $3, $4, $5 == "" ? "" : " " $5 }'
  done
  printf '\nError in %% of the nominal stroke. The reports are in %s.\n' "$(near "$out")"
}

run_build() {
  run_setup
  build release host-sim smaservod
}

# A servo on a simulated wire and the page before it, until Ctrl-C.
run_page() {
  run_setup
  build release host-sim smaservod
  local bus=udp:239.74.163.5%lo:$((20000 + $$ % 20000)) folder
  folder=$(mktemp -d)
  "$root/build/release/firmware/daemon/smaservod" --board sim --bus "$bus" --no-real-time \
    --settings "$folder" &
  # Whatever has ended the page, the servo ends, and nothing of it stays.
  # shellcheck disable=SC2064 # these now
  trap "kill $! 2>/dev/null || :; wait $! || :; rm -r '$folder'" EXIT
  if (($# == 0)) && [[ -n ${DISPLAY-}${WAYLAND_DISPLAY-} ]]; then
    (sleep 1 && xdg-open http://127.0.0.1:8765/) &
  fi
  "$root/build/release/host-sim/host-sim" page --can "$bus" "$@"
}

run_replay() {
  run_setup
  build release host-sim
  local host_sim=$root/build/release/host-sim/host-sim
  if [[ $* == --all ]]; then
    mkdir -p "$root/build/replay"
    replay_all "$host_sim" "$root/build/replay"
    return
  fi
  if (($#)); then
    "$host_sim" replay "$@"
    return
  fi
  local out=$root/build/replay trace=$root/host-sim/traces/150MPa.csv
  mkdir -p "$out"
  "$host_sim" replay --wire "$root/host-sim/traces/units/a.toml" --out "$out/estimate.csv" \
    --report "$out/report.html" "$trace"
  local report
  report=$(near "$out/report.html")
  printf '\nReport:   %s\nEstimate: %s\n' "$report" "$(near "$out/estimate.csv")"
  printf 'Open the report in any browser, for instance: xdg-open %q\n' "$report"
  list_traces "$trace"
}
