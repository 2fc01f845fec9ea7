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
  # Addresses are usable at once: nobody else can have them.
  echo 0 >/proc/sys/net/ipv6/conf/$end/accept_dad
  ip link set $end up
done
ip address add 10.77.0.1/24 dev here
ip route add 224.0.0.0/4 dev here
exec "$@"
