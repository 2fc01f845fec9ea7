#!/usr/bin/env bash
# examples.sh PROGRAM HOST_SIM [--write]: what the example prints is what host-sim/examples/README.md shows
# of it. With --write the README gets what it prints now.
set -euo pipefail

program=$(realpath "$1")
host_sim=$(realpath "$2")
root=$(cd "$(dirname "$0")/../.." && pwd)
readme=$root/host-sim/examples/README.md
name=${program##*/}
cd "$root"

# It is no program to be looked at by itself.
if [[ $name == 06_own_observer ]]; then
  printed=$("$host_sim" evaluate --wires tests/golden/evaluate --units 1 --runs 6 --row standard \
    --observer kalman --observer-program "$program" 2>/dev/null)
else
  printed=$("$program")
fi

# The README with what is given on standard input between the marks of this example.
readme_with() {
  awk -v name="$name" '
    NR == FNR { lines[NR] = $0; count = NR; next }
    $0 == "<!-- end of " name " -->" { inside = 0 }
    !inside { print }
    $0 == "<!-- " name ": -->" {
      inside = 1
      print ""
      for (i = 1; i <= count; ++i) print lines[i] == "" ? "" : "    " lines[i]
      print ""
    }' - "$readme"
}

now=$(readme_with <<<"$printed")
[[ ${3:-} != --write ]] || printf '%s\n' "$now" >"$readme"
grep -qxF "<!-- $name: -->" "$readme"
diff -u "$readme" - <<<"$now" || {
  echo "what $name prints has changed; once that is reviewed: $0 $program $host_sim --write" >&2
  exit 1
}
