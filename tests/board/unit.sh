# Sourced by the scripts of guests under systemd: the service, who talks to it, and its board.
# shellcheck shell=sh disable=SC2034 # for those
# shellcheck source=tests/board/rig.sh
. ./rig.sh
export LC_ALL=C DEBIAN_FRONTEND=noninteractive

unit() { systemctl show -P "$1" smaservod; }
journal() { journalctl -q -u smaservod -o cat --since "@${since:-0}"; }
client() { host-sim can --can can1 --node 1 "$@"; }
bitrate() { ip -details link show can0 | sed -n 's/.*bitrate \([0-9]*\) .*/\1/p'; }
duty() { cat "$(pwm_chip)/pwm0/duty_cycle"; }

make_board() {
  modprobe configfs
  mountpoint -q /sys/kernel/config || mount -t configfs c /sys/kernel/config
  make_inputs
}

# What /etc holds beside the board's own files.
etc() { find /etc -path /etc/smaservo -prune -o -type f -exec md5sum {} +; }

# Of the plant, in a place that a boot leaves alone.
log=/var/tmp/plant.log
by() { sed -n 's/^OFF .* by=\([a-z-]*\): .*/\1/p' $log; }
off_us() { sed -n 's/^OFF after_us=\([^ ]*\) .*/\1/p' $log; }
# row WHAT: of the table of stops.
: >/tmp/stops
row() { echo "| $1 | $(by) | $(off_us) |" >>/tmp/stops; }
# off_by WHO MOST_US
off_by() {
  cat $log
  within 'off after, us' "$(off_us)" 1 "$2"
  expect 'by' "$(by)" "$1"
}

# heats PATH VALUE [SECONDS]: the wire is moved over the bus and held, and at 8 s the value is written
# there.
# $plant_in: what the plant runs in
heats() {
  since=$(date +%s)
  ${plant_in:-} /plant /tmp/hold.toml "${3:-12}" 8 "$1" "$2" >$log &
  plant=$!
  sleep 0.2
  systemctl start smaservod
  unit MainPID >/tmp/daemon
  client reset-faults >/dev/null
  client enable && client move 800
  expect 'arms and moves over the bus' $? 0
  client hold >/dev/null 2>&1 & # until the servo has gone
  before=$(unit NRestarts)
}

# At 8 s of "heats $told 1" this is done.
told=/tmp/now
when_told() {
  [ -p $told ] || mkfifo $told
  (
    read -r _ <$told
    "$@"
  ) &
}
