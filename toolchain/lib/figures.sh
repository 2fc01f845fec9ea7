# shellcheck shell=bash disable=SC2154 # root is set by toolchain/dev
# Pictures and measured tables of the READMEs. Sourced by toolchain/dev.

# figures [--list | NAME...]
run_figures() {
  [[ $* == --list ]] || run_setup
  "$root/toolchain/lib/figures.py" "$@"
}

check_figures() {
  "$root/toolchain/lib/old_figures.py" || {
    say '^ what the READMEs show is made anew by toolchain/dev figures; its --list has them all'
    return 1
  }
}
