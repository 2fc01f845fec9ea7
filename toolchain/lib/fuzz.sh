# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# Fuzzing what comes over the bus. Sourced by toolchain/dev.

fuzz_targets=(sdo pdo lss nmt eds)

# fuzz_one NAME SECONDS: from the committed corpus and what former runs have found.
fuzz_one() {
  local name=$1 seconds=$2 found=$root/build/fuzz/$1
  mkdir -p "$found" "$found.crashes"
  ASAN_OPTIONS=detect_leaks=1:detect_stack_use_after_return=1 UBSAN_OPTIONS=print_stacktrace=1 \
    "$root/build/sanitize/tests/fuzz/${name}_fuzz" -max_total_time="$seconds" -max_len=1024 \
    -timeout=10 -print_final_stats=1 -artifact_prefix="$found.crashes/" \
    "$found" "$root/tests/fuzz/corpus/$name"
}

# fuzz_all SECONDS: two at a time.
fuzz_all() {
  local seconds=$1 name failed='' inputs=0 count
  build sanitize fuzz_targets || return
  mkdir -p "$logs"
  export -f fuzz_one
  say "fuzzing ${fuzz_targets[*]}: $seconds s each"
  # shellcheck disable=SC2016 # expanded by the inner shell
  printf '%s\n' "${fuzz_targets[@]}" |
    SECONDS_EACH=$seconds took fuzz xargs -P 2 -I{} bash -c \
      'fuzz_one "$1" "$SECONDS_EACH" >"$logs/fuzz-$1.log" 2>&1 || touch "$logs/fuzz-$1.failed"' - {}
  for name in "${fuzz_targets[@]}"; do
    count=$(sed -nE 's/^stat::number_of_executed_units: *//p' "$logs/fuzz-$name.log")
    printf '%-4s %s inputs\n' "$name" "$count"
    inputs=$((inputs + ${count:-0}))
    if [[ -e $logs/fuzz-$name.failed ]]; then
      rm -f "$logs/fuzz-$name.failed"
      failed+=" $name"
      show_end "$logs/fuzz-$name.log"
    fi
  done
  [[ -z $failed ]] || {
    say "failed:$failed; the inputs are in $(near "$root/build/fuzz")"
    return 1
  }
  # shellcheck disable=SC2034 # for the summary
  counted="$inputs inputs"
}

run_fuzz() {
  local seconds=${1:-60}
  [[ $seconds =~ ^[0-9]+$ && $seconds -gt 0 ]] || die "fuzz: seconds must be a whole number above 0: $seconds"
  run_setup
  fuzz_all "$seconds"
}
