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

# on_one_processor COMMAND...: becomes a daemon's process with a simulated wire. Its loop's time stands still while it
# waits for a processor; without the thread that brings it commands, which would wait on another one, it has
# command_timeout after 0.1 s.
on_one_processor() {
  local allowed
  allowed=$(sed -nE 's/^Cpus_allowed_list:\t([0-9]+).*/\1/p' /proc/self/status)
  exec taskset --cpu-list "$allowed" "$@"
}
