# Sourced by the scripts of guests: the daemon with a simulated wire on a bus, and questions to it.
# shellcheck shell=sh

# sim_servo INTERFACE NODE [COMMAND...]: started by the command. /tmp/status.NODE, /tmp/daemon.NODE
sim_servo() {
  interface=$1
  node=$2
  shift 2
  {
    cat ../can/device.toml
    printf '\n[identity]\nnode_id = %d\n' "$node"
  } >"/tmp/device.$node"
  "$@" /smaservod --board sim --bus "$interface" --device "/tmp/device.$node" \
    --status "/tmp/status.$interface" --json >"/tmp/figures.$interface" 2>"/tmp/daemon.$interface" &
  export servo=$!
}

identifier() { printf %x $(($1 + $2)); }

# hears INTERFACE IDENTIFIER COMMAND...: the bytes of the next frame while the command runs.
hears() {
  candump -T 2000 -n 1 "$1,$2:7FF" >/tmp/heard &
  listener=$!
  shift 2
  sleep 0.1
  "$@"
  wait $listener
  tr -s ' ' </tmp/heard | cut -d ' ' -f 5-
}
# ask INTERFACE NODE REQUEST: the answer's bytes.
ask() { hears "$1" "$(identifier 0x580 "$2")" cansend "$1" "$(identifier 0x600 "$2")#$3"; }
# number INTERFACE NODE REQUEST: of four bytes or two.
number() {
  # shellcheck disable=SC2046 # eight words
  set -- $(ask "$@")
  echo $((0x${8:-0}${7:-0}${6:-0}${5:-0}))
}
statusword() { number "$1" "$2" 40.41.60.00.00.00.00.00; }

# enable_drive INTERFACE NODE: the state that it comes to, 39 (27h): Operation enabled.
enable_drive() {
  ask "$1" "$2" 2F.60.60.00.01.00.00.00 >/dev/null
  for word in 80 00 06 07 0F; do
    ask "$1" "$2" 2B.40.60.00.$word.00.00.00 >/dev/null
  done
  sleep 0.3
  echo $(($(statusword "$1" "$2") & 0x6f))
}
# What the daemon says of itself, written once a second.
status_of() { sed -n "s/.*\"$2\":\[*\"*\([^],\"]*\).*/\1/p" "/tmp/status.$1"; }
