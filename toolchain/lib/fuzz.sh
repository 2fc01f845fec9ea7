# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# Fuzzing what comes over the bus, and the readers of files. Sourced by toolchain/dev.

fuzz_targets=(
  sdo pdo lss nmt eds datagram client wire settings board scenario actuator trace mcap recording mark
  store communication conversation
)

# gather_seeds NAME: the project's own files that a reader takes, into build/fuzz/NAME.seeds.
gather_seeds() {
  local name=$1 seeds=$root/build/fuzz/$1.seeds bytes=8000 file
  rm -rf "$seeds"
  mkdir -p "$seeds"
  case $name in
    wire) set -- model/wires/*.toml host-sim/traces/units/*.toml ;;
    settings) set -- hal/linux/boards/devices/*.toml host-sim/scenarios/devices/*.toml tests/*/device.toml ;;
    board) set -- hal/linux/boards/*.toml tests/board/board.toml ;;
    scenario) set -- host-sim/scenarios/*.toml host-sim/traces/*.toml tests/board/hold.toml ;;
    actuator) set -- model/papers/actuators/*.toml ;;
    trace)
      set -- host-sim/traces/*.csv tests/golden/*.csv
      bytes=2000
      ;;
    *) set -- ;;
  esac
  for file; do
    # Of a trace a few rows say as much as all.
    head -c "$bytes" "$root/$file" >"$seeds/${file//\//-}" || return
  done
}

# fuzz_one NAME SECONDS: from the committed corpus or the project's files, and what former runs have found.
fuzz_one() {
  local name=$1 seconds=$2 found=$root/build/fuzz/$1 length=1024 corpus=$root/tests/fuzz/corpus/$1
  case $name in
    trace) length=2048 ;;
    wire | settings | board | scenario | actuator) length=8192 ;;
  esac
  if [[ ! -d $corpus ]]; then
    corpus=$found.seeds
    (cd "$root" && gather_seeds "$name") || return
  fi
  mkdir -p "$found" "$found.crashes"
  # An input that takes long is found by tests/fuzz/processor_limit.hpp, one that waits by -timeout.
  ASAN_OPTIONS=detect_leaks=1:detect_stack_use_after_return=1 UBSAN_OPTIONS=print_stacktrace=1 \
    "$root/build/sanitize/tests/fuzz/${name}_fuzz" -max_total_time="$seconds" -max_len="$length" \
    -timeout=600 -print_final_stats=1 -artifact_prefix="$found.crashes/" \
    "$found" "$corpus"
}

# fuzz_all SECONDS: two at a time.
fuzz_all() {
  local seconds=$1 name failed='' inputs=0 count
  build_tree sanitize fuzz_targets || return
  mkdir -p "$logs"
  export -f fuzz_one gather_seeds
  say "fuzzing ${fuzz_targets[*]}: $seconds s each"
  # shellcheck disable=SC2016 # expanded by the inner shell
  printf '%s\n' "${fuzz_targets[@]}" |
    SECONDS_EACH=$seconds xargs -P 2 -I{} bash -c \
      'fuzz_one "$1" "$SECONDS_EACH" >"$logs/fuzz-$1.log" 2>&1 || touch "$logs/fuzz-$1.failed"' - {}
  for name in "${fuzz_targets[@]}"; do
    count=$(sed -nE 's/^stat::number_of_executed_units: *//p' "$logs/fuzz-$name.log")
    printf '%-13s %s inputs\n' "$name" "$count"
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
  say "$inputs inputs"
}

run_fuzz() {
  local seconds=${1:-30}
  [[ $seconds =~ ^[0-9]+$ && $seconds -gt 0 ]] || die "fuzz: seconds must be a whole number above 0: $seconds"
  run_setup
  fuzz_all "$seconds"
}
