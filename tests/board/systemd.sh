#!/bin/sh
# The package in a Debian system, under its PID 1: what it installs, how its service runs, ends, and goes.
# shellcheck source=tests/board/rig.sh
. ./rig.sh
export LC_ALL=C DEBIAN_FRONTEND=noninteractive
modprobe configfs
mountpoint -q /sys/kernel/config || mount -t configfs c /sys/kernel/config
make_inputs
unit() { systemctl show -P "$1" smaservod; }
journal() { journalctl -q -u smaservod -o cat --since "@$since"; }

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
expect 'owner of GPIO' "$(stat -c %U /dev/gpiochip0)" smaservo
expect 'owner of the converter' "$(stat -c %U /dev/iio:device0)" smaservo
expect 'owner of the PWM' "$(stat -Lc %U "$(pwm_chip)"/export)" smaservo
systemctl start smaservod
expect 'without a board file' "$(unit ActiveState) $(unit ConditionResult)" 'inactive no'

echo '-- CAN'
smaservo-setup --yes >/tmp/setup
expect 'smaservo-setup' $? 0
smaservo-setup --yes >/tmp/setup
expect 'once more' "$(tail -n 1 /tmp/setup)" 'Nothing to change.'
systemctl restart systemd-networkd
udevadm trigger --action=add /sys/class/net/can0
udevadm settle
sleep 1
expect 'bit rate' "$(ip -details link show can0 | sed -n 's/.*bitrate \([0-9]*\) .*/\1/p')" 500000
ip link set can1 up type can bitrate 500000

echo '-- start'
mkdir -p /etc/smaservo
sed '/^folder/d' board.toml >/etc/smaservo/board.toml
printf '\n[bus]\ninterface = "can0"\nnode_id = 1\n' >>/etc/smaservo/board.toml
sed 's#"../../host-sim/#"/usr/share/smaservo/#' device.toml >/etc/smaservo/device.toml
sed 's#"device.toml"#"/etc/smaservo/device.toml"#' hold.toml >/tmp/hold.toml
since=$(date +%s)
/plant /tmp/hold.toml 60 >/tmp/plant.log &
plant=$!
sleep 0.2
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
expect 'real-time priorities' "$(chrt -a -p "$pid" | sed -n 's/.*priority: //p' | sort -n | xargs)" '0 0 40 80 81'
expect 'devices' "$(unit DevicePolicy) $(unit ProtectSystem) $(unit MemoryDenyWriteExecute)" 'closed strict yes'
kill $plant
systemctl stop smaservod

client() { host-sim can --can can1 --node 1 "$@"; }
by() { sed -n 's/^OFF .* by=\([a-z-]*\): .*/\1/p' /tmp/plant.log; }
off_us() { sed -n 's/^OFF after_us=\([^ ]*\) .*/\1/p' /tmp/plant.log; }

# heats SIGNAL: the wire is moved over the bus, and at 8 s the daemon gets the signal.
heats() {
  since=$(date +%s)
  /plant /tmp/hold.toml "${2:-12}" 8 pid:/tmp/daemon "$1" >/tmp/plant.log &
  plant=$!
  sleep 0.2
  systemctl start smaservod
  unit MainPID >/tmp/daemon
  client reset-faults >/dev/null
  client enable && client move 800
  expect 'arms and moves over the bus' $? 0
  before=$(unit NRestarts)
}

echo '-- kill -9'
heats 9
wait $plant
cat /tmp/plant.log
within 'off after, us' "$(off_us)" 1 9000
expect 'by' "$(by)" one-shot
expect 'duty that is set' "$(cat "$(pwm_chip)/pwm0/duty_cycle")" 0
expect 'is back' "$(unit ActiveState)" active
within 'times restarted' "$(($(unit NRestarts) - before))" 1 1
journal
expect 'the next start says' "$(journal | grep -c 'the last run was killed while the wire was heated; service result: signal')" 1
echo "| kill -9 | $(by) | $(off_us) |" >/tmp/stops
systemctl stop smaservod

echo '-- SIGSTOP'
heats 19 15
wait $plant
within 'off after, us' "$(off_us)" 1 9000
expect 'by' "$(by)" one-shot
expect 'is back' "$(unit ActiveState)" active
journal
# Killed or crashed, heated or off: who of its threads runs first when it goes on to take the signal.
expect 'the next start says' "$(journal | grep -cE 'the last run .* while the wire was (heated|off); service result: watchdog')" 1
echo "| SIGSTOP, then the watchdog | $(by) | $(off_us) |" >>/tmp/stops
systemctl stop smaservod

echo '-- a broken board file'
cp /etc/smaservo/board.toml /tmp/board.toml
sed -i 's/^supply_V = .*/supply_V = 5000/' /etc/smaservo/board.toml
since=$(date +%s)
systemctl start smaservod 2>/dev/null
expect 'start fails' $? 1
sleep 5
journal
within 'the journal says why' "$(journal | grep -c 'supply_V = 5000')" 1 8
systemctl stop smaservod
cp /tmp/board.toml /etc/smaservo/board.toml

echo '-- removed while it heats'
/plant /tmp/hold.toml 60 >/tmp/plant.log &
plant=$!
sleep 0.2
systemctl reset-failed smaservod
systemctl start smaservod
client reset-faults >/dev/null
client enable && client move 800
expect 'moves' $? 0
pid=$(unit MainPID)
dpkg -i /smaservo.deb >/dev/null
expect 'an upgrade leaves it alone' "$(unit MainPID)" "$pid"
within 'and heating' "$(cat "$(pwm_chip)/pwm0/duty_cycle")" 1 50000
dpkg -r smaservo
expect 'duty' "$(cat "$(pwm_chip)/pwm0/duty_cycle")" 0
expect 'its process' "$(cat "/proc/$pid/comm" 2>/dev/null)" ''
dpkg -P smaservo
expect 'stored settings' "$([ -e /var/lib/smaservo ] && echo there)" ''
expect 'its user stays' "$(getent passwd smaservo | cut -d : -f 1)" smaservo
kill $plant

echo 'TABLE | under systemd | ended by | heat off after, us |'
echo 'TABLE |---|---|--:|'
sed 's/^/TABLE /' /tmp/stops
finish
