# shellcheck shell=bash disable=SC2154 # root and logs are set by toolchain/dev
# The libraries of another architecture, unpacked. Sourced by toolchain/dev.

# apt_with TOOL ARCHITECTURE FOLDER ARGUMENTS...: an apt tool that knows nothing of this system but how
# to reach the archive, and changes nothing outside of the folder.
apt_with() {
  local tool=$1 architecture=$2 folder=$3
  shift 3
  "$tool" -q -o Acquire::Retries=3 \
    -o APT::Architecture="$architecture" -o APT::Architectures="$architecture" \
    -o APT::Install-Recommends=false -o APT::Sandbox::User=root \
    -o Dir::State="$folder" -o Dir::State::status="$folder/status" -o Dir::Cache="$folder" \
    -o Dir::Etc::SourceList="$folder/sources.list" -o Dir::Etc::SourceParts=/dev/null \
    -o Dir::Etc::Preferences=/dev/null -o Dir::Etc::PreferencesParts=/dev/null "$@"
}

# apt_for ARCHITECTURE FOLDER ARGUMENTS...: its apt-get.
apt_for() { apt_with apt-get "$@" -y; }

# start_apt FOLDER: an apt of no packages, whose sources come from the standard input.
start_apt() {
  mkdir -p "$1/lists/partial" "$1/archives/partial"
  : >"$1/status"
  cat >"$1/sources.list"
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

# What a package says of its shared libraries and who depends on them; most have none.
shlibs_of() {
  dpkg-deb --ctrl-tarfile "$1" | tar -x --to-stdout --wildcards './shlibs' 2>/dev/null || true
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
  mkdir -p "$folder/usr/lib"
  ln -s usr/lib "$folder/lib"
  sysroot_sources "$codename" | start_apt "$folder/apt"
  apt_for "$architecture" "$folder/apt" update || return
  apt_for "$architecture" "$folder/apt" install --download-only "${packages[@]}" || return
  for package in "$folder"/apt/archives/*.deb; do
    dpkg-deb --extract "$package" "$folder" || return
    shlibs_of "$package" >>"$folder/shlibs"
  done
  rm -rf "$folder/apt"
  settle_sysroot "$folder" "$triplet"
}

# sysroot ARCHITECTURE TRIPLET: build/sysroot/TRIPLET leads to it. It is made once for a machine, anew when
# what it is made from changes.
sysroot() {
  local key folder
  key=$({
    debian_codename
    sysroot_packages
    cat "$root/toolchain/lib/sysroot.sh"
  } | sha256sum | cut -c 1-16)
  folder=$kept/sysroot/$2-$key
  mkdir -p "$kept/sysroot" "$root/build/sysroot"
  {
    flock 9
    if [[ ! -d $folder ]]; then
      say "unpacking libraries for $1"
      rm -rf "$kept/sysroot/$2"-*
      unpack_sysroot "$1" "$2" "$folder.new" && mv "$folder.new" "$folder" || return
    fi
  } 9>"$kept/sysroot/$1.lock"
  ln -sfn "$folder" "$root/build/sysroot/$2"
}
