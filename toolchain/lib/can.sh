# shellcheck shell=bash disable=SC2154 # root and logs are set by toolchain/dev
# Independent CAN clients. Sourced by toolchain/dev.

clients=$root/build/can-clients

# npm's clients, built against the headers beside node; only where they are not there yet.
install_clients() {
  local wanted=$root/tests/can/node
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

# The kernel that clients and tests run on: where User-Mode Linux cannot, that of the boards.
setup_guest() {
  "$root/toolchain/can/uml" 600 true >/dev/null 2>&1 || setup_board
}

run_can_test() {
  run_setup
  step kernels setup_guest && build release host-sim smaservod can_socket_tests && step can-clients install_clients &&
    (cd "$root" && ctest --preset can)
}
