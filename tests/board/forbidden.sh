#!/bin/sh
# What a service has no business with, tried one after the other: a line for each, with the answer. By a
# file's owner and mode each of them is allowed.
try() {
  what=$1
  shift
  if said=$("$@" 2>&1 >/dev/null); then
    echo "$what: allowed"
  else
    echo "$what: $(echo "$said" | head -n 1 | sed 's/.*: //')"
  fi
}
make_setuid() {
  file=$(mktemp)
  chmod u+s "$file"
}
try 'read a disk' head -c 1 /dev/forbidden
try 'write below /etc' cp /proc/version /etc/forbidden
try 'look into homes' ls /home
try "read another's /tmp" cat /tmp/forbidden
# shellcheck disable=SC2016 # perl's
try 'talk netlink' perl -e 'socket(my $s, 16, 3, 0) or die "perl: $!\n"'
# shellcheck disable=SC2016 # perl's
try 'send to an address' perl -MSocket -e 'socket(my $s, AF_INET, SOCK_DGRAM, 0) or die "perl: $!\n";
  send($s, "x", 0, sockaddr_in(9, INADDR_LOOPBACK)) or die "perl: $!\n"'
try 'make a namespace' unshare -U true
try 'make a file set-user-ID' make_setuid
try 'open its GPIO' head -c 0 /dev/gpiochip0
