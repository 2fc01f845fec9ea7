#!/bin/sh
# The package in a Debian system, under its PID 1: what it installs, how its service runs and ends. It ends
# with a reboot, after which systemd_again.sh goes on.
# shellcheck source=tests/board/unit.sh
. ./unit.sh
make_board

echo '-- install'
dpkg --unpack /smaservo.deb
# udev looks for new rules when something happens, once in 3 s: it reads these before the user is there.
sleep 4
udevadm trigger --subsystem-match=mem
udevadm settle
dpkg --configure smaservo
expect 'installed' $? 0
expect 'its user' "$(getent passwd smaservo | cut -d : -f 1,6)" smaservo:/var/lib/smaservo
expect 'enabled' "$(systemctl is-enabled smaservod)" disabled
expect 'started' "$(unit ActiveState)" inactive
udevadm settle
# A chip of which the board file names no line.
other=/sys/kernel/config/gpio-sim/other
mkdir -p $other/bank0
echo 1 >$other/bank0/num_lines
echo 1 >$other/live
udevadm settle
owners() {
  stat -Lc %U /dev/gpiochip0 /dev/gpiochip1 /dev/iio:device0 "$(pwm_chip)"/export "/dev/$(cat $other/bank0/chip_name)" |
    xargs
}
expect 'owners without a board file' "$(owners)" 'root root root root root'
systemctl start smaservod
expect 'without a board file' "$(unit ActiveState) $(unit ConditionResult)" 'inactive no'

echo '-- CAN'
etc >/var/tmp/etc
smaservo-setup --yes >/tmp/setup
expect 'smaservo-setup' $? 0
smaservo-setup --yes >/tmp/setup
expect 'once more' "$(tail -n 1 /tmp/setup)" 'Nothing to change.'
systemctl restart systemd-networkd
udevadm trigger --action=add /sys/class/net/can0
udevadm settle
sleep 1
expect 'bit rate' "$(bitrate)" 500000
ip link set can1 up type can bitrate 500000

echo '-- start'
mkdir -p /etc/smaservo
sed '/^folder/d' board.toml >/etc/smaservo/board.toml
printf '\n[bus]\ninterface = "can0"\nnode_id = 1\n' >>/etc/smaservo/board.toml
sed 's#"../../host-sim/#"/usr/share/smaservo/#' device.toml >/etc/smaservo/device.toml
udevadm trigger
udevadm settle
expect 'owners of its devices, and of a chip that is not' "$(owners)" 'smaservo smaservo smaservo smaservo root'
sed 's#"device.toml"#"/etc/smaservo/device.toml"#' hold.toml >/tmp/hold.toml
# What runs after the start is in the same sandbox.
here=$PWD
drop_in=/run/systemd/system/smaservod.service.d
mkdir -p $drop_in
echo "[Service]
ExecStartPost=/bin/sh -c 'sh $here/forbidden.sh >/run/smaservo/answers'" >$drop_in/forbidden.conf
since=$(date +%s)
/plant /tmp/hold.toml 60 >$log &
plant=$!
mknod -m 666 /dev/forbidden b "0x$(stat -c %t /dev/vda)" "0x$(stat -c %T /dev/vda)"
for file in /etc/forbidden /tmp/forbidden; do
  echo secret >$file
  chmod 666 $file
done
systemctl daemon-reload
systemctl start smaservod
expect 'start' $? 0
expect 'service' "$(unit Type) $(unit ActiveState) $(unit SubState)" 'notify active running'
journal
pid=$(unit MainPID)
status() { sed -n "s/^$1:\t *//p" "/proc/$pid/status"; }
expect 'its user' "$(status Uid | cut -f 1)" "$(id -u smaservo)"
expect 'capabilities' "$(status CapEff) $(status CapBnd)" '0000000000000000 0000000000000000'
expect 'no new privileges, filter of system calls' "$(status NoNewPrivs) $(status Seccomp)" '1 2'
within 'locked memory, kB' "$(status VmLck | cut -d ' ' -f 1)" 10000 1000000
expect 'real-time priorities' "$(chrt -a -p "$pid" | sed -n 's/.*priority: //p' | sort -n | xargs)" '0 0 0 40 80 81'

echo '-- sandbox'
setpriv --reuid=smaservo --regid=smaservo --clear-groups sh ./forbidden.sh >/tmp/answers
expect 'its user elsewhere' "$(grep -v ': allowed$' /tmp/answers)" ''
mv /run/smaservo/answers /tmp/answers
answer() { expect "$1" "$(sed -n "s|^$1: ||p" /tmp/answers)" "$2"; }
answer 'read a disk' 'Operation not permitted'
answer 'write below /etc' 'Read-only file system'
answer 'look into homes' 'Permission denied'
answer "read another's /tmp" 'No such file or directory'
answer 'talk netlink' 'Address family not supported by protocol'
answer 'send to an address' 'Operation not permitted'
answer 'make a namespace' 'Operation not permitted'
answer 'make a file set-user-ID' 'Operation not permitted'
answer 'open its GPIO' allowed
kill $plant
systemctl stop smaservod
rm -r $drop_in /etc/forbidden
systemctl daemon-reload

echo '-- systemctl stop'
when_told systemctl stop smaservod
heats $told 1 10
wait $plant
off_by program 100000
row 'systemctl stop'
expect 'ended' "$(unit ActiveState) $(unit Result)" 'inactive success'

echo '-- kill -9'
heats pid:/tmp/daemon 9
wait $plant
off_by one-shot 9000
row 'kill -9'
expect 'duty that is set' "$(duty)" 0
expect 'is back' "$(unit ActiveState)" active
within 'times restarted' "$(($(unit NRestarts) - before))" 1 1
journal
expect 'the next start says' "$(journal | grep -c 'the last run was killed while the wire was heated; service result: signal')" 1
systemctl stop smaservod

echo '-- SIGSTOP'
heats pid:/tmp/daemon 19 15
wait $plant
off_by one-shot 9000
row 'SIGSTOP, then the watchdog'
expect 'is back' "$(unit ActiveState)" active
journal
# Killed or crashed, heated or off: who of its threads runs first when it goes on to take the signal.
expect 'the next start says' "$(journal | grep -cE 'the last run .* while the wire was (heated|off); service result: watchdog')" 1
systemctl stop smaservod

echo '-- the bus down and up'
when_told ip link set can0 down
heats $told 1 10
pid=$(unit MainPID)
wait $plant
# A fault of the bus has to last for 100 ms.
off_by program 150000
row 'can0 down'
expect 'the journal says why' "$(journal | grep -c bus_lost)" 1
ip link set can0 up
sleep 0.5
/plant /tmp/hold.toml 60 >/dev/null &
plant=$!
client reset-faults >/dev/null
client enable && client move 800
expect 'moves again' $? 0
within 'and heats' "$(duty)" 1 50000
expect 'the same process' "$(unit MainPID) $(unit ActiveState)" "$pid active"
kill $plant
systemctl stop smaservod

echo '-- the board file breaks while it heats'
cp /etc/smaservo/board.toml /tmp/board.toml
heats pid:/tmp/daemon 9
sed -i 's/^supply_V = .*/supply_V = 5000/' /etc/smaservo/board.toml
wait $plant
off_by one-shot 9000
row 'kill -9 after the board file broke'
expect 'duty that is set' "$(duty)" 0
expect 'then' "$(unit ActiveState)" failed
journal

echo '-- a broken board file'
systemctl reset-failed smaservod
since=$(date +%s)
systemctl start smaservod 2>/dev/null
expect 'start fails' $? 1
sleep 5
journal
expect 'failed, not started again' "$(unit ActiveState) $(unit ExecMainStatus) $(unit NRestarts)" 'failed 78 0'
expect 'the journal says why, once' "$(journal | grep -c 'board.toml:.*supply_V = 5000: must be')" 1
cp /tmp/board.toml /etc/smaservo/board.toml
systemctl reset-failed smaservod
# It was killed while it heated: that is acknowledged first.
/plant /tmp/hold.toml 60 >/dev/null &
plant=$!
sleep 0.2
systemctl start smaservod
client enable
expect 'is not enabled after a kill' $? 1
client reset-faults >/dev/null
client enable
expect 'is, when that has been acknowledged' $? 0
kill $plant
systemctl stop smaservod

echo 'TABLE | a service that tries to | is told |'
echo 'TABLE |---|---|'
sed 's/^\(.*\): \(.*\)$/TABLE | \1 | \2 |/' /tmp/answers
echo 'TABLE '
echo 'TABLE | under systemd | ended by | heat off after, us |'
echo 'TABLE |---|---|--:|'
sed 's/^/TABLE /' /tmp/stops
[ $failures = 0 ] || finish

echo '-- reboot while it heats'
systemctl enable smaservod
cp /tmp/hold.toml /tmp/board.toml /var/tmp
# It outlives all services.
plant_in="systemd-run -q -p DefaultDependencies=no -p StandardOutput=truncate:$log"
when_told systemctl reboot
heats $told 1 600
[ $failures = 0 ] || finish
echo 'BOARD_EXIT 0 as far as this boot knows'
sleep 600
