# shellcheck shell=bash disable=SC2154 # root and logs are set by toolchain/dev, board by board.sh
# Kernels, modules and tools of the emulated boards, in $kernels. Sourced by toolchain/dev.

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

board_apt() { apt_for amd64 "$kernels/apt" -o APT::Architectures=amd64,arm64 "$@"; }

board_show() {
  apt_with apt-cache amd64 "$kernels/apt" -o APT::Architectures=amd64,arm64 --no-all-versions show "$1"
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
  local out=$kernels/gpio-sim version name
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

# build_modules ARCHITECTURE: ours and gpio-sim, into the kernel's.
build_modules() {
  local architecture=$1 release folder=$kernels/$1
  local out=$folder/module
  local -a options=()
  [[ $architecture == amd64 ]] || options=(ARCH=arm64 CROSS_COMPILE=aarch64-linux-gnu-)
  release=$(<"$folder/RELEASE")
  rm -rf "$out"
  mkdir -p "$out" "$folder/lib/modules/$release/extra"
  cp "$root"/toolchain/board/module/{Makefile,*.c} "$kernels/gpio-sim"/*.c "$out"
  make -s -C "$folder/headers/usr/src/linux-headers-$release" "${options[@]}" M="$out" modules || return
  cp "$out"/*.ko "$folder/lib/modules/$release/extra/"
  depmod -b "$folder" "$release"
}

# The package of the newest kernel.
kernel_package() {
  board_show "$(kernel_metapackage "$1"):$1" | sed -nE 's/^Depends: (linux-image-[^ ,]*).*/\1/p'
}

# make_kernel ARCHITECTURE FOLDER: vmlinuz, modules, headers and their RELEASE.
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
  # Headers name each other by absolute paths; their vmlinux is for tools that we have not.
  sed -i "s#/usr/src/#$folder/headers/usr/src/#" "$folder"/headers/usr/src/*/Makefile
  rm -f "$folder"/headers/usr/src/*/vmlinux
  printf '%s\n' "$release" >"$folder/RELEASE"
}

# Programs of Debian for a guest of another architecture; those of this one are installed.
make_tools() {
  local architecture=$1 folder=$2 backports=''
  [[ $(debian_release) != 12 ]] || backports=/bookworm-backports
  fetch "$folder/tools" "busybox-static:$architecture" "can-utils:$architecture" \
    "gpiod:$architecture$backports" "libgpiod3:$architecture$backports"
}

build_all_modules() { build_modules amd64 && build_modules arm64; }

make_board() {
  rm -rf "$kernels"/{amd64,arm64,apt,gpio-sim,gpio-sim.debs}
  board_sources "$(debian_codename)" | start_apt "$kernels/apt"
  board_apt update || return
  make_gpio_sim || return
  make_kernel amd64 "$kernels/amd64" &
  local amd64=$!
  make_kernel arm64 "$kernels/arm64" && make_tools arm64 "$kernels/arm64" || return
  wait "$amd64" || return
  rm -rf "$kernels/apt"
}

# made STAMP COMMAND FILE...: runs it unless it has made this of these files already; one at a time.
made() {
  local stamp=$kernels/$1 command=$2 key
  shift 2
  mkdir -p "$kernels"
  {
    flock 8
    key=$({
      debian_codename
      cat "$@"
    } | sha256sum)
    if [[ -f $stamp && $(<"$stamp") == "$key" ]]; then
      return
    fi
    say "emulated board: $command"
    "$command" || return
    printf '%s\n' "$key" >"$stamp"
  } 8>"$kernels/lock"
}

# Kernels, modules and tools of both architectures, once for a machine; anew when what makes them changes.
setup_board() {
  local obstacle
  obstacle=$(board_obstacle)
  [[ -z $obstacle ]] || {
    say "no emulated board on this machine: $obstacle"
    return 1
  }
  made kernels-from make_board "$root/toolchain/lib/board_kernel.sh" &&
    made modules-from build_all_modules "$root"/toolchain/board/module/{Makefile,*.c} "$kernels"/*/RELEASE
}
