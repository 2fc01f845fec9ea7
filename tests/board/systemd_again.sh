#!/bin/sh
# What systemd.sh has left to the next boot of its disk.
# shellcheck source=tests/board/unit.sh
. ./unit.sh
cp /var/tmp/hold.toml /tmp

echo '-- after the reboot'
# PID 1 stops everything at once.
off_by program 250000
row 'systemctl reboot'
# Nothing here starts it, and it has not found its inputs yet.
since=0
expect 'enabled' "$(systemctl is-enabled smaservod)" enabled
within 'tries' "$(journal | grep -c 'no such line')" 1 100
make_board
sleep 5
expect 'runs' "$(unit ActiveState)" active
expect 'says' "$(sed -n 's/.*"last_run": *"\([^"]*\)".*/\1/p' /run/smaservo/status.json)" 'the last run ended cleanly'
expect 'bit rate' "$(bitrate)" 500000
ip link set can1 up type can bitrate 500000

echo '-- undo'
smaservo-setup --undo --yes >/tmp/setup
expect 'smaservo-setup' $? 0
etc | diff /var/tmp/etc -
expect 'all files of /etc are what they were' $? 0

echo '-- removed while it heats'
heats /dev/null 1 60
pid=$(unit MainPID)
dpkg -i /smaservo.deb >/dev/null
expect 'an upgrade leaves it alone' "$(unit MainPID)" "$pid"
within 'and heating' "$(duty)" 1 50000
dpkg -r smaservo
expect 'duty' "$(duty)" 0
expect 'its process' "$(cat "/proc/$pid/comm" 2>/dev/null)" ''
dpkg -P smaservo
expect 'stored settings' "$([ -e /var/lib/smaservo ] && echo there)" ''
expect 'its user stays' "$(getent passwd smaservo | cut -d : -f 1)" smaservo
kill $plant

sed 's/^/TABLE /' /tmp/stops
finish
