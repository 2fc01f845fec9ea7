# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# Independent CAN clients. Sourced by toolchain/dev.

# npm's clients, built against the headers beside node; only where they are not there yet.
install_clients() {
  local clients=$1 wanted=$root/tests/can/node
  command -v npm >/dev/null || apt_get install --no-install-recommends npm || return
  mkdir -p "$clients"
  if [[ -d $clients/node_modules/socketcan/build ]] &&
    cmp -s "$wanted/package-lock.json" "$clients/package-lock.json"; then
    return
  fi
  cp "$wanted/package.json" "$wanted/package-lock.json" "$clients/"
  local headers
  headers=$(dirname "$(dirname "$(readlink -f "$(command -v node)")")")
  (cd "$clients" && npm_config_nodedir=$headers npm ci --no-audit --no-fund --ignore-scripts &&
    npm_config_nodedir=$headers npm rebuild --ignore-scripts=false &&
    [[ -d node_modules/socketcan/build ]])
}

# npm's MCAP library, likewise; a release test without it says SKIPPED.
install_mcap_library() {
  local library=$root/build/mcap-library wanted=$root/tests/host-sim/mcap
  command -v npm >/dev/null || apt_get install --no-install-recommends npm || return
  if [[ -d $library/node_modules/@mcap/core ]] &&
    cmp -s "$wanted/package-lock.json" "$library/package-lock.json"; then
    return
  fi
  mkdir -p "$library"
  cp "$wanted/package.json" "$wanted/package-lock.json" "$library/"
  (cd "$library" && npm ci --no-audit --no-fund --ignore-scripts)
}

# The kernel that clients and tests run on: where User-Mode Linux cannot, that of the boards.
setup_guest() {
  [[ -f $board/amd64/RELEASE ]] || "$root/toolchain/can/uml" 60 true >/dev/null 2>&1 || setup_board
}

# A minute and a half on a machine that does nothing else; the limit is for one that does.
can_session() {
  (cd "$root" && toolchain/can/uml 1200 tests/can/session.sh "$root/build/release" "$1")
}

can_test() {
  local clients=$root/build/can-clients
  build release host-sim smaservod || return
  step can-clients install_clients "$clients" || return
  setup_guest || return
  local start=$SECONDS
  took can-session can_session "$clients" || return
  counted="sessions of $((SECONDS - start)) s"
}

run_can_test() {
  run_setup
  can_test
  say "$counted"
}
