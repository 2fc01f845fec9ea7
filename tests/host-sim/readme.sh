#!/usr/bin/env bash
# readme.sh BUILD: the lines of README.md's "Your own trace" and "A servo", as they stand, with the
# programs of this build, in a folder of their own. The recordings that they name are shipped traces.
set -euo pipefail

build=$(realpath "$1")
root=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

section() { sed -n "/^## $1\$/,/^## /p" "$root/README.md" | sed -n 's/^    //p'; }

cd "$work"
mkdir -p build
ln -s "$build" build/release
ln -s "$root/host-sim" host-sim
cp host-sim/traces/50MPa.csv trace.csv
for run in 50:50 150:200 300:400; do
  head -n 4001 "host-sim/traces/${run#*:}MPa.csv" >"run-${run%:*}MPa.csv"
done

lines=$(section 'Your own trace' && section 'A servo')
[[ $(grep -c '^build/release/host-sim/host-sim ' <<<"$lines") -ge 6 ]]
# A line that ends in a backslash goes on in the next one, which is what read does without -r.
# shellcheck disable=SC2162
while read line; do
  echo "+ $line"
  eval "$line" >output 2>&1 || {
    cat output
    echo "failed: $line" >&2
    exit 1
  }
done <<<"$lines"

for made in report.html estimate.csv fit.html mine.toml log.csv loop.html tune.html; do
  [[ -s $made ]] || {
    echo "$made was not written" >&2
    exit 1
  }
done
