#!/usr/bin/env bash
# readme.sh BUILD: the lines of README.md's "A daemon, tuned over CAN", as they stand, with the
# programs of this build. Runs in a network of its own (own_network.sh).
set -euo pipefail

build=$1
cd "$(dirname "$0")/../.."
# shellcheck source=tests/patience.sh
. tests/patience.sh
work=$(mktemp -d)
daemon=''
end() {
  [[ -z $daemon ]] || kill "$daemon" 2>/dev/null || true
  rm -rf "$work"
}
trap end EXIT

ours=("$build/host-sim/host-sim" can --can udp --node 1)
is_there() {
  kill -0 "$daemon" || exit 1
  "$build/host-sim/host-sim" can --can udp scan 2>&1 | grep smaservo >/dev/null
}

lines=$(sed -n '/^## A daemon, tuned over CAN/,/^## /p' README.md | sed -n 's/^    //p')
[[ $(grep -c 'host-sim can --can udp' <<<"$lines") -ge 5 ]]
while IFS= read -r line; do
  line=${line//build\/release/$build}
  echo "+ $line"
  case $line in
    toolchain/dev\ build*)
      # What is in this build already; that there is such a command is what can go wrong.
      toolchain/dev build --help
      ;;
    toolchain/dev\ page*)
      # Until Ctrl-C; tests/host-sim/page/browser is the page.
      toolchain/dev page --help
      ;;
    *smaservod*\&)
      eval "${line%&} >$work/daemon 2>&1 &"
      daemon=$!
      becomes is_there
      ;;
    *\ watch)
      # Without an end: one row of it.
      eval "timeout $patience_s $line --count 1"
      ;;
    *)
      eval "timeout $patience_s $line"
      ;;
  esac
done <<<"$lines"

[[ $("${ours[@]}" get strain.proportional_W) == 0.5 ]]
position=$("${ours[@]}" get 6064)
echo "position $position um"
((position > 900 && position < 1100))
# Its log may come a tenth of a second later.
becomes grep -F 'bus: strain.proportional_W (2100h:1): 0 -> 0.5, by SDO' "$work/daemon"
