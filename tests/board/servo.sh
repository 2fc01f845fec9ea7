# Sourced by the scripts of guests: the daemon with its wire.
# shellcheck shell=sh disable=SC2154 # rig.sh

# servo SECONDS [TIME PATH VALUE]...: the daemon holds a strain while the plant lets things happen.
# /tmp/daemon.log, /tmp/plant.log, /tmp/status.json and the daemon's exit code.
servo() {
  rm -f /tmp/status.json
  /plant hold.toml "$@" >/tmp/plant.log &
  plant=$!
  # The daemon's first readings are of this wire.
  while ! grep -q READY /tmp/plant.log && kill -0 $plant; do sleep 0.01; done
  # shellcheck disable=SC2086 # several arguments
  /smaservod --board board.toml --program hold.toml --status /tmp/status.json --json \
    ${daemon_arguments:-} >/tmp/figures.json 2>/tmp/daemon.log &
  daemon=$!
  echo "$daemon" >/tmp/daemon
  wait $plant
  kill -CONT "$daemon" 2>/dev/null
  kill "$daemon" 2>/dev/null
  wait "$daemon"
  export daemon_code=$?
  sed 's/^/plant: /' /tmp/plant.log
  sed 's/^/daemon: /' /tmp/daemon.log
}

held_strain() { sed -n 's/^PLANT strain_percent=\([^ ]*\).*/\1/p' /tmp/plant.log; }
stop_us() { sed -n 's/^OFF after_us=\([^ ]*\) .*/\1/p' /tmp/plant.log; }
stopped_by() { sed -n 's/^OFF .* by=\([a-z-]*\): .*/\1/p' /tmp/plant.log; }
first_cause() { sed -n 's/.*"first_cause":"\([a-z_]*\)".*/\1/p' /tmp/figures.json; }
