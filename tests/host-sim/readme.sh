#!/usr/bin/env bash
# readme.sh BUILD: every line of README.md's code blocks, as it stands, with the programs of this build,
# in a folder of their own. Not those blocks that the README marks: <!-- not run: WHY -->. The recordings
# that it names are shipped traces. Of toolchain/dev only that there is such a command; `toolchain/dev
# test` runs the parts themselves. `toolchain/dev shell` is what it is after its build.
set -euo pipefail

build=$(realpath "$1")
root=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Lines that are indented by four, or in a list by eight.
lines=$(awk '
  /^ *<!-- .*not run/ { skipped = 1; next }
  /^ *[0-9]+[.] / { block = 8 }
  /^#/ { block = 4 }
  block == 0 { block = 4 }
  match($0, /^ */) && RLENGTH >= block && NF { if (!skipped) print substr($0, block + 1); inside = 1; next }
  NF && inside { skipped = 0; inside = 0 }
' "$root/README.md")

cd "$work"
ln -s "$root/host-sim" host-sim
# A wire of 120 mm, as the README's: the shipped one has 100.6 mm.
longer() {
  awk -F, -v OFS=, 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == "voltage_V") v = i } NR > 1 { $v *= 120 / 100.6 } 1' \
    "host-sim/traces/$1MPa.csv"
}
longer 50 >trace.csv
for run in 10 50 150 400; do
  longer "$run" | awk 'NR < 4002' >"run-${run}MPa.csv"
done

[[ $(grep -c '^host-sim ' <<<"$lines") -ge 7 ]]
[[ $(grep -c '^toolchain/dev ' <<<"$lines") -ge 2 ]]
help=$("$root/toolchain/dev" --help)
# A line that ends in a backslash goes on in the next one, which is what read does without -r.
# shellcheck disable=SC2162
while read line; do
  echo "+ $line"
  # shellcheck disable=SC2016 # the line as it stands
  if [[ $line == 'eval "$(toolchain/dev shell)"' ]]; then
    eval "$("$root/toolchain/dev" 'do' shell_line "$build")"
    [[ $(command -v host-sim) == "$build/shell/bin/host-sim" && $(complete -p smaservod) == *_smaservo* ]]
    continue
  fi
  if [[ $line == toolchain/dev\ * ]]; then
    read -r _ command _ <<<"$line"
    grep -qE "^  $command( |$)" <<<"$help"
    continue
  fi
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
