# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev; board by board.sh
# What runs on the emulated board: tests/board/CMakeLists.txt lists the checks. Sourced by toolchain/dev.

programs=$root/build/release/tests/board

board_check_can() {
  local tools
  tools="$(command -v candump):/usr/bin/candump $(command -v cansend):/usr/bin/cansend"
  # shellcheck disable=SC2086 # two files
  image amd64 can 'idle_nop vcan can-raw kvaser_pci' "$programs/board_tests:/board_tests" $tools \
    "$(command -v ip):/usr/sbin/ip" || return
  board_devices=$two_controllers guest amd64 virtual can can 60 tests Can
}

two_controllers='-object can-bus,id=bus -device kvaser_pci,canbus=bus -device kvaser_pci,canbus=bus'

# bus_image NAME MODULES FILE:PLACE...: the daemon with its simulated wire.
bus_image() {
  local name=$1 modules=$2 tool
  local -a files=()
  shift 2
  for tool in candump cansend chrt; do
    files+=("$(command -v "$tool"):/usr/bin/$tool")
  done
  image amd64 "$name" "$modules" "$programs/../../firmware/daemon/smaservod:/smaservod" \
    "$root/tests/can/device.toml:/tests/can/device.toml" "$(command -v ip):/usr/sbin/ip" \
    "${files[@]}" "$@"
}

board_check_bus() {
  bus_image bus 'idle_nop can-raw kvaser_pci' || return
  board_devices=$two_controllers guest amd64 virtual bus bus 300 bus
}

board_check_load() {
  bus_image load 'idle_nop vcan can-raw' "$programs/load:/load" &&
    guest amd64 virtual load load 1500 load "${SMASERVO_LOAD_S:-10}" && keep_table load
}

# loop_image NAME FILE:PLACE...: with what a closed loop needs. $loop_modules: further ones
loop_image() {
  local name=$1 tool
  local -a files=()
  shift
  for tool in candump cansend cangen gpioset gpioget gpiodetect cyclictest; do
    files+=("$(command -v "$tool"):/usr/bin/$tool")
  done
  image amd64 "$name" "idle_nop configfs vcan can-raw gpio-sim testboard iio-trig-hrtimer ${loop_modules:-}" \
    "$programs/plant:/plant" "$programs/busy:/busy" "$programs/../../firmware/daemon/smaservod:/smaservod" \
    "$root/host-sim/scenarios:/host-sim/scenarios" \
    "$(command -v ip):/usr/sbin/ip" "${files[@]}" "$@"
}

board_check_loop() {
  loop_image loop && guest amd64 virtual loop loop 580 loop && keep_table loop
}

board_check_hardship() {
  loop_modules='loop ext4' loop_image hardship && guest amd64 virtual hardship hardship 580 hardship && keep_table hardship
}

# keep_table NAME [GUEST...]: the lines of its guest, and of further ones, that are a table.
keep_table() {
  local guest
  for guest; do
    sed -n 's/^TABLE //p' "$board/guests/$guest/console.log"
  done >"$board/results/$1.txt"
}

board_check_realtime() {
  local one other
  loop_image realtime || return
  # The kernel's start halts still: on one processor qemu's two threads take turns at it.
  read -r one other < <(sed -nE 's/^Cpus_allowed_list:\s*([0-9]+)(.*[^0-9]([0-9]+))?$/\1 \3/p' /proc/self/status)
  board_processor=$one guest amd64 virtual realtime realtime 580 realtime &
  local first=$!
  board_processor=${other:-$one} guest amd64 virtual realtime realtime-again 580 realtime
  local again=$?
  wait "$first" && ((again == 0)) || return
  keep_table realtime
  diff "$board"/guests/realtime{,-again}/console.log || { say 'two runs of one image differ'; return 1; }
  printf '\nTwo runs of one image: the same to the bit.\n' >>"$board/results/realtime.txt"
}

board_check_arm64() {
  image arm64 arm64 'configfs vcan can-raw gpio-sim testboard iio-trig-hrtimer' &&
    guest arm64 virtual arm64 arm64 580 kernel
}

board_check_overload() {
  loop_image overload && guest amd64 virtual overload overload 580 realtime 1500
}

board_check_silicon() {
  loop_image silicon && guest amd64 virtual silicon silicon 60 silicon
}

board_check_guest() {
  local expected code
  image amd64 guest '' || return
  for expected in 0 7; do
    guest amd64 real guest guest 600 exit "$expected" 2>/dev/null
    code=$?
    ((code == expected)) || { say "exit $expected came back as $code"; return 1; }
  done
  guest amd64 real guest guest 600 exit silent 2>/dev/null
  code=$?
  ((code == 125)) || { say "silence came back as $code"; return 1; }
  guest amd64 real guest guest 8 exit hang 2>/dev/null
  code=$?
  ((code == 124)) || { say "a hang came back as $code"; return 1; }
}

# tree_of_modules FOLDER MODULE...: as modprobe wants them below FOLDER/lib, with what they need.
tree_of_modules() {
  local folder=$1 kernel=$kernels/amd64 release module
  shift
  release=$(<"$kernel/RELEASE")
  local from=$kernel/lib/modules/$release to=$folder/lib/modules/$release
  mkdir -p "$to"
  cp "$from"/modules.{builtin,builtin.modinfo,order} "$to/"
  for module; do
    modprobe -d "$kernel" -S "$release" --show-depends "$module"
  done | awk -v from="$from/" '$1 == "insmod" { print substr($2, length(from) + 1) }' | sort -u |
    (cd "$from" && xargs cp --parents -t "$to") &&
    depmod -b "$folder" "$release"
}

board_check_systemd() {
  local guest=$board/guests/systemd package disk
  make_package amd64 release '' || return
  package=$(package_file amd64)
  setup_root "$package" || return
  disk=$guest/disk.img
  rm -rf "$guest"
  mkdir -p "$guest"
  cp -r "$root/toolchain/board/disk" "$guest/overlay"
  tree_of_modules "$guest/overlay/usr" testboard gpio-sim \
    iio-trig-hrtimer can-raw kvaser_pci configfs || return
  cp "$package" "$guest/overlay/smaservo.deb"
  cp "$programs/plant" "$guest/overlay/plant"
  image amd64 systemd 'virtio_blk ext4' "$guest/overlay:/overlay" || return
  cp --sparse=always "$kernels/root/disk.img" "$disk"
  # shellcheck disable=SC2034 # guest's
  local board_devices="$two_controllers -drive file=$disk,format=raw,if=virtio,cache=unsafe"
  local boot='systemd.wants=board-test.service systemd.show_status=0'
  guest amd64 virtual systemd systemd 580 systemd '' "$boot" &&
    guest amd64 virtual systemd systemd-again 300 systemd_again '' "$boot" &&
    keep_table systemd systemd-again
}
