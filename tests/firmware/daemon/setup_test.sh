#!/bin/bash
# smaservo-setup on folders that look like a Raspberry Pi 4, a 5, a PC with Debian, and on broken ones.
# setup_test.sh SETUP-FOLDER: firmware/daemon/system
# shellcheck disable=SC2317 # check calls them
set -euo pipefail

system=$(readlink -f "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

# As the package lays it out.
mkdir -p "$work/usr/sbin" "$work/usr/share/smaservo/setup"
cp "$system/smaservo-setup" "$work/usr/sbin"
cp "$system"/can.* "$work/usr/share/smaservo/setup"
printf 'overlay' >"$work/usr/share/smaservo/setup/smaservo-pins.dtbo"
setup=$work/usr/sbin/smaservo-setup

check() {
  if ! "${@:2}"; then
    printf 'FAILED: %s\n' "$1" >&2
    failed=1
  fi
}

# code_of WANTED COMMAND...: its output is in $work/out.
code_of() {
  local wanted=$1 code=0
  shift
  "$@" >"$work/out" 2>&1 </dev/null || code=$?
  if ((code != wanted)); then
    printf 'exit code %d, not %d: %s\n' "$code" "$wanted" "$*" >&2
    tail -n 5 "$work/out" >&2
    return 1
  fi
}

said() { grep -qF -- "$1" "$work/out"; }
has() { grep -qxF -- "$2" "$1"; }
same() { diff -r --no-dereference "$1" "$2" >"$work/differs" 2>&1; }

make_debian() {
  mkdir -p "$1/etc" "$1/sys/devices/system/cpu" "$1/dev" "$1/proc/sys/kernel"
  printf 'root:x:0:0::/root:/bin/sh\nsmaservo:x:990:990::/var/lib/smaservo:/usr/sbin/nologin\n' >"$1/etc/passwd"
  printf '0-3\n' >"$1/sys/devices/system/cpu/present"
  printf '6.12.47\n' >"$1/proc/sys/kernel/osrelease"
}

# make_pi FOLDER NUMBER BOOT
make_pi() {
  local tree=$1 boot=$1$3
  make_debian "$tree"
  mkdir -p "$boot/overlays" "$tree/proc/device-tree" "$tree/sys/class/net/can7"
  printf 'Raspberry Pi %s Model B Rev 1.0\0' "$2" >"$tree/proc/device-tree/model"
  printf '280\n' >"$tree/sys/class/net/can7/type"
  touch "$tree/dev/spidev0.0" "$tree/dev/gpiochip0"
  # No end of the last line, and one as Windows writes it.
  printf 'dtparam=audio=on\r\n[pi4]\narm_boost=1' >"$boot/config.txt"
  printf 'console=serial0,115200 root=PARTUUID=1-02 rootfstype=ext4 rootwait\n' >"$boot/cmdline.txt"
}

# Applies, again, changes an option, takes it back: the tree of before.
test_round() {
  local name=$1 tree=$work/$1
  cp -r "$tree" "$tree.before"
  check "$name: without a yes" code_of 3 "$setup" --root "$tree"
  check "$name: nothing changed" same "$tree" "$tree.before"
  check "$name: applies" code_of 0 "$setup" --root "$tree" --yes
  check "$name: says when" said 'takes effect at the next boot'
  cp -r "$tree" "$tree.applied"
  check "$name: again" code_of 0 "$setup" --root "$tree" --yes
  check "$name: has nothing left" said 'Nothing to change'
  check "$name: and changes nothing" same "$tree" "$tree.applied"
  check "$name: another bit rate and processor" \
    code_of 0 "$setup" --root "$tree" --yes --bitrate 1000000 --processor 2
  check "$name: bit rate" has "$tree/etc/systemd/network/80-smaservo-can.network" BitRate=1000000
  check "$name: back to the first" code_of 0 "$setup" --root "$tree" --yes
  check "$name: is as the first" same "$tree" "$tree.applied"
  check "$name: taken back" code_of 0 "$setup" --root "$tree" --undo --yes
  find "$tree/etc" -mindepth 1 -type d -empty -delete
  check "$name: is as before" same "$tree" "$tree.before"
}

test_boards() {
  local boot
  make_pi "$work/pi4" 4 /boot/firmware
  make_pi "$work/pi5" 5 /boot
  make_debian "$work/debian"
  for tree in pi4 pi5 debian; do
    test_round "$tree"
  done
  for tree in "$work/pi4.applied/boot/firmware" "$work/pi5.applied/boot"; do
    check 'SPI' has "$tree/config.txt" dtparam=spi=on
    check 'CAN' has "$tree/config.txt" 'dtoverlay=mcp251xfd,spi1-0,interrupt=27,oscillator=40000000'
    check 'what was there' has "$tree/config.txt" arm_boost=1
    check 'for all models' has "$tree/config.txt" '[all]'
    check 'the overlay' test -s "$tree/overlays/smaservo-pins.dtbo"
    check 'one line' test "$(wc -l <"$tree/cmdline.txt")" = 1
    check 'a processor' grep -q ' isolcpus=3 rcu_nocbs=3 irqaffinity=0,1,2$' "$tree/cmdline.txt"
    check 'a backup' test -f "$tree/config.txt.before-smaservo"
  done
  boot=$(find "$work/debian.applied" -name config.txt)
  check 'no overlays on a PC' test -z "$boot"
}

# What the user has done before, and does after.
test_others() {
  local tree=$work/others boot=$work/others/boot/firmware
  make_pi "$tree" 4 /boot/firmware
  printf '\ndtoverlay=mcp2515-can0,oscillator=16000000\n' >>"$boot/config.txt"
  printf 'isolcpus=1 rootwait\n' >"$boot/cmdline.txt"
  check 'with a CAN HAT of its own' code_of 0 "$setup" --root "$tree" --yes
  check 'only one' test "$(grep -c 'dtoverlay=mcp25' "$boot/config.txt")" = 1
  check 'its own processor stays' grep -q '^isolcpus=1 rootwait rcu_nocbs=3' "$boot/cmdline.txt"
  sed -i '1i # mine' "$boot/config.txt"
  sed -i 's/$/ quiet/' "$boot/cmdline.txt"
  check 'undone' code_of 0 "$setup" --root "$tree" --undo --yes
  check 'a later line stays' has "$boot/config.txt" '# mine'
  check 'a later word stays' has "$boot/cmdline.txt" 'isolcpus=1 rootwait quiet'
  check 'ours went' test -z "$(grep -r smaservo-setup "$boot" "$tree/etc" || true)"
  printf 'yes\n' | "$setup" --root "$tree" >"$work/out"
  check 'a yes at the prompt' said 'takes effect at the next boot'
  make_pi "$work/pi3" 3 /boot
  check 'another model' code_of 0 "$setup" --root "$work/pi3" --yes
  check 'is left alone' said 'left alone'
  check 'and has no overlay' test -z "$(ls "$work/pi3/boot/overlays")"
}

# No control character of a file or of an argument reaches the terminal, but for ends of lines.
test_escaped() {
  local tree=$work/escaped
  make_pi "$tree" 4 /boot/firmware
  printf 'Raspberry Pi 4 \033[2J\302\2332J' >"$tree/proc/device-tree/model"
  printf 'a=\033[2J\302\2332J\n' >"$tree/boot/firmware/config.txt"
  check 'with escapes' code_of 3 "$setup" --root "$tree"
  check 'shows them' said 'Raspberry Pi 4 ?[2J??2J'
  check 'in the diff' said ' a=?[2J??2J'
  check 'none is left' test -z "$(tr -d '\n\t -\176' <"$work/out")"
  check 'an argument' code_of 2 "$setup" $'--\033[2J\nsmaservo-setup: ok'
  check 'is one line' said 'unknown option: --?[2J?smaservo-setup: ok'
}

# Nothing is read through a link that leads out of the root, either.
test_reads() {
  local tree=$work/reads
  make_pi "$tree" 4 /boot/firmware
  mkdir -p "$work/elsewhere" "$tree/sys/devices/system/cpu/cpufreq/policy0"
  printf 'secret\n' >"$work/elsewhere/governor"
  printf '0-1\n' >"$work/elsewhere/present"
  ln -s "$work/elsewhere/governor" "$tree/sys/devices/system/cpu/cpufreq/policy0/scaling_governor"
  ln -sf "$work/elsewhere/present" "$tree/sys/devices/system/cpu/present"
  mv "$tree/etc/passwd" "$work/elsewhere"
  ln -s "$work/elsewhere/passwd" "$tree/etc/passwd"
  check 'with links' code_of 3 "$setup" --root "$tree"
  check 'no governor' said 'the kernel has none'
  check 'no user' said 'smaservo is missing'
}

# A number that begins with 0 is no octal one, here or in what reads the files.
test_numbers() {
  local tree=$work/numbers
  make_pi "$tree" 4 /boot/firmware
  printf '0-9\n' >"$tree/sys/devices/system/cpu/present"
  check '--processor 08' \
    code_of 0 "$setup" --root "$tree" --yes --processor 08 --can-interrupt 017 --can-oscillator 016000000
  check 'is processor 8' grep -q ' isolcpus=8 rcu_nocbs=8 irqaffinity=0,1,2,3,4,5,6,7,9$' \
    "$tree/boot/firmware/cmdline.txt"
  check 'and line 17' has "$tree/boot/firmware/config.txt" \
    'dtoverlay=mcp251xfd,spi1-0,interrupt=17,oscillator=16000000'
}

# service_does TREE WHEN: runs a line of the unit as systemd would, on the tree.
service_does() {
  local line
  line=$(sed -n "s/^$2=-+\/bin\/sh -c '\(.*\)'$/\1/p" "$1"/etc/systemd/system/smaservod.service.d/*.conf)
  [[ -n $line ]] || return
  line=${line//'$$'/'$'}
  line=${line//\/sys\//$1/sys/}
  sh -c "${line//\/run\//$1/run/}"
}

governors() { cat "$1"/sys/devices/system/cpu/cpufreq/policy*/scaling_governor | xargs; }

test_governors() {
  local tree=$work/governors kernel=$work/governors/sys/devices/system/cpu/cpufreq
  make_debian "$tree"
  mkdir -p "$kernel/policy0" "$kernel/policy2" "$tree/run"
  echo ondemand >"$kernel/policy0/scaling_governor"
  echo powersave >"$kernel/policy2/scaling_governor"
  check 'governors: set up' code_of 0 "$setup" --root "$tree" --yes
  check 'of before the start' test "$(governors "$tree")" = 'ondemand powersave'
  check 'start' service_does "$tree" ExecStartPre
  check 'while it runs' test "$(governors "$tree")" = 'performance performance'
  check 'killed, and started again' service_does "$tree" ExecStartPre
  check 'stop' service_does "$tree" ExecStopPost
  check 'of before again' test "$(governors "$tree")" = 'ondemand powersave'
  check 'stop without a start' service_does "$tree" ExecStopPost
  check 'of before still' test "$(governors "$tree")" = 'ondemand powersave'
  check 'start again' service_does "$tree" ExecStartPre
  check 'undo while it runs' code_of 0 "$setup" --root "$tree" --yes --undo
  check 'says so' said 'performance, back to ondemand'
  check 'of before after undo' test "$(governors "$tree")" = 'ondemand powersave'
  check 'undo once more' code_of 0 "$setup" --root "$tree" --yes --undo
  check 'has nothing left' said 'Nothing to change'
}

# The service reaches no network, unless that is its bus.
test_network() {
  local tree=$work/network settings=$work/network/etc/systemd/system/smaservod.service.d/80-smaservo-setup.conf
  make_debian "$tree"
  mkdir "$tree/etc/smaservo"
  check 'the unit denies' has "$system/smaservod.service" IPAddressDeny=any
  printf '[bus]\ninterface = "can0"  # or "udp" on a PC\n# interface = "udp"\n' >"$tree/etc/smaservo/board.toml"
  check 'a board with CAN' code_of 0 "$setup" --root "$tree" --yes
  check 'has no network' test "$(grep -c IPAddress "$settings")" = 0
  printf '[bus]\ninterface = "udp:239.74.163.2"\n' >"$tree/etc/smaservo/board.toml"
  check 'a board with UDP' code_of 0 "$setup" --root "$tree" --yes
  check 'has it' has "$settings" IPAddressAllow=any
  printf 'bus = { interface = "udp" }\n' >"$tree/etc/smaservo/board.toml"
  check 'in one line' code_of 0 "$setup" --root "$tree" --yes
  check 'has it too' has "$settings" IPAddressAllow=any
}

# broken NAME CODE WORDS OPTIONS...: says so and changes nothing, in a tree that `breaks` has broken.
broken() {
  local name=$1 code=$2 words=$3 tree=$work/broken
  shift 3
  rm -rf "$tree" "$tree.before"
  make_pi "$tree" 5 /boot/firmware
  breaks "$tree/boot/firmware" "$tree"
  cp -r "$tree" "$tree.before"
  check "$name" code_of "$code" "$setup" --root "$tree" --yes "$@"
  check "$name: says '$words'" said "$words"
  check "$name: changes nothing" same "$tree" "$tree.before"
}

test_broken() {
  mkdir "$work/outside"
  cp -r "$work/pi5/boot/." "$work/outside"
  echo secret >"$work/outside/secret"
  cp -r "$work/outside" "$work/outside.before"
  breaks() { printf '\n# smaservo-setup: from here\ndtparam=spi=on\n' >>"$1/config.txt"; }
  broken 'a block without end' 1 'config.txt, line 4'
  breaks() { printf '\n# smaservo-setup: to here\n' >>"$1/config.txt"; }
  broken 'an end without block' 1 'config.txt, line 4'
  breaks() { printf 'a\nb\n' >"$1/cmdline.txt"; }
  broken 'two lines' 1 'cmdline.txt: must be one line'
  breaks() { : >"$1/cmdline.txt"; }
  broken 'no line' 1 'cmdline.txt: must be one line'
  breaks() { rm "$1/cmdline.txt"; }
  broken 'no command line' 1 'cmdline.txt: is missing'
  breaks() { ln -sf /dev/null "$1/config.txt.x" && mv "$1/config.txt" "$1/c" && ln -s c "$1/config.txt"; }
  broken 'a link' 1 'config.txt is a link'
  # Links of a card that are absolute lead to files of this computer.
  breaks() { rm "$1/config.txt" && ln -s "$work/outside/config.txt" "$1/config.txt"; }
  broken 'a link out of the root' 1 "leads out of $work/broken"
  breaks() { mv "$1" "$2/elsewhere" && ln -s "$work/outside" "$1"; }
  broken 'a folder that leads out' 1 "leads out of $work/broken"
  breaks() { mkdir "$2/etc/systemd" && ln -s "$work/outside" "$2/etc/systemd/network"; }
  broken 'a folder of ours that leads out' 1 "80-smaservo-can.network: leads out of $work/broken"
  breaks() { ln -s "$work/outside/secret" "$1/config.txt.before-smaservo"; }
  broken 'a backup that leads out' 1 'config.txt.before-smaservo: leads out of'
  broken 'a backup that leads out, undone' 1 'config.txt.before-smaservo: leads out of' --undo
  check 'what is outside stays' same "$work/outside" "$work/outside.before"
  breaks() { printf '0-1\n' >"$2/sys/devices/system/cpu/present"; }
  broken 'too few processors' 1 '--processor 3'
  breaks() { :; }
  broken 'bit rate' 2 '--bitrate 123: must be one of 10000' --bitrate 123
  broken 'processor' 2 '--processor x: must be a whole number from 0 to 63' --processor x
  broken 'interrupt' 2 '--can-interrupt 24' --can-interrupt 24
  broken 'no value' 2 '--bitrate needs a value' --bitrate
  broken 'unknown option' 2 'unknown option: --bitrat' --bitrat=5
  broken 'no folder' 1 '--root /nowhere: no such folder' --root /nowhere
  broken 'extra word' 2 'unknown option: now' now
}

# Killed at each rename, before or after it: every file is the old or the new one, another run ends as an
# undisturbed one, and undo brings back what was.
test_killed() {
  local tree=$work/killed when n file name
  mkdir -p "$work/bin"
  # shellcheck disable=SC2016 # of the script that is written
  printf '%s\n' '#!/bin/bash' 'n=$(($(cat "$COUNT") + 1)); echo "$n" >"$COUNT"' \
    'if [[ $n == "$KILL_AT" && $WHEN == before ]]; then kill -9 $PPID; exit 1; fi' '/bin/mv "$@"' \
    'if [[ $n == "$KILL_AT" ]]; then kill -9 $PPID; fi' >"$work/bin/mv"
  chmod 755 "$work/bin/mv"
  export COUNT=$work/count KILL_AT WHEN
  for when in before after; do
    for n in 1 2 5 7 8 9; do
      rm -rf "$tree"
      make_pi "$tree" 4 /boot/firmware
      echo 0 >"$COUNT"
      WHEN=$when KILL_AT=$n
      check "killed $when rename $n" code_of 137 env PATH="$work/bin:$PATH" "$setup" --root "$tree" --yes
      for file in boot/firmware/{config,cmdline}.txt; do
        if ! cmp -s "$tree/$file" "$work/pi4.before/$file"; then
          check "killed $when rename $n: $file is whole" cmp -s "$tree/$file" "$work/pi4.applied/$file"
        fi
      done
      check "killed $when rename $n: again" code_of 0 "$setup" --root "$tree" --yes
      check "killed $when rename $n: is as undisturbed" same "$tree" "$work/pi4.applied"
      check "killed $when rename $n: undone" code_of 0 "$setup" --root "$tree" --yes --undo
      find "$tree/etc" -mindepth 1 -type d -empty -delete
      check "killed $when rename $n: is as before" same "$tree" "$work/pi4.before"
    done
  done
  name=$(cat "$COUNT")
  check 'it renames nine times' test "$name" = 9
}

test_boards
test_others
test_escaped
test_reads
test_numbers
test_governors
test_network
test_broken
test_killed
exit "$failed"
