# shellcheck shell=bash disable=SC2154 # root is set by toolchain/dev
# Builds what is measured. Sourced by toolchain/dev.

run_bench() {
  local -a programs=(model_bench count_steps replay_bench closed_loop_bench worst_steps)
  case ${1:-} in
    '' | tables) ;;
    identify) programs=(identify_bench) ;;
    *) die "bench: unknown: $1 (tables, identify, or nothing)" ;;
  esac
  run_setup
  build release "${programs[@]}"
  "$root/toolchain/lib/bench.py" "$@"
}
