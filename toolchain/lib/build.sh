# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# Building, replaying and testing. Sourced by toolchain/dev.

# The part of a log that tells why: from the first error on, and the last lines.
show_end() {
  local log=$1 first
  first=$(grep -nEm 1 'error: |CMake Error|FAILED|\*\*\*' "$log" | cut -d: -f1)
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

# step NAME COMMAND...: runs quietly, with its output in build/logs/NAME.log; shows the end of it
# when the command fails.
step() {
  local name=$1
  shift
  mkdir -p "$logs"
  if ! "$@" >"$logs/$name.log" 2>&1; then
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

# timed NAME COMMAND...: its line of the summary: name, result, seconds, what was counted.
timed() {
  local name=$1 start=$SECONDS result=passed
  shift
  counted=''
  "$@" || result=FAILED
  printf '%-10s %-7s %5d s  %s\n' "$name" "$result" $((SECONDS - start)) "$counted" >>"$logs/summary"
}

counted=''

test_preset() {
  local preset=$1
  build "$preset" || return
  # Some tests run in a guest.
  [[ $preset != release && $preset != dev ]] || setup_guest || return
  say "testing $preset"
  # Sanitizers find leaks and undefined behaviour only where they are told to stop there.
  (cd "$root" &&
    ASAN_OPTIONS=detect_leaks=1:detect_stack_use_after_return=1:strict_string_checks=1 \
      UBSAN_OPTIONS=print_stacktrace=1 \
      step "$preset-test" ctest --preset "$preset" --parallel "$(nproc)") || return
  counted=$(sed -nE 's/^100% tests passed, .* out of ([0-9]+)$/\1 tests/p' "$logs/$preset-test.log")
  local skipped
  skipped=$(grep -cE '\(Skipped\)$' "$logs/$preset-test.log" || true)
  [[ $skipped == 0 ]] || counted+=", $skipped of them skipped: see build/logs/$preset-test.log"
}

# Cross compiled and in an emulator, with traces of the release's host-sim.
test_arm64() {
  sysroot arm64 aarch64-linux-gnu && build release host-sim && test_preset arm64
}

test_part() {
  case $1 in
    arm64 | mcu) timed "$1" "test_$1" ;;
    can) timed can-test can_test ;;
    board) timed board-test board_all ;;
    package) timed package test_package ;;
    fuzz) timed fuzz fuzz_all 60 ;;
    check) timed check run_check ;;
    *) timed "$1" test_preset "$1" ;;
  esac
}

test_all() {
  local part
  test_part release
  # What takes one core, side by side.
  test_part mcu &
  test_part can
  test_part board
  wait
  for part in arm64 package sanitize tsan fuzz check; do
    test_part "$part"
  done
}

run_test() {
  mkdir -p "$logs"
  rm -f "$logs/summary"
  timed setup run_setup
  case ${1:-all} in
    all) test_all ;;
    dev | release | sanitize | tsan | arm64 | mcu | package) test_part "$1" ;;
    *) die "test: unknown part: $1 (dev, release, sanitize, tsan, arm64, mcu, package)" ;;
  esac
  printf '\n'
  cat "$logs/summary"
  if grep -q ' FAILED ' "$logs/summary"; then
    printf 'Logs are in %s\n' "$(near "$logs")"
    return 1
  fi
}
