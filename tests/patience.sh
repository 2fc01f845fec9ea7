# shellcheck shell=bash
# Sourced by live tests: tests/patience.hpp says it of C++.

patience_s=600

# becomes COMMAND...: waits until it succeeds. Only what hangs takes so long that it gives up.
becomes() {
  local until=$((SECONDS + patience_s))
  until "$@"; do
    ((SECONDS < until)) || {
      echo "in vain: $*" >&2
      return 1
    }
    sleep 0.05
  done
}
