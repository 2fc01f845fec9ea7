# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# Testing: parts, their summary, what took longest. Sourced by toolchain/dev.

# What a part has counted, for its line of the summary.
counted=''

# timed NAME COMMAND...: its line of the summary: name, result, seconds of the clock and of processors,
# what was counted.
timed() {
  local name=$1 clock=$SECONDS result=passed used before
  shift
  counted=''
  processor_time
  before=$used
  "$@" || result=FAILED
  processor_time
  printf '%-10s %-7s %5d s %6d s  %.46s\n' "$name" "$result" $((SECONDS - clock)) \
    $((used - before)) "$counted" >>"$logs/summary"
}

# ctest_preset PRESET: sanitizers find leaks and undefined behaviour only where they are told to stop there.
ctest_preset() {
  local skipped
  say "testing $1"
  (cd "$root" &&
    ASAN_OPTIONS=detect_leaks=1:detect_stack_use_after_return=1:strict_string_checks=1 \
      UBSAN_OPTIONS=print_stacktrace=1 \
      step "$1-test" ctest --preset "$1" --parallel "$(nproc)") || return
  counted=$(sed -nE 's/^100% tests passed, .* out of ([0-9]+)$/\1/p' "$logs/$1-test.log")
  skipped=$(grep -cE '\(Skipped\)$' "$logs/$1-test.log" || true)
  if [[ $1 == sanitize || $1 == tsan ]]; then
    # One entry of ctest is many tests.
    counted=$(ended_tests "$1" OK | wc -l)
    skipped=$(ended_tests "$1" SKIPPED | wc -l)
    ((counted > 0)) || return
  fi
  counted+=' tests'
  [[ $skipped == 0 ]] || counted+=", $skipped skipped"
}

# ended_tests PRESET HOW: tests of GoogleTest that ended so, with seconds: "2 s  Suite.Test".
ended_tests() {
  sed -nE "s/^\[ +$2 \] ([^ ]+) \(([0-9]+) ms\)\$/\2 \1/p" \
    "$root/build/$1/Testing/Temporary/LastTest.log" | awk '{ printf "%d s  %s\n", $1 / 1000, $2 }'
}

test_preset() {
  build "$1" || return
  # Some tests run in a guest.
  [[ $1 != release && $1 != dev ]] || setup_guest || return
  ctest_preset "$1"
}

# With the first line of README.md, which a test of the tree cannot run while others use the tree.
test_release() {
  step mcap-library install_mcap_library || return
  test_preset release && step replay "$root/toolchain/dev" replay
}

# Cross compiled and in an emulator, with traces of the release's host-sim.
test_arm64() {
  sysroot arm64 aarch64-linux-gnu && build release host-sim && test_preset arm64
}

# What a change has most often broken, in a few minutes.
test_quick() {
  build release && ctest_preset quick && took syntax check_syntax && took check check_quickly
}

test_part() {
  case $1 in
    release | arm64 | mcu | quick) timed "$1" "test_$1" ;;
    can) timed can-test can_test ;;
    board) timed board-test board_all ;;
    package) timed package test_package ;;
    fuzz) timed fuzz fuzz_all 20 ;;
    check) timed check run_check ;;
    *) timed "$1" test_preset "$1" ;;
  esac
}

test_parts() {
  local part
  for part; do
    test_part "$part"
  done
}

# behind PART...: in what the other processes leave of the processors.
behind() (
  renice -n 5 "$BASHPID" >/dev/null
  test_parts "$@"
)

# Two rows side by side: a part uses one processor only while it configures, links, boots a guest or
# ends with its longest test, and the other row has work for the second one. Guests have time limits,
# so their row goes first. Fuzzers have a time each, so nothing runs beside them.
test_all() {
  test_parts release board can mcu package &
  behind sanitize check tsan arm64
  wait
  test_part fuzz
}

# dearest_in STEP: what was compiled or tested in it, with seconds of the clock.
dearest_in() {
  case $1 in
    *-build)
      awk -v began="$(stat -c %Y "$logs/began")" 'NR > 1 && $3 / 1e9 >= began && $4 ~ /[.]o$/ {
        sub(/CMakeFiles\//, "", $4); sub(/Unity\/unity_/, "", $4); sub(/(_cxx[.]cxx|[.]cpp)[.]o$/, "", $4)
        printf "%.0f s  %s\n", ($2 - $1) / 1000, $4
      }' "$root/build/${1%-build}/.ninja_log"
      ;;
    sanitize-test | tsan-test) ended_tests "${1%-test}" OK ;;
    *-test) sed -nE 's/^ *[0-9]+\/[0-9]+ Test +#[0-9]+: ([^ ]+) .* ([0-9]+)\.[0-9]+ sec.*$/\2 s  \1/p' "$logs/$1.log" ;;
  esac | sort -rn | sed -n 1,3p
}

print_dearest() {
  local processors clock name
  printf '\nThe ten most expensive steps, in seconds of processor time and of the clock:\n'
  awk '$1 > 0' "$logs/steps" | sort -rn | sed -n 1,10p | while read -r processors clock name; do
    printf '%6d %6d  %s\n' "$processors" "$clock" "$name"
    dearest_in "$name" | sed 's/^/                 /' | cut -c -80
  done
}

test_names='dev, release, quick, sanitize, tsan, arm64, mcu, package'

run_test() {
  mkdir -p "$logs"
  rm -f "$logs/summary" "$logs/steps"
  touch "$logs/began"
  timed setup run_setup
  case ${1:-all} in
    all) test_all ;;
    dev | release | quick | sanitize | tsan | arm64 | mcu | package) test_part "$1" ;;
    *) die "test: unknown part: $1 ($test_names)" ;;
  esac
  print_dearest
  printf '\npart       result   clock processors\n'
  cat "$logs/summary"
  if grep -q ' FAILED ' "$logs/summary"; then
    printf 'Logs are in %s\n' "$(near "$logs")"
    return 1
  fi
}
