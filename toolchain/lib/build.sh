# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# Building and replaying. Sourced by toolchain/dev.

# The part of a log that tells why: from the first error on, and the last lines.
show_end() {
  local log=$1 first
  first=$(grep -nEm 1 'error: |CMake Error|FAILED|\*\*\*' "$log" | cut -d: -f1) || :
  {
    printf -- '--- from %s\n' "$log"
    if [[ -n $first ]] && (($(wc -l <"$log") - first > 50)); then
      sed -n "$first,$((first + 30))p" "$log"
      printf -- '[...]\n'
      tail -n 15 "$log"
    else
      tail -n 50 "$log"
    fi
    printf -- '---\n'
  } >&2
}

# step NAME COMMAND...: runs quietly, with its output in build/logs/NAME.log; shows the end of it
# when the command fails.
step() {
  local name=$1
  shift
  mkdir -p "$logs"
  if ! "$@" >"$logs/$name.log" 2>&1; then
    say "failed: $name"
    show_end "$logs/$name.log"
    return 1
  fi
}

# build_tree PRESET [TARGET...]: configures what has changed, and builds; one at a time in each tree.
build_tree() {
  local preset=$1
  shift
  mkdir -p "$root/build"
  {
    flock 9
    (cd "$root" && cmake --preset "$preset" &&
      cmake --build --preset "$preset" --parallel "$(nproc)" ${1:+--target "$@"})
  } 9>"$root/build/$preset.lock"
}

# build PRESET [TARGET...]: quietly.
build() {
  say "building $1${2:+: ${*:2}}"
  step "$1-build" build_tree "$@"
}

# three_times COMMAND...: for downloads.
three_times() {
  local try
  for try in 1 2 3; do
    if "$@"; then return; fi
    say "download failed, try $try of 3: $*"
    sleep $((5 * (try - 1)))
  done
  return 1
}

# What the tests of the release need of npm's registry: the pages' packages, clients of others.
fetch_for_test() {
  local tree=$root/build/release page=$root/build/page
  three_times "$root/tests/npm.sh" "$root/tests/host-sim/page/node" "$tree/page-clients" true &&
    three_times "$root/tests/npm.sh" "$root/tests/host-sim/mcap" "$tree/mcap-library" true &&
    three_times page_is_built "$page"
}

page_is_built() {
  "$root/host-sim/page/build.sh" "$root/host-sim/page/front" "$1" "$(command -v npm)" "$(command -v node)" &&
    [[ -s $1/page.html && -s $1/report.js ]]
}

# What the other parts need of npm's registry and of Debian.
fetch_for_parts() {
  three_times install_clients && three_times sysroot arm64 aarch64-linux-gnu &&
    three_times sysroot armhf arm-linux-gnueabihf && three_times setup_board
}

near() { realpath --relative-to="$here" "$1"; }

value_of() { sed -nE "s/^$1 *= *\"(.*)\" *\$/\1/p" "$2" | head -n 1; }

# The command that replays a trace of the project, to be copied.
replay_command_of() {
  local scenario=$1 trace=${1%.toml}.csv
  local wire
  wire=$(value_of wire "$scenario")
  [[ $wire != *.toml ]] || wire=$(near "$(dirname "$scenario")/$wire")
  printf '%q replay --wire %q %q\n' "$(near "$root/toolchain/dev")" "$wire" "$(near "$trace")"
}

# list_traces FIRST: all but this one.
list_traces() {
  local scenario
  printf '\nThe other traces:\n'
  for scenario in "$root"/host-sim/traces/*.toml; do
    [[ -r ${scenario%.toml}.csv && ${scenario%.toml}.csv != "$1" ]] || continue
    printf '\n  %s\n    %s\n' "$(value_of note "$scenario")" "$(replay_command_of "$scenario")"
  done
  printf '\nAdd --report FILE.html for a report, --out FILE.csv for the estimate.\n'
}

# Every trace of the project: its report, and one row of a table.
replay_all() {
  local host_sim=$1 out=$2 scenario name wire
  printf '| trace | mean | 95 %% | maximum |\n|---|--:|--:|--:|\n'
  for scenario in "$root"/host-sim/traces/*.toml; do
    name=$(basename "$scenario" .toml)
    wire=$(value_of wire "$scenario")
    "$host_sim" replay --wire "$(dirname "$scenario")/$wire" --report "$out/$name.html" \
      "${scenario%.toml}.csv" |
      awk -v name="$name" '/^(kalman|model) / {
        printf "| %s | %s | %s | %s |%s\n", name, $2, $3, $4, $5 == "" ? "" : " " $5 }'
  done
  printf '\nError in %% of the nominal stroke. The reports are in %s.\n' "$(near "$out")"
}

run_build() {
  install_packages
  build release host-sim smaservod
}

# A servo on a simulated wire and the page before it, until Ctrl-C.
run_page() {
  install_packages
  build release host-sim smaservod
  local bus=udp:239.74.163.5%lo:$((20000 + $$ % 20000)) folder
  folder=$(mktemp -d)
  "$root/build/release/firmware/daemon/smaservod" --board sim --bus "$bus" --no-real-time \
    --settings "$folder" &
  # Whatever has ended the page, the servo ends, and nothing of it stays.
  # shellcheck disable=SC2064 # these now
  trap "kill $! 2>/dev/null || :; wait $! || :; rm -r '$folder'" EXIT
  if (($# == 0)) && [[ -n ${DISPLAY-}${WAYLAND_DISPLAY-} ]]; then
    (sleep 1 && xdg-open http://127.0.0.1:8765/) &
  fi
  "$root/build/release/host-sim/host-sim" page --can "$bus" "$@"
}

run_doc() {
  run_setup
  step documentation "$root/toolchain/library/documentation.py" "$root/build/doc" || return
  near "$root/build/doc/html/index.html"
}

# The one line is all that goes to the standard output, for: eval "$(toolchain/dev shell)"
run_shell() {
  install_packages
  build release host-sim smaservod smaservo-table
  shell_line "$root/build/release"
}

# shell_line BUILD: makes BUILD/shell, as the package lays out its files, and prints the line that puts it on the PATH.
shell_line() {
  local build=$1 shell=$1/shell page
  mkdir -p "$shell/bin" "$shell/man/man1" "$shell/man/man8"
  ln -sf "$build/host-sim/host-sim" "$build/firmware/daemon/smaservod" "$shell/bin"
  for page in host-sim.1 smaservod.8; do
    ln -sf "$root/toolchain/package/$page" "$shell/man/man${page##*.}/$page"
  done
  {
    printf '# Made by toolchain/dev shell.\nshell=%q\n' "$shell"
    # shellcheck disable=SC2016 # for the shell that reads it
    printf '%s\n' \
      'case :$PATH: in *:"$shell/bin":*) ;; *) export PATH="$shell/bin:$PATH" ;; esac' \
      'case :${MANPATH-}: in *:"$shell/man":*) ;; *) export MANPATH="$shell/man:${MANPATH-}" ;; esac' \
      'unset shell'
    # shellcheck disable=SC2016 # as well
    printf '[ -z "${BASH_VERSION-}" ] || . %q\n' "$root/toolchain/package/smaservo.bash"
  } >"$shell/activate.$$"
  mv "$shell/activate.$$" "$shell/activate"
  printf '. %q\n' "$shell/activate"
}

run_replay() {
  install_packages
  build release host-sim
  local host_sim=$root/build/release/host-sim/host-sim
  if [[ $* == --all ]]; then
    mkdir -p "$root/build/replay"
    replay_all "$host_sim" "$root/build/replay"
    return
  fi
  if (($#)); then
    "$host_sim" replay "$@"
    return
  fi
  local out=$root/build/replay trace=$root/host-sim/traces/150MPa.csv
  mkdir -p "$out"
  "$host_sim" replay --wire "$root/host-sim/traces/units/a.toml" --out "$out/estimate.csv" \
    --report "$out/report.html" "$trace"
  local report
  report=$(near "$out/report.html")
  printf '\nReport:   %s\nEstimate: %s\n' "$report" "$(near "$out/estimate.csv")"
  printf 'Open the report in any browser, for instance: xdg-open %q\n' "$report"
  list_traces "$trace"
}
