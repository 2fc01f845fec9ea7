# shellcheck shell=bash disable=SC2154 # root and logs are set by toolchain/dev, board by board.sh
# A Debian system as the disk of a guest, in $kernels/root. Sourced by toolchain/dev.

# What a package needs, the first of alternatives each.
needed_by() { dpkg-deb --field "$1" Depends | tr ',' '\n' | sed -E 's/^ *//; s/[ (|:].*//'; }

# Nothing at its start that a test does not need: consoles to log in at, daily work.
root_masked='getty.target apt-daily.timer apt-daily-upgrade.timer dpkg-db-backup.timer
  e2scrub_all.timer e2scrub_reap.service fstrim.timer systemd-tmpfiles-clean.timer'

# unpack_root FOLDER: to be run in fakeroot, which keeps the owners whoever this is.
unpack_root() {
  local folder=$1 unit
  mkdir "$folder/root"
  tar -xf "$folder/root.tar" -C "$folder/root" --exclude='./dev/*' || return 1
  for unit in $root_masked; do
    ln -sfn /dev/null "$folder/root/etc/systemd/system/$unit"
  done
  printf 'board\n' >"$folder/root/etc/hostname"
  mke2fs -q -t ext4 -d "$folder/root" "$folder/disk.img" 640M
}

# Minimal, with systemd and the packages that build/board/root-packages lists, without documentation.
make_root() {
  local folder=$kernels/root packages
  packages=$(paste -sd , "$kernels/root-packages")
  rm -rf "$folder"
  mkdir -p "$folder"
  board_sources "$(debian_codename)" | mmdebstrap --variant=apt \
    --include="systemd-sysv,udev,kmod,iproute2,$packages" \
    --dpkgopt='path-exclude=/usr/share/doc/*' --dpkgopt='path-exclude=/usr/share/man/*' \
    --dpkgopt='path-exclude=/usr/share/locale/*' "$(debian_codename)" "$folder/root.tar" - || return
  root_masked=$root_masked fakeroot bash -c "$(declare -f unpack_root)
    unpack_root \"\$1\"" - "$folder" || return
  rm -rf "$folder/root" "$folder/root.tar"
}

# setup_root PACKAGE.deb: with all that it needs; anew when that changes.
setup_root() {
  mkdir -p "$kernels"
  needed_by "$1" >"$kernels/root-packages"
  made root-from make_root "$root/toolchain/lib/board_root.sh" "$kernels/root-packages"
}
