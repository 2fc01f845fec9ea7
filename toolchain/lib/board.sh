# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# An emulated board: Debian's real-time kernel in qemu, fetched and made below build/board.
# Sourced by toolchain/dev; what runs on it is in board_checks.sh.

board=$root/build/board

# ---- kernel, modules ----

kernel_metapackage() {
  case $(debian_release) in
    12) printf 'linux-image-6.12-rt-%s\n' "$1" ;;
    *) printf 'linux-image-rt-%s\n' "$1" ;;
  esac
}

board_sources() {
  local codename=$1 mirror security
  mirror=$(debian_mirror "$codename")
  security=$(apt_sources | awk -v suite="$codename-security" '$2 == suite { print $1; exit }')
  source_line "$mirror" "$codename"
  source_line "${security:-http://deb.debian.org/debian-security}" "$codename-security"
  [[ $codename != bookworm ]] || source_line "$mirror" bookworm-backports
}

board_apt() { apt_for amd64 "$board/apt" -o APT::Architectures=amd64,arm64 "$@"; }

board_show() {
  apt_with apt-cache amd64 "$board/apt" -o APT::Architectures=amd64,arm64 --no-all-versions show "$1"
}

# fetch FOLDER PACKAGE...: unpacked there.
fetch() {
  local folder=$1 package
  shift
  rm -rf "$folder.debs"
  mkdir -p "$folder" "$folder.debs"
  (cd "$folder.debs" && board_apt download "$@") || return
  for package in "$folder.debs"/*.deb; do
    dpkg-deb --extract "$package" "$folder" || return
  done
  rm -r "$folder.debs"
}

# What Debian's configuration leaves out, of Debian's source: gpio-sim, with the irq_sim below it.
make_gpio_sim() {
  local out=$board/gpio-sim version name
  version=$(board_show "$(kernel_package amd64)" | sed -n 's/^Version: //p')
  name=linux-source-$(cut -d. -f1,2 <<<"$version")
  mkdir -p "$out.debs" "$out"
  (cd "$out.debs" && board_apt download "$name=$version") || return
  dpkg-deb --fsys-tarfile "$out.debs"/*.deb | tar -xO "./usr/src/$name.tar.xz" |
    tar -I 'xz -dT0' -x -C "$out" --strip-components=3 "$name/drivers/gpio/gpio-sim.c" \
      "$name/kernel/irq/irq_sim.c" || return
  rm -r "$out.debs"
  mv "$out/gpio-sim.c" "$out/gpio-sim-main.c"
  # The first is not exported; the second is meant for others.
  sed -i 's/handle_simple_irq(irq_to_desc(irqnum))/generic_handle_irq_safe(irqnum)/
    /^EXPORT_SYMBOL/d' "$out/irq_sim.c"
}

# build_modules ARCHITECTURE RELEASE HEADERS OUT
build_modules() {
  local architecture=$1 release=$2 headers=$3 out=$4
  local -a options=()
  [[ $architecture == amd64 ]] || options=(ARCH=arm64 CROSS_COMPILE=aarch64-linux-gnu-)
  # Headers name each other by absolute paths; their vmlinux is for tools that we have not.
  sed -i "s#/usr/src/#$headers/usr/src/#" "$headers"/usr/src/*/Makefile
  rm -f "$headers"/usr/src/*/vmlinux
  rm -rf "$out"
  mkdir -p "$out"
  cp "$root"/toolchain/board/module/{Makefile,*.c} "$board/gpio-sim"/*.c "$out"
  make -s -C "$headers/usr/src/linux-headers-$release" "${options[@]}" M="$out" modules
}

# The package of the newest kernel.
kernel_package() {
  board_show "$(kernel_metapackage "$1"):$1" | sed -nE 's/^Depends: (linux-image-[^ ,]*).*/\1/p'
}

# make_kernel ARCHITECTURE FOLDER: vmlinuz, modules and their RELEASE.
make_kernel() {
  local architecture=$1 folder=$2 image release common
  image=$(kernel_package "$architecture")
  release=${image#linux-image-}
  common=${release%-rt-*}
  [[ -n $release ]] || return
  rm -rf "$folder"
  fetch "$folder" "$image:$architecture" &&
    fetch "$folder/headers" "linux-headers-$release:$architecture" \
      "linux-headers-$common-common-rt" "linux-kbuild-$common" || return
  build_modules "$architecture" "$release" "$folder/headers" "$folder/module" || return
  mkdir "$folder/lib/modules/$release/extra"
  cp "$folder"/module/*.ko "$folder/lib/modules/$release/extra/"
  rm -rf "$folder/headers"
  depmod -b "$folder" "$release"
  printf '%s\n' "$release" >"$folder/RELEASE"
}

# Programs of Debian for a guest of another architecture; those of this one are installed.
make_tools() {
  local architecture=$1 folder=$2 backports=''
  [[ $(debian_release) != 12 ]] || backports=/bookworm-backports
  fetch "$folder/tools" "busybox-static:$architecture" "can-utils:$architecture" \
    "gpiod:$architecture$backports" "libgpiod3:$architecture$backports"
}

make_board() {
  local architecture
  rm -rf "$board"
  mkdir -p "$board"
  board_sources "$(debian_codename)" | start_apt "$board/apt"
  board_apt update || return
  make_gpio_sim || return
  make_kernel amd64 "$board/amd64" &
  local amd64=$!
  make_kernel arm64 "$board/arm64" && make_tools arm64 "$board/arm64" || return
  wait "$amd64" || return
  rm -rf "$board/apt" "$board/gpio-sim"
}

# Kernels, modules and tools of both architectures; anew when what makes them changes.
setup_board() {
  local key
  key=$({
    debian_codename
    cat "$root/toolchain/lib/board.sh" "$root"/toolchain/board/module/*
  } | sha256sum)
  if [[ -f $board/made-from && $(<"$board/made-from") == "$key" ]]; then
    return
  fi
  say 'fetching kernels, building modules for the emulated board'
  step board-setup make_board || return
  printf '%s\n' "$key" >"$board/made-from"
}

# ---- images ----

library_folders() {
  case $1 in
    amd64) printf '%s\n' /{,usr/}lib/x86_64-linux-gnu ;;
    arm64) printf '%s\n' "$board"/arm64/tools/{,usr/}lib/aarch64-linux-gnu \
      "$root/build/sysroot/aarch64-linux-gnu"/{,usr/}lib/aarch64-linux-gnu ;;
  esac
}

# add_libraries ARCHITECTURE FILE FOLDER: what the file needs, and what that needs.
add_libraries() {
  local architecture=$1 file=$2 folder=$3 name place
  while read -r name; do
    [[ ! -e $folder/usr/lib/$name ]] || continue
    while read -r place; do
      if [[ -e $place/$name ]]; then
        cp -L "$place/$name" "$folder/usr/lib/$name"
        add_libraries "$architecture" "$place/$name" "$folder"
        continue 2
      fi
    done < <(library_folders "$architecture")
    say "no $name for $file"
    return 1
  done < <(readelf -ld "$file" 2>/dev/null |
    sed -nE 's/.*\(NEEDED\).*\[(.*)\]/\1/p; s/.*interpreter: .*\/(.*)\]/\1/p')
}

# pack FOLDER OUT: the same bytes from the same files.
pack() {
  find "$1" -exec touch -hd @1767225600 {} +
  (cd "$1" && find . -print0 | LC_ALL=C sort -z |
    cpio --null -o -H newc -R 0:0 --quiet --reproducible) | zstd -3 -q >"$2"
}

# image ARCHITECTURE NAME "MODULE..." FILE[:PLACE]...: an initramfs with the kernel's modules in the
# order of their loading, busybox, tests/board and the programs with their libraries.
image() {
  local architecture=$1 name=$2 modules=$3 folder release busybox module file place
  shift 3
  local kernel=$board/$architecture
  folder=$(mktemp -d)
  release=$(<"$kernel/RELEASE")
  mkdir -p "$folder"/{bin,sbin,usr/{bin,sbin,lib},proc,sys,dev,tmp,run,etc,modules,board}
  ln -s usr/lib "$folder/lib"
  ln -s usr/lib "$folder/lib64"
  busybox=$(command -v busybox)
  [[ $architecture == amd64 ]] || busybox=$kernel/tools/bin/busybox
  cp "$busybox" "$folder/bin/busybox"
  for file in $(busybox --list); do
    [[ $file == busybox ]] || ln -s busybox "$folder/bin/$file"
  done
  for module in $modules; do
    modprobe -d "$kernel" -S "$release" --show-depends "$module"
  done | awk '$1 == "insmod" && !seen[$2]++ { print $2 }' | while read -r file; do
    module=$(basename "$file")
    module=${module%%.ko*}
    module=${module//-/_}
    printf '%s\n' "$module" >>"$folder/modules/order"
    case $file in
      *.xz) xz -dc "$file" ;;
      *) cat "$file" ;;
    esac >"$folder/modules/$module.ko"
  done
  cp "$root/toolchain/board/init" "$folder/init"
  cp "$root"/tests/board/*.sh "$folder/board/"
  for file; do
    place=${file#*:}
    file=${file%%:*}
    mkdir -p "$folder/$(dirname "$place")"
    cp -rL "$file" "$folder/$place"
    [[ -d $file ]] || add_libraries "$architecture" "$file" "$folder" || return
  done
  mkdir -p "$board/guests/$name"
  pack "$folder" "$board/guests/$name/root.img"
  rm -rf "$folder"
}

# ---- guests ----

# guest ARCHITECTURE real|virtual IMAGE NAME SECONDS SCRIPT [ARGUMENT,...] [-- KERNEL'S PARAMETERS]:
# boots it, ends with its exit code; 124: hung, 125: it has not said how it went. In virtual time an
# instruction takes 2 ns, idle time passes at once, and the same image does the same to the bit.
# $board_devices: more of qemu's arguments.
guest() {
  local architecture=$1 time=$2 image=$3 name=$4 limit=$5 script=$6 arguments=${7:-} extra=${8:-}
  local folder=$board/guests/$name kernel=$board/$architecture code
  local -a qemu
  local line="quiet panic=-1 board.script=$script board.arguments=$arguments $extra"
  mkdir -p "$folder"
  rm -f "$folder/console.log"
  case $architecture in
    amd64)
      qemu=(qemu-system-x86_64 -M pc -cpu max -device "isa-debug-exit,iobase=0x501,iosize=1")
      line="console=ttyS0 $line"
      ;;
    arm64)
      qemu=(qemu-system-aarch64 -M "virt,dtb-randomness=off" -cpu cortex-a53)
      line="console=ttyAMA0 $line"
      ;;
  esac
  case $time in
    real) qemu+=(-accel "tcg,thread=multi" -smp 2) ;;
    virtual)
      qemu+=(-accel tcg -smp 1 -icount "shift=1,sleep=off" -rtc "base=2026-01-01,clock=vm" -seed 1)
      line+=' nokaslr norandmaps randomize_kstack_offset=off'
      ;;
  esac
  # shellcheck disable=SC2086 # several arguments
  timeout -k 5 "$limit" "${qemu[@]}" ${board_devices:-} -m 512 -nodefaults -no-user-config -display none -no-reboot \
    -kernel "$kernel/boot/vmlinuz-$(<"$kernel/RELEASE")" -initrd "$board/guests/$image/root.img" \
    -append "$line" -serial "file:$folder/console.log" >"$folder/qemu.log" 2>&1
  code=$?
  sed -i 's/\r$//' "$folder/console.log"
  case $code in
    124 | 137) code=124 ;;
    *)
      code=$(sed -nE 's/.*BOARD_EXIT ([0-9]+) .*/\1/p' "$folder/console.log" | tail -n 1)
      code=${code:-125}
      ;;
  esac
  show_guest "$name" "$code"
  return "$code"
}

# What it has said, where it went wrong; the failures first.
show_guest() {
  local name=$1 code=$2 log=$board/guests/$1/console.log
  case $code in
    0) return ;;
    124) say "guest $name: hung, ended at its time limit" ;;
    125) say "guest $name: no verdict" ;;
    *) say "guest $name: exit code $code" ;;
  esac
  {
    grep -a '^FAILED' "$log"
    printf -- '--- the end of %s\n' "$log"
    tail -n 40 "$log"
    cat "$board/guests/$name/qemu.log"
    printf -- '---\n'
  } >&2
}

# ---- the command ----

# Why this machine can not run it; nothing when it can.
board_obstacle() {
  if [[ -z $(debian_codename) ]]; then
    printf 'kernels are taken from Debian 12 or 13 only\n'
  elif [[ $(dpkg --print-architecture) != amd64 ]]; then
    printf 'the emulated boards are made on amd64 only\n'
  fi
}

# run_board_check NAME: its output goes into a log, its result into a file of NAME RESULT SECONDS.
run_board_check() {
  local name=$1 start=$SECONDS result=passed log=$logs/board-$1.log
  if ! "board_check_$name" >"$log" 2>&1; then
    result=FAILED
    sed "s/^/board-test $name: /" "$log" >&2
  fi
  printf '%-10s %-7s %5d s  %s\n' "$name" "$result" $((SECONDS - start)) \
    "$(board_checks | sed -n "s/^$name|//p")" >"$board/results/$name"
}

# Two at a time.
run_board_checks() {
  local name running=0
  for name; do
    if ((running == 2)); then
      wait -n || true
      running=1
    fi
    run_board_check "$name" &
    running=$((running + 1))
  done
  wait
}

print_board_results() {
  local name
  printf '\n'
  for name; do
    [[ ! -f $board/results/$name.txt ]] || cat "$board/results/$name.txt" <(printf '\n')
  done
  for name; do
    cat "$board/results/$name"
  done
}

board_all() {
  local obstacle name
  local -a names=("$@")
  obstacle=$(board_obstacle)
  if [[ -n $obstacle ]]; then
    say "SKIPPED: the emulated board is not run on this machine: $obstacle"
    counted="SKIPPED: $obstacle"
    [[ ${SMASERVO_SKIP:-} != never ]]
    return
  fi
  mkdir -p "$logs"
  setup_board || return
  ((${#names[@]})) || mapfile -t names < <(board_checks | cut -d'|' -f1)
  build_for_board || return
  rm -rf "$board/results"
  mkdir -p "$board/results"
  say "running on the emulated board: ${names[*]}"
  run_board_checks "${names[@]}"
  print_board_results "${names[@]}"
  # shellcheck disable=SC2034 # for the summary
  counted="${#names[@]} checks"
  for name in "${names[@]}"; do
    grep -q ' passed ' "$board/results/$name" || return
  done
}

run_board_test() {
  local name
  for name; do
    board_checks | grep -q "^$name|" ||
      die "board-test: unknown check: $name ($(board_checks | cut -d'|' -f1 | xargs))"
  done
  run_setup
  board_all "$@"
}
