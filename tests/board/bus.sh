#!/bin/sh
# Daemons on two SJA1000 controllers, one bus: rates, a full queue, bus-off, down and up, two nodes,
# two of the same node-id.
# shellcheck source=tests/board/rig.sh
. ./rig.sh
# shellcheck source=tests/board/sim_servo.sh
. ./sim_servo.sh
ip=/usr/sbin/ip
enabled=39
device_type='43 00 10 00 92 01 02 00'

for rate in 1000000 125000 500000; do
  for interface in can0 can1; do
    $ip link set $interface down
    $ip link set $interface up type can bitrate $rate restart-ms 100
  done
  expect 'bit rate' "$($ip -details link show can0 | sed -n 's/.*bitrate \([0-9]*\) .*/\1/p')" $rate
  expect "at $rate bit/s" "$(hears can1 123 cansend can0 123#BEEF)" 'BE EF'
done

echo '-- two nodes'
# Its bus goes before the controller's interrupt: the queue fills.
interrupt=$(grep -l '^irq/[0-9]*-can0$' /proc/[0-9]*/comm | cut -d / -f 3)
chrt -f -p 30 "$interrupt"
expect 'priority of the interrupt' "$(chrt -p "$interrupt" | sed -n 's/.*priority: //p')" 30
sim_servo can0 1
sim_servo can1 2
second=$servo
sleep 1
expect 'node 1' "$(ask can1 1 40.00.10.00.00.00.00.00)" "$device_type"
expect 'node 2' "$(ask can0 2 40.00.10.00.00.00.00.00)" "$device_type"
cansend can1 7E5#04.01.00.00.00.00.00.00
expect 'LSS: another bit rate' "$(hears can1 7E4 cansend can1 7E5#13.00.02.00.00.00.00.00)" \
  '13 01 00 00 00 00 00 00'
cansend can1 7E5#04.00.00.00.00.00.00.00

echo '-- a full queue'
expect 'its length' "$(cat /sys/class/net/can0/tx_queue_len)" 10
ask can1 1 A4.21.10.00.7F.00.00.00 >/dev/null
candump -T 500 -n 127 can1,581:7FF >/tmp/block &
block=$!
sleep 0.1
sent=/sys/class/net/can0/statistics/tx_packets
before=$(cat $sent)
cansend can1 601#A3.00.00.00.00.00.00.00
wait $block
expect 'frames of a block of 127' $(($(cat $sent) - before)) 127
# The emulated bus takes no time: the other controller, which holds five, misses some of them.
expect 'in their order' "$(awk '$4 < last { n++ } { last = $4 } END { print n + 0 }' /tmp/block)" 0
cansend can1 601#80.21.10.00.00.00.00.08
expect 'frames dropped' "$(number can1 1 40.11.22.01.00.00.00.00)" 0
# Of 127 frames at least ten times ten and one wait in the queue; each refusal is an ENOBUFS.
within 'ENOBUFS that the daemon has met' "$(number can1 1 40.11.22.03.00.00.00.00)" 8 127

echo '-- bus-off'
expect 'enabled' "$(enable_drive can1 1)" $enabled
sleep 1.1
within 'current, A' "$(status_of can0 drive_current_A)" 0.005 0.4
expect 'EMCY of bus-off' "$(hears can1 081 cansend can0 20000040#0000000000000000 | cut -c 1-5)" '40 81'
sleep 1.1
expect 'current, A' "$(status_of can0 drive_current_A)" 0.0
expect 'first cause' "$(status_of can0 first_cause)" bus_lost
expect 'Fault' $(($(statusword can1 1) & 0x4f)) 8
cansend can0 20000100#0000000000000000
sleep 0.2
expect 'times off' "$(number can1 1 40.11.22.02.00.00.00.00)" 1
expect 'enabled again' "$(enable_drive can1 1)" $enabled

echo '-- down and up'
$ip link set can0 down
sleep 1.3
expect 'current, A' "$(status_of can0 drive_current_A)" 0.0
expect 'first cause' "$(status_of can0 first_cause)" bus_lost
$ip link set can0 up
sleep 0.3
expect 'node 1 is back' "$(ask can1 1 40.00.10.00.00.00.00.00)" "$device_type"
expect 'enabled again' "$(enable_drive can1 1)" $enabled

echo '-- two of one node-id'
kill "$second"
wait "$second"
ask can1 1 2B.17.10.00.64.00.00.00 >/dev/null
sim_servo can1 1
sleep 2.2
expect 'the one that was there' "$(status_of can0 first_cause)" duplicate_node
expect 'its current, A' "$(status_of can0 drive_current_A)" 0.0
expect 'the other one' "$(status_of can1 blocks)" duplicate_node
cat /tmp/daemon.*
finish
