#!/usr/bin/env bash
# long_report.sh BUILD [SECONDS]: the reports of a closed loop of 6000 s at 1 kHz, 6 million rows, and of
# the replay of its trace; what each takes, and how large it is. Fails above 10 MB.
set -euo pipefail

host_sim=$(realpath "$1")/host-sim/host-sim seconds=${2:-6000}
scenarios=$(realpath "$(dirname "$0")/../../host-sim/scenarios")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp -r "$scenarios/devices" "$work/"
sed "s/^for_s = 20$/for_s = $seconds/" "$scenarios/steps.toml" >"$work/long.toml"

made() {
  local name=$1 begin=$SECONDS size
  shift
  "$host_sim" "$@" --report "$work/$name.html" >/dev/null
  size=$(stat -c %s "$work/$name.html")
  printf '%-10s %4d s %4d.%02d MB\n' "$name" $((SECONDS - begin)) $((size / 1000000)) $((size / 10000 % 100))
  ((size < 10000000))
}

made simulate simulate --scenario "$work/long.toml" --out "$work/log.csv"
made replay replay --observer kalman "$work/log.csv"
printf '%-10s %d rows\n' trace $(($(wc -l <"$work/log.csv") - 1))
