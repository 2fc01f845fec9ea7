# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# An emulated board: Debian's real-time kernel in qemu. Kernels and disks are fetched and made once for a
# machine, guests below build/board. Sourced by toolchain/dev; what runs on it is in board_checks.sh.

board=$root/build/board
kernels=$kept/board

# ---- images ----

library_folders() {
  case $1 in
    amd64) printf '%s\n' /{,usr/}lib/x86_64-linux-gnu ;;
    arm64) printf '%s\n' "$kernels"/arm64/tools/{,usr/}lib/aarch64-linux-gnu \
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
  local kernel=$kernels/$architecture
  folder=$(mktemp -d)
  release=$(<"$kernel/RELEASE")
  mkdir -p "$folder"/{bin,sbin,usr/{bin,sbin,lib},proc,sys,dev,tmp,run,etc,modules,tests/board}
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
  cp "$root"/toolchain/board/{init,run-script} "$folder/"
  cp "$root"/tests/board/*.{sh,toml} "$folder/tests/board/"
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
# instruction takes 2 ns, and the same image does the same to the bit; the limit is then of processor time,
# which a guest that hangs takes as well, and which a busy machine does not use up.
# $board_devices: more of qemu's arguments. $board_processor: of this machine, to stay on.
guest() {
  local architecture=$1 time=$2 image=$3 name=$4 limit=$5 script=$6 arguments=${7:-} extra=${8:-}
  local folder=$board/guests/$name kernel=$kernels/$architecture code
  local -a qemu pinned=() limited
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
    real)
      # With a thread for each processor the kernel's own patching of its code can meet a processor
      # that still runs the breakpoint: an oops at "sched_clock: Marking stable".
      qemu+=(-accel "tcg,thread=single" -smp 2)
      limited=(timeout -k 5 "$limit")
      ;;
    virtual)
      limited=(prlimit --cpu="$limit" --)
      qemu+=(-accel tcg -smp 1 -icount "shift=1,sleep=off" -rtc "base=2026-01-01,clock=vm" -seed 1)
      line+=' nokaslr norandmaps randomize_kstack_offset=off'
      ;;
  esac
  [[ -z ${board_processor:-} ]] || pinned=(taskset -c "$board_processor")
  # shellcheck disable=SC2086 # several arguments
  "${limited[@]}" "${pinned[@]}" "${qemu[@]}" ${board_devices:-} -m 512 -nodefaults -no-user-config -display none -no-reboot \
    -kernel "$kernel/boot/vmlinuz-$(<"$kernel/RELEASE")" -initrd "$board/guests/$image/root.img" \
    -append "$line" -serial "file:$folder/console.log" >"$folder/qemu.log" 2>&1
  code=$?
  sed -i 's/\r$//' "$folder/console.log"
  case $code in
    124 | 137 | 152) code=124 ;;  # 152: SIGXCPU
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

# Why this machine cannot run it; nothing when it can.
board_obstacle() {
  if [[ -z $(debian_codename) ]]; then
    printf 'kernels are taken from Debian 12 or 13 only\n'
  elif [[ $(dpkg --print-architecture) != amd64 ]]; then
    printf 'the emulated boards are made on amd64 only\n'
  elif [[ $root == *[[:space:]]* ]]; then
    printf "Linux's make builds no module below a path with blanks: %s\\n" "$root"
  fi
}

# board_check NAME: one of tests/board/CMakeLists.txt, for ctest.
board_check() {
  mkdir -p "$board/results"
  rm -f "$board/results/$1.txt"
  setup_board && "board_check_$1"
}

# What they have measured.
print_board_results() {
  local table
  for table in "$board"/results/*.txt; do
    [[ ! -f $table ]] || cat "$table" <(printf '\n')
  done
}

# NAME|what it is, of each check.
board_checks() { sed -nE 's/^board_check\(([a-z0-9]+) "(.*)"\)$/\1|\2/p' "$root/tests/board/CMakeLists.txt"; }

run_board_test() {
  local name
  for name; do
    board_checks | grep -q "^$name|" ||
      die "board-test: unknown check: $name ($(board_checks | cut -d'|' -f1 | xargs))"
  done
  run_setup
  step kernels setup_board || return
  build release board_programs package_contents || return
  rm -rf "$board/results"
  (cd "$root" && ctest --preset release-boards -R "^Board[.]($(printf '%s\n' "${@:-.*}" | paste -sd '|'))\$")
  local code=$?
  print_board_results
  return "$code"
}
