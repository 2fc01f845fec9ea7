# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# Microcontrollers in QEMU: tests, and instructions and memory that the device needs there. Sourced by
# toolchain/dev.

# Those that are tested and measured, without the Cortex-M0+, which is only built.
mcu_targets() { printf '%s\n' m3 m4f m7 m33; }

mcu_machine() {
  sed -nE 's/^set\(SMASERVO_MCU_MACHINE (.*)\)/\1/p' "$root/toolchain/cmake/arm-none-eabi-$1.cmake"
}

mcu_steps() { printf '%s\n' "$root/build/mcu/steps"; }

write_mcu_steps() {
  local bin=$root/build/release/tests/mcu steps
  steps=$(mcu_steps)
  build release write_steps answer_steps hold_strain count_operations || return
  if [[ -f $steps/made && $steps/made -nt $bin/write_steps && $steps/made -nt $bin/answer_steps ]]; then
    return
  fi
  rm -rf "$steps"
  step mcu-steps "$bin/write_steps" "$steps" || return
  step mcu-steps "$bin/answer_steps" "$steps"/*.steps || return
  touch "$steps/made"
}

# count_mcu TARGET PROGRAM FILE...: what bench_steps or bench_fixed says of these, one instruction
# 1024 ns.
count_mcu() {
  local target=$1 program=$2
  shift 2
  (cd "$(mcu_steps)" &&
    qemu-system-arm -M "$(mcu_machine "$target")" -nographic -monitor none -serial none \
      -icount shift=10 -semihosting-config enable=on,target=native \
      -kernel "$root/build/mcu-$target/tests/mcu/$program.elf" -append "$*" </dev/null 2>&1)
}

# Lines of counts as "KEY VALUE": mean and worst of each kind over all files. Apart are traces that come
# every 10 ms, whose samples take two steps of the observer, and the wire whose loops have an order.
mcu_sums() {
  awk '
    function add(key, steps, mean, most) {
      sum[key] += steps * mean; count[key] += steps; if (most > worst[key]) worst[key] = most
    }
    $1 == "model" { add($1, $3, $4, $5) }
    $1 == "fixed_observer" { add($1 (kind($2) == "ordered" ? "_ordered" : ""), $3, $4, $5) }
    $1 == "device" || $1 == "observer" { add($1 "_" kind($2), $3, $4, $5) }
    $1 == "start" { if ($5 > start) start = $5 }
    $1 == "stack" { if ($3 > stack) stack = $3 }
    function kind(file) { sub(/-.*/, "", file); return file }
    END {
      for (key in count) printf "%s_mean %d\n%s_worst %d\n", key, sum[key] / count[key], key, worst[key]
      printf "first_sample %d\n", start
      if (stack > 0) printf "stack %d\n", stack
    }' | sort
}

# Instructions, then sizes. The observer in integers is counted where there is no floating point.
measure_mcu() {
  local target=$1 out='' program programs=(bench_steps)
  shift
  [[ $target != m3 ]] || programs+=(bench_fixed)
  for program in "${programs[@]}"; do
    out+=$(count_mcu "$target" "$program" "$@")$'\n' || {
      printf '%s\n' "$out" >&2
      return 1
    }
  done
  printf '%s\n' "$out" | mcu_sums
  arm-none-eabi-size "$root/build/mcu-$target/firmware/mcu/smaservo_mcu.elf" |
    awk 'NR == 2 { printf "text %d\ndata %d\nbss %d\n", $1, $2, $3 }'
}

# Steps at 1 kHz.
fast_mcu_files() {
  (cd "$(mcu_steps)" && printf '%s\n' loop-*.steps ordered-*.steps trace-150MPa.steps random-*.steps)
}

# What a test counts: seconds, not minutes.
few_mcu_files() { printf '%s\n' loop-wire-break.steps ordered-wire-break.steps random-1.steps; }

mcu_budget=$root/toolchain/mcu/budget.txt

# over_budget TARGET FILE: the lines of FILE, as measure_mcu makes them, that are more than 5 % above
# the budget; a key without one is fine, a budget without a key is not.
over_budget() {
  awk -v target="$1" '
    NR == FNR { if ($1 == target) budget[$2] = $3; next }
    { seen[$1] = 1; if ($1 in budget && $2 > 1.05 * budget[$1])
        { printf "%s: %s is %d, more than 5 %% above its budget of %d\n", target, $1, $2, budget[$1]; bad = 1 } }
    END {
      for (key in budget) if (!(key in seen)) { printf "%s: %s was not measured\n", target, key; bad = 1 }
      exit bad
    }' <(grep -v '^#' "$mcu_budget") "$2"
}

# The budget of a target, to be copied when it is meant to change.
budget_lines() { awk -v target="$1" '{ printf "%-4s %-28s %d\n", target, $1, $2 }' "$2"; }

check_mcu_budget() {
  local target=$1 measured=$root/build/mcu/$1.measured
  # shellcheck disable=SC2046 # several files
  measure_mcu "$target" $(few_mcu_files) >"$measured" || return
  if ! over_budget "$target" "$measured"; then
    printf 'If it is worth it, write these lines into %s:\n' "$mcu_budget"
    budget_lines "$target" "$measured"
    return 1
  fi
}

test_mcu() {
  local target
  write_mcu_steps && build_tree mcu-m0plus || return
  while read -r target; do
    build_tree "mcu-$target" && (cd "$root" && ctest --preset "mcu-$target") &&
      check_mcu_budget "$target" || return
  done < <(mcu_targets)
}

bench_mcu_keys() {
  cat <<'END'
model_mean|model step, mean
model_worst|- worst
observer_loop_mean|observer step, closed loops, mean
observer_loop_worst|- worst
observer_ordered_mean|observer step, ordered loops, mean
observer_ordered_worst|- worst
observer_trace_mean|observer step, trace, mean
observer_trace_worst|- worst
observer_random_mean|observer step, random use, mean
observer_random_worst|- worst
fixed_observer_mean|observer step in integers, mean
fixed_observer_worst|- worst
fixed_observer_ordered_mean|the same, ordered loops, mean
fixed_observer_ordered_worst|- worst
device_loop_mean|whole step, closed loops, mean
device_loop_worst|- worst
device_ordered_mean|whole step, ordered loops, mean
device_ordered_worst|- worst
device_trace_mean|whole step, trace, mean
device_trace_worst|- worst
device_random_mean|whole step, random use, mean
device_random_worst|- worst
first_sample|first sample, which starts the observer
stack|deepest stack of a step, bytes
text|the example's text
data|data
bss|bss
END
}

mcu_value() { awk -v key="$1" '$1 == key { print $2 }' "$root/build/mcu/$2.bench"; }

# mcu_ratio KEY TARGET: instructions by operations that the algorithm has in the same steps.
mcu_ratio() {
  local floor value
  floor=$(mcu_value "$1" operations)
  value=$(mcu_value "$1" "$2")
  [[ $2 != operations && -n $value ]] || { printf '%s' "$value" && return; }
  awk "BEGIN { printf \"%.2f\", $value / $floor }"
}

# mcu_table TITLE CELL COLUMN...: of the lines "KEY|text" that come in.
mcu_table() {
  local title=$1 cell=$2 key text column
  shift 2
  printf '\n| %s |' "$title"
  printf ' %s |' "$@"
  printf '\n|---|%s\n' "$(printf -- '--:|%.0s' "$@")"
  while IFS='|' read -r key text; do
    printf '| %s |' "$text"
    for column; do
      printf ' %s |' "$("$cell" "$key" "$column")"
    done
    printf '\n'
  done
}

run_bench_mcu() {
  run_setup
  write_mcu_steps
  local target
  # shellcheck disable=SC2046 # several files
  (cd "$(mcu_steps)" && "$root/build/release/tests/mcu/count_operations" $(fast_mcu_files)) |
    mcu_sums >"$root/build/mcu/operations.bench"
  while read -r target; do
    build "mcu-$target"
    say "counting instructions of $target"
    # shellcheck disable=SC2046 # several files
    measure_mcu "$target" $(fast_mcu_files) >"$root/build/mcu/$target.bench"
  done < <(mcu_targets)
  # shellcheck disable=SC2046 # several columns
  bench_mcu_keys | mcu_table 'instructions, bytes' mcu_value $(mcu_targets)
  # shellcheck disable=SC2046 # several columns
  bench_mcu_keys | grep -E '_(mean|worst)\|' |
    mcu_table 'instructions by operation' mcu_ratio operations $(mcu_targets)
}
