# shellcheck shell=bash disable=SC2154 # root and logs are set by toolchain/dev
# The libraries of another architecture, unpacked below build/. Sourced by toolchain/dev.

# apt_for ARCHITECTURE FOLDER ARGUMENTS...: apt-get that knows nothing of this system but how to reach
# the archive, and changes nothing outside of the folder.
apt_for() {
  local architecture=$1 folder=$2
  shift 2
  apt-get -y -q \
    -o APT::Architecture="$architecture" -o APT::Architectures="$architecture" \
    -o APT::Install-Recommends=false -o APT::Sandbox::User=root \
    -o Dir::State="$folder" -o Dir::State::status="$folder/status" -o Dir::Cache="$folder" \
    -o Dir::Etc::SourceList="$folder/sources.list" -o Dir::Etc::SourceParts=/dev/null \
    -o Dir::Etc::Preferences=/dev/null -o Dir::Etc::PreferencesParts=/dev/null "$@"
}

# The libraries that packages.txt lists, as apt-get wants them, and what these leave open.
sysroot_packages() {
  local package suite
  printf '%s\n' libblas-dev libc6-dev liblapack-dev
  listed_packages | while read -r package suite; do
    [[ $package != *-dev ]] || printf '%s\n' "$package${suite:+/$suite}"
  done
}

# The archive's suites that they come from.
sysroot_sources() {
  local codename=$1 mirror suite
  mirror=$(debian_mirror "$codename")
  {
    printf '%s\n' "$codename"
    listed_packages | awk '$2 != "" { print $2 }'
  } | sort -u | while read -r suite; do
    source_line "$mirror" "$suite"
  done
}

# What an installation would do to unpacked packages: links to absolute paths point into the folder;
# BLAS and LAPACK get the names that update-alternatives gives them; Debian's Ceres names libraries by
# absolute paths.
settle_sysroot() {
  local folder=$1 libraries=$1/usr/lib/$2 link file
  while IFS= read -r -d '' link; do
    ln -srfn "$folder$(readlink "$link")" "$link"
  done < <(find "$folder" -type l -lname '/*' -print0)
  for file in "$libraries"/{blas,lapack}/*.so*; do
    ln -srf "$file" "$libraries"
  done
  # shellcheck disable=SC2016 # CMake's variable
  sed -i -E '/INTERFACE_LINK_LIBRARIES/s#([;"])/usr/lib/#\1${_IMPORT_PREFIX}/lib/#g' \
    "$libraries/cmake/Ceres/CeresTargets.cmake"
}

# unpack_sysroot ARCHITECTURE TRIPLET FOLDER
unpack_sysroot() {
  local architecture=$1 triplet=$2 folder=$3 codename packages package
  codename=$(debian_codename)
  if [[ -z $codename ]]; then
    say "libraries for $architecture are taken from Debian 12 or 13 only"
    return 1
  fi
  mapfile -t packages < <(sysroot_packages)
  rm -rf "$folder"
  mkdir -p "$folder/apt/lists/partial" "$folder/apt/archives/partial" "$folder/usr/lib"
  ln -s usr/lib "$folder/lib"
  : >"$folder/apt/status"
  sysroot_sources "$codename" >"$folder/apt/sources.list"
  apt_for "$architecture" "$folder/apt" update || return
  apt_for "$architecture" "$folder/apt" install --download-only "${packages[@]}" || return
  for package in "$folder"/apt/archives/*.deb; do
    dpkg-deb --extract "$package" "$folder" || return
  done
  rm -rf "$folder/apt"
  settle_sysroot "$folder" "$triplet"
}

# sysroot ARCHITECTURE TRIPLET: build/sysroot/TRIPLET, made anew when what it is made from changes.
sysroot() {
  local folder=$root/build/sysroot/$2 key
  key=$({
    debian_codename
    sysroot_packages
    cat "$root/toolchain/lib/sysroot.sh"
  } | sha256sum)
  if [[ -f $folder/made-from && $(<"$folder/made-from") == "$key" ]]; then
    return
  fi
  say "unpacking libraries for $1"
  step "sysroot-$1" unpack_sysroot "$1" "$2" "$folder" || return
  printf '%s\n' "$key" >"$folder/made-from"
}
