#!/bin/sh
# load.sh SECONDS: what a servo answers while its master asks much of it, and whether its loop minds.
# By their priorities the loop goes before the master, and that before the bus of the servo.
# shellcheck source=tests/board/rig.sh
. ./rig.sh
# shellcheck source=tests/board/sim_servo.sh
. ./sim_servo.sh
/usr/sbin/ip link add vcan0 type vcan
/usr/sbin/ip link set vcan0 up
sim_servo vcan0 1
sleep 1
chrt -f 60 /load vcan0 1 "$1" >/tmp/load
expect 'answers in time, nothing lost' $? 0
cat /tmp/load
kill "$servo"
wait "$servo"
figures=/tmp/figures.vcan0
count() { sed -n "s/.*\"$1\":\([0-9.]*\).*/\1/p" $figures; }
figure() { sed -n "s/.*\"$1\":{[^}]*\"$2\":\([0-9.]*\).*/\1/p" $figures; }
expect 'cycles of the loop that were missed' "$(count missed)" 0
first() { sed -n "s/^LOAD $1 \([0-9]*\).*/\1/p" /tmp/load; }
# The number after a word of that line.
word() { sed -n "s/^LOAD $1 .* $2 \([0-9]*\).*/\1/p" /tmp/load; }
expect 'set-points that the loop was told of' "$(count setpoints)" $((1000 * $1))
spread() { echo "$(word "$1" p50) / $(word "$1" p99) / $(word "$1" p99_9) / $(word "$1" max) us"; }
echo "TABLE | SYNC at 1 kHz, 4 + 4 PDOs, SDO at once, $1 s of virtual time | |"
echo "TABLE |---|--:|"
echo "TABLE | answers to SDO requests | $(first answers) |"
echo "TABLE | time of an answer, 50 / 99 / 99.9 % / greatest | $(spread answers) |"
echo "TABLE | from SYNC to the second TPDO, 50 / 99 / 99.9 % / greatest | $(spread synced) |"
echo "TABLE | data sheets read by blocks | $(first sheets), $(word sheets bytes) bytes |"
echo "TABLE | set-points sent, lost | $(first setpoints), $(word setpoints lost) |"
echo "TABLE | superseded by the next one before their cycle | $(count superseded) |"
echo "TABLE | cycles of the loop, missed | $(count cycles), $(count missed) |"
echo "TABLE | execution of a cycle, 50 / 99.9 % / greatest | $(figure execution_us p50) / $(figure execution_us p99_9) / $(figure execution_us max) us |"
cat $figures /tmp/daemon.vcan0
finish
