# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# Measures the speed and prints it as Markdown. Sourced by toolchain/dev.

# KIND|what the table calls it|most instructions that it may take
bench_rows() {
  cat <<'END'
ihyp_inverse|ihyp inverse|
ihyp_inverse_cardano|ihyp inverse by Cardano's formula|
ihyp_inverse_newton|ihyp inverse by Newton's method|
cosine_step|two-phase cosine step, 20..110 °C|
cosine_step_converting|two-phase cosine step, only while it converts|
model_step_cut|model step, constant stress|250
model_step_cut:heating|- its heating half|
model_step_cut:cooling|- its cooling half|
model_step_constant_stress|model step, constant stress, surfaces not cut before|
model_step_varying_stress|model step, varying stress|
duhem_step|Duhem step (001)|
liang_rogers_step|Liang-Rogers step (002)|
preisach_step|Preisach step (003), constant stress|
preisach_step_varying_stress|Preisach step (003), varying stress|
plant_step|plant step (model and heat balance)|
wire_step_ihyp|simulated wire, ihyp: 1 ms, strain and resistance|
wire_step_sublayers|simulated wire, sublayers: the same|
wire_step_free-energy|simulated wire, free energy: the same|
observer_step|observer step|1500
multiple_model_step|observer step of the multiple-model filter|
control_step|controller's step, closed loop in strain|700
device_step|whole step of the device|4000
strain_resistance_step|stress-strain-resistance step (002)|
END
}

# count DIRECTORY KIND/SCALAR PART: instructions of so many steps, as "KIND[:PART]/SCALAR steps
# instructions" in a file of its own.
count_steps() {
  local bin=$1 kind=$2 part=$3 out=$4
  local name=$kind
  [[ $part == all ]] || name=${kind%/*}:$part/${kind#*/}
  local log=$out/count-${name//\//-}
  valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect=counted_steps \
    "$bin/count_steps" "$kind" "$part" >"$log.steps" 2>"$log.log"
  awk -v name="$name" -v steps="$(<"$log.steps")" \
    '/Collected/ { print name, steps, $NF }' "$log.log" >"$log.count"
}

count_all() {
  local bin=$1 out=$2 kind part
  local -a jobs=()
  rm -f "$out"/count-*
  while read -r kind; do
    jobs+=("$kind" all)
    if [[ $kind == model_step_cut/* || $kind == empty/* ]]; then
      jobs+=("$kind" heating "$kind" cooling)
    fi
  done < <("$bin/count_steps")
  export -f count_steps
  # shellcheck disable=SC2016 # expanded by the inner shell
  printf '%s\0' "${jobs[@]}" |
    xargs -0 -n 2 -P "$(nproc)" bash -c 'count_steps "$1" "$3" "$4" "$2"' - "$bin" "$out"
}

# The numbers of a Google Benchmark JSON file as "NAME FIELD VALUE" lines.
bench_fields() {
  awk -F'": ' '
    /^ *"name": / { name = $2; gsub(/[",]/, "", name); sub(/\/(iterations|real_time).*/, "", name) }
    /^ *"(real_time|cpu_time|items_per_second|bytes_per_second|worst_relative_error|times_real_time|file_bytes)": / {
      field = $1; gsub(/[ "]/, "", field); value = $2; sub(/,.*/, "", value)
      print name, field, value
    }' "$@"
}

steps_table() {
  local out=$1
  bench_rows | awk -F'|' -v fields="$out/fields" -v counts="$out/counts" '
    BEGIN {
      while ((getline line < fields) > 0) { split(line, f, " "); value[f[1], f[2]] = f[3] }
      while ((getline line < counts) > 0) { split(line, f, " "); per[f[1]] = f[3] / f[2] }
      print "| step | float | double | instructions, float | double | target |"
      print "|---|--:|--:|--:|--:|--:|"
    }
    function time(kind) { return value[kind, "cpu_time"] }
    function ns(kind) { return time(kind) == "" ? "" : sprintf("%.1f ns", time(kind)) }
    function instructions(kind, scalar) {
      if (per[kind "/" scalar] == "") return ""
      return sprintf("%.0f", per[kind "/" scalar] - per["empty/" scalar])
    }
    function step(kind, title, most) {
      printf "| %s | %s | %s | %s | %s | %s |\n", title, ns(kind "/float"), ns(kind "/double"),
        instructions(kind, "float"), instructions(kind, "double"), most == "" ? "" : "<= " most " instructions"
      listed[kind] = 1
    }
    { step($1, $2, $3) }
    function twice(title, format, a, b, target) {
      printf "| %s | " format " | " format " | | | %s |\n", title, a, b, target
    }
    END {
      for (name in per) {
        kind = name
        if (sub("/double$", "", kind) && kind !~ "^empty" && !(kind in listed)) {
          step(kind, kind " (has no row in bench_rows)", "")
        }
      }
      twice("473 000 model points", "%.1f ms", time("ModelPoints473000/float"),
        time("ModelPoints473000/double"), "< 25 ms")
      twice("model step by converting cosine step", "%.1f",
        time("model_step_cut/float") / time("cosine_step_converting/float"),
        time("model_step_cut/double") / time("cosine_step_converting/double"), "<= 3")
    }'
}

error_table() {
  awk '
    $2 == "worst_relative_error" { error[$1] = $3 }
    END {
      print "| ihyp inverse, worst relative error of the smaller of x and 1 - x in 20 000 cases | float | double |"
      print "|---|--:|--:|"
      row("ours", "ihyp_inverse")
      row("Cardano", "ihyp_inverse_cardano")
      row("Newton", "ihyp_inverse_newton")
    }
    function row(title, name) {
      printf "| %s | %.1e | %.1e |\n", title, error[name "_error/float"], error[name "_error/double"]
    }' "$1/fields"
}

replay_table() {
  awk '
    { value[$1, $2] = $3 }
    END {
      print "| 1 000 000 rows | rows/s | MB/s | target |"
      print "|---|--:|--:|--:|"
      row("replay, Kalman filter, all columns written", "replay/kalman", ">= 1.5 M rows/s")
      row("the same, written as MCAP", "replay/mcap", "")
      row("replay, straight line, all columns written", "replay/line", "")
      row("bare read of the same file", "bare_read", "")
    }
    function row(title, name, target) {
      printf "| %s | %.2f M | %.0f | %s |\n", title, value[name, "items_per_second"] / 1e6,
        value[name, "bytes_per_second"] / 1e6, target
    }' "$1/fields"
}

trace_table() {
  awk '
    { value[$1, $2] = $3 }
    END {
      print "| 1 000 000 rows of five columns | written, rows/s | read, rows/s | file, MB |"
      print "|---|--:|--:|--:|"
      row("CSV", "csv")
      row("MCAP", "mcap")
    }
    function row(title, name) {
      printf "| %s | %.2f M | %.2f M | %.1f |\n", title, value["write/" name, "items_per_second"] / 1e6,
        value["read/" name, "items_per_second"] / 1e6, value["write/" name, "file_bytes"] / 1e6
    }' "$1/fields"
}

loop_table() {
  awk '
    { value[$1, $2] = $3 }
    END {
      print "| the device closed on a simulated wire, 1 kHz, one core | times real time | target |"
      print "|---|--:|--:|"
      row("lumped", ">= 2000")
      row("ihyp", ">= 500")
      row("sublayers", ">= 500")
    }
    function row(plant, target) {
      printf "| %s | %.0f | %s |\n", plant, value["closed_loop/" plant, "times_real_time"], target
    }' "$1/fields"
}

fit_table() {
  awk '
    { value[$1, $2] = $3 }
    END {
      print "| identification of a wire, runs of 60 s at 1 kHz | 1 | 2 | 4 | 8 | target |"
      print "|---|--:|--:|--:|--:|--:|"
      row(1, "")
      row(2, "8 runs < 60 s")
    }
    function row(threads, target, runs) {
      printf "| %d thread%s |", threads, (threads > 1 ? "s" : "")
      for (runs = 1; runs <= 8; runs *= 2)
        printf " %.1f s |", value["identify/runs:" runs "/threads:" threads, "real_time"] / 1e3
      printf " %s |\n", target
    }' "$1/fields"
}

# The cost of single steps: times of all of them, and instructions of those that took longest.
worst_table() {
  local bin=$1 out=$2
  "$bin/worst_steps" "$out/costliest"
  rm -f "$out/costliest.callgrind"
  # Without what the loader does at the first call of a function.
  LD_BIND_NOW=1 valgrind --tool=callgrind --toggle-collect=counted_step --dump-after=counted_step \
    --combine-dumps=yes --callgrind-out-file="$out/costliest.callgrind" \
    "$bin/worst_steps" count "$out/costliest" 2>"$out/costliest.log"
  printf '\n'
  awk '/^totals: / && $2 > 0 { print $2 }' "$out/costliest.callgrind" | sort -n | awk '
    { count[NR] = $1 }
    END {
      print "| instructions of those that took longest, beyond the first sample | least | median | most |"
      print "|---|--:|--:|--:|"
      printf "| %d steps | %d | %d | %d |\n", NR, count[1], count[int((NR + 1) / 2)], count[NR]
    }'
}

# measure FOLDER BENCH...: with Google Benchmark, into FOLDER/fields.
measure() {
  local out=$1 bench
  local -a made=()
  shift
  mkdir -p "$out"
  for bench; do
    say "running $bench"
    step "$bench" "$root/build/release/tests/bench/$bench" --benchmark_out="$out/$bench.json" \
      --benchmark_out_format=json
    made+=("$out/$bench.json")
  done
  bench_fields "${made[@]}" >"$out/fields"
}

run_bench() {
  local bin=$root/build/release/tests/bench out=$root/build/bench
  [[ -z ${1:-} || $1 == identify ]] || die "bench: unknown: $1 (identify, or nothing)"
  run_setup
  if [[ ${1:-} == identify ]]; then
    build release identify_bench
    measure "$out" identify_bench
    fit_table "$out"
    return
  fi
  build release model_bench count_steps replay_bench closed_loop_bench worst_steps
  measure "$out" model_bench replay_bench closed_loop_bench
  say "counting instructions"
  count_all "$bin" "$out"
  cat "$out"/count-*.count >"$out/counts"
  printf 'Time, and instructions per step by callgrind. %s, %s:\n\n' \
    "$(sed -nE 's/^model name\s*: //p' /proc/cpuinfo | head -n 1)" "$(g++ --version | head -n 1)"
  steps_table "$out"
  printf '\n'
  error_table "$out"
  printf '\n'
  replay_table "$out"
  printf '\n'
  trace_table "$out"
  printf '\n'
  loop_table "$out"
  printf '\n'
  worst_table "$bin" "$out"
}
