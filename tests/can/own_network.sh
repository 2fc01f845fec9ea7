#!/usr/bin/env bash
# own_network.sh COMMAND ...: runs it in a network of its own, in which multicast reaches nobody
# else. Its ends are one pair of virtual Ethernet interfaces.
set -euo pipefail

if [[ ${1:-} != --inside ]]; then
  flags=--net
  ((EUID == 0)) || flags='--net --user --map-root-user'
  # shellcheck disable=SC2086 # several words
  exec unshare $flags -- bash "${BASH_SOURCE[0]}" --inside "$@"
fi
shift
ip link set lo up
ip link add here type veth peer name there
for end in here there; do
  # Addresses are usable without a search for others who have them: there are none.
  echo 0 >/proc/sys/net/ipv6/conf/$end/accept_dad
  ip link set $end up
done
# The kernel gives the ends their addresses a moment later, or much later where it is busy. Without
# them nothing can be sent to the group of the bus.
for end in here there; do
  for ((tries = 0; tries < 2000; ++tries)); do
    [[ -z $(ip -6 -oneline address show dev $end scope link) ]] || break
    sleep 0.005
  done
done
ip address add 10.77.0.1/24 dev here
ip route add 224.0.0.0/4 dev here
exec "$@"
