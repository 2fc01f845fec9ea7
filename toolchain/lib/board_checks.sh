# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev; board by board.sh
# What runs on the emulated board. Sourced by toolchain/dev.

# NAME|what it is; the longest first, as two run at a time
board_checks() {
  cat <<'END'
guest|exit codes come back, a hang and silence are failures
END
}

build_for_board() { build release board_programs; }

board_check_guest() {
  local expected code
  image amd64 guest '' || return
  for expected in 0 7; do
    guest amd64 real guest guest 60 exit "$expected" 2>/dev/null
    code=$?
    ((code == expected)) || { say "exit $expected came back as $code"; return 1; }
  done
  guest amd64 real guest guest 60 exit silent 2>/dev/null
  code=$?
  ((code == 125)) || { say "silence came back as $code"; return 1; }
  guest amd64 real guest guest 8 exit hang 2>/dev/null
  code=$?
  ((code == 124)) || { say "a hang came back as $code"; return 1; }
}
