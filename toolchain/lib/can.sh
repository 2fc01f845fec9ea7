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

# A minute and a half on a machine that does nothing else; the limit is for one that does.
can_session() {
  (cd "$root" && toolchain/can/uml 600 tests/can/session.sh "$root/build/release" "$1")
}

can_test() {
  local clients=$root/build/can-clients
  build release host-sim smaservod || return
  step can-clients install_clients "$clients" || return
  local start=$SECONDS
  can_session "$clients" || return
  counted="sessions of $((SECONDS - start)) s"
}

run_can_test() {
  run_setup
  can_test
  say "$counted"
}
