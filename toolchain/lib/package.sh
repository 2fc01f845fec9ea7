# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# Debian packages, and what is checked of them. Sourced by toolchain/dev.

# architecture|preset|triplet of the foreign libraries|program that runs its programs; without the
# last two: what this machine is.
package_targets() {
  local native
  native=$(dpkg --print-architecture)
  printf '%s|release||\n' "$native"
  printf '%s\n' 'arm64|arm64|aarch64-linux-gnu|qemu-aarch64' 'armhf|armhf|arm-linux-gnueabihf|qemu-arm' |
    grep -v "^$native|"
}

package_target() { package_targets | grep "^$1|"; }

# package_file ARCHITECTURE [PACKAGE]
package_file() { printf '%s\n' "$root"/build/packages/"${2:-smaservo}"_*_"$1".deb | tail -n 1; }

# library_packages TREE TRIPLET PROGRAM...: what the programs need of the distribution, by dpkg-shlibdeps.
# Foreign libraries belong to no package that is installed here: their own packages' words decide.
library_packages() {
  local tree=$1 triplet=$2 sysroot=$root/build/sysroot/$2
  local -a where=() programs
  mapfile -t programs < <(printf -- "-e$tree/%s\n" "${@:3}")
  [[ -z $triplet ]] || where=("-l$sysroot/usr/lib/$triplet" "-l$sysroot/lib/$triplet" "-l$sysroot/lib"
    "-L$sysroot/shlibs")
  mkdir -p "$tree/shlibs/debian"
  printf 'Source: smaservo\n\nPackage: smaservo\nArchitecture: any\n' >"$tree/shlibs/debian/control"
  (cd "$tree/shlibs" && dpkg-shlibdeps -O --warnings=0 "${where[@]}" "${programs[@]}") |
    sed -nE 's/^shlibs:Depends=(.+)$/\1/p' | grep .
}

# python_needs TREE: what python3-smaservo needs, if the tree has it.
python_needs() {
  local core needed
  core=$(cd "$1" && printf '%s\n' host-sim/python/smaservo/_core*.so)
  [[ -e $1/$core ]] || return 0
  needed=$(library_packages "$1" '' "$core") || return
  # The extension's name has the version of Python that it is for.
  local minor=${core#*cpython-3}
  minor=${minor%%-*}
  printf '%s, python3 (>= 3.%d~), python3 (<< 3.%d), python3-numpy\n' "$needed" "$minor" "$((minor + 1))"
}

# make_package ARCHITECTURE PRESET TRIPLET: build/packages/smaservo_VERSION_ARCHITECTURE.deb, libsmaservo-dev_ the same,
# and of this machine's architecture python3-smaservo_. What smaservo-table alone needs is recommended: a board that reads no spreadsheets does without.
make_package() {
  local architecture=$1 tree=$root/build/$2 needed recommended python
  python=$(python_needs "$tree") || return
  needed=$(library_packages "$tree" "$3" firmware/daemon/smaservod host-sim/host-sim) || return
  recommended=$(library_packages "$tree" "$3" lib/smaservo/smaservo-table) || return
  recommended=$(comm -13 <(tr , '\n' <<<"$needed" | sed -E 's/^ | [(].*//g' | sort) \
    <(tr , '\n' <<<"$recommended" | sed -E 's/^ | [(].*//g' | sort) | paste -sd, | sed 's/,/, /g')
  SOURCE_DATE_EPOCH=$(git -C "$root" log -1 --format=%ct) \
    cpack --config "$tree/CPackConfig.cmake" -G DEB -B "$root/build/packages" \
    -D CPACK_DEBIAN_PACKAGE_ARCHITECTURE="$architecture" \
    -D CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS="$needed, systemd" \
    -D CPACK_DEBIAN_PROGRAMS_PACKAGE_RECOMMENDS="$recommended" \
    -D CPACK_DEBIAN_PYTHON3_PACKAGE_DEPENDS="$python" || return
  rm -rf "$root/build/packages/_CPack_Packages"
}

run_package() {
  local architecture preset triplet
  # shellcheck disable=SC2046 # several architectures
  (($#)) || set -- $(package_targets | cut -d'|' -f1)
  for architecture in "$@"; do
    package_target "$architecture" >/dev/null ||
      die "package: $architecture cannot be made here ($(package_targets | cut -d'|' -f1 | xargs))"
  done
  run_setup
  for architecture in "$@"; do
    IFS='|' read -r _ preset triplet _ < <(package_target "$architecture")
    [[ -z $triplet ]] || step "sysroot-$architecture" sysroot "$architecture" "$triplet" || return
    # The arm64 tree also has tests, which compare with what this machine's host-sim says.
    [[ $preset != arm64 ]] || build release host-sim || return
    build "$preset" package_contents || return
    step "package-$architecture" make_package "$architecture" "$preset" "$triplet" || return
    near "$(package_file "$architecture")"
    near "$(package_file "$architecture" libsmaservo-dev)"
    [[ -n $triplet ]] || near "$(package_file "$architecture" python3-smaservo)"
  done
}

# --- what is checked of them ----------------------------------------------------------------------

# scratch_install PACKAGE FOLDER: by dpkg, with its scripts, into a system of its own.
scratch_install() {
  local package=$1 folder=$2
  rm -rf "$folder"
  mkdir -p "$folder"/{etc,usr/bin,usr/sbin,usr/lib,var/lib/dpkg/{info,updates,triggers}}
  : >"$folder/var/lib/dpkg/status"
  : >"$folder/var/lib/dpkg/available"
  dpkg --root="$folder" --force-not-root --force-script-chrootless --force-depends \
    --force-architecture --install "$package" &&
    dpkg --root="$folder" --force-not-root --force-depends --verify smaservo &&
    grep -q '^smaservo:' "$folder/etc/passwd"
}

# scratch_remove FOLDER: nothing of it may stay but its user.
scratch_remove() {
  local left
  mkdir -p "$1/var/lib/smaservo"
  dpkg --root="$1" --force-not-root --force-script-chrootless --force-depends --force-architecture \
    --purge smaservo || return
  left=$(find "$1" -path "$1/var/lib/dpkg" -prune -o -iname '*smaservo*' -print -o -name 'host-sim*' -print)
  [[ -z $left ]] || {
    printf 'left after the purge:\n%s\n' "$left"
    return 1
  }
}

# man_page_has PAGE COMMAND...: each option and each sub-command of its help.
man_page_has() {
  local page=$1 help text word
  shift
  help=$("$@" --help) && text=$(zcat "$page" | sed 's/\\-/-/g') || return
  {
    grep -oE -- '--[a-z][a-z-]+' <<<"$help"
    sed -nE '/^Subcommands:/,$ s/^  ([a-z-]+) .*/.B \1/p' <<<"$help"
  } | sort -u | while read -r word; do
    grep -qF -- "$word" <<<"$text" || {
      printf '%s: %s is missing\n' "$page" "$word"
      return 1
    }
  done
}

completes() {
  local folder=$1 words=$2
  # shellcheck disable=SC2016 # of the inner shell
  PATH=$folder/usr/sbin:$folder/usr/bin:$PATH bash -c '
    . "$1/usr/share/bash-completion/completions/host-sim"
    read -r -a COMP_WORDS <<<"$2"; COMP_WORDS+=("$3"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
    _smaservo; printf "%s\n" "${COMPREPLY[@]}"' - "$folder" "$words" "$3" | grep -qxF -- "$4"
}

# What needs a program that runs here as it is.
check_programs() {
  local folder=$1 units=$1/usr/lib/systemd/system
  # What the unit names beside itself.
  cp -r --update=none /lib/systemd/system "$folder/usr/lib/systemd/" 2>/dev/null ||
    cp -rn /lib/systemd/system "$folder/usr/lib/systemd/" || return
  ln -sfn usr/bin "$folder/bin"
  cp /bin/sh /bin/kill "$folder/usr/bin/" || return
  systemd-analyze verify --root="$folder" --man=no smaservod.service smaservo-page.service || return
  # In tenths on a scale to 10; 2.2 and 1.5 today, and a service that nobody hardened has 9.6.
  systemd-analyze security --offline=true --threshold=25 --no-pager "$units/smaservod.service" || return
  systemd-analyze security --offline=true --threshold=18 --no-pager "$units/smaservo-page.service" || return
  man_page_has "$folder/usr/share/man/man8/smaservod.8.gz" "$folder/usr/sbin/smaservod" &&
    man_page_has "$folder/usr/share/man/man1/host-sim.1.gz" "$folder/usr/bin/host-sim" &&
    man_page_has "$folder/usr/share/man/man8/smaservo-setup.8.gz" \
      bash "$folder/usr/sbin/smaservo-setup" &&
    "$folder/usr/bin/host-sim" export-fmu --wire smartflex-76um --kind servo --out "$folder/servo.fmu" &&
    completes "$folder" smaservod --che --check &&
    completes "$folder" host-sim simu simulate &&
    completes "$folder" 'host-sim can' sca scan &&
    completes "$folder" 'host-sim simulate' --scen --scenario
}

# check_says FOLDER COMMAND...: what smaservod prints where nothing of a board is there names what is
# missing.
check_says() {
  local folder=$1 code=0 said
  shift
  said=$("$@" "$folder/usr/sbin/smaservod" --board "$folder/usr/share/smaservo/boards/reference.toml" --check 2>&1) || code=$?
  printf '%s\n' "$said"
  [[ $code == 1 && $said == *spidev0.1* && $said == *smaservo-kick* && $said == *'settings'*ok* ]]
}

# check_running FOLDER COMMAND...: its programs, run by the command, on what it brings along.
check_running() {
  local folder=$1 share=$1/usr/share/smaservo scratch
  shift
  scratch=$(mktemp -d)
  "$@" "$folder/usr/sbin/smaservod" --version &&
    check_says "$folder" "$@" &&
    "$@" "$folder/usr/bin/host-sim" --version &&
    # Simulated by this machine's own, replayed to 1e-5 of each column's range.
    "$root/build/release/host-sim/host-sim" simulate --scenario "$share/scenarios/steps.toml" \
      --out "$scratch/here.csv" &&
    "$@" "$folder/usr/bin/host-sim" replay-device "$share/scenarios/devices/sublayers-1000.toml" \
      --tolerance 1e-5 "$scratch/here.csv" &&
    # A minute of the daemon itself.
    "$@" "$folder/usr/sbin/smaservod" --board sim --at-once --for 60 --no-real-time --json \
      --settings "$scratch" --status "$scratch/status" >"$scratch/figures" &&
    grep -qE '"cycles": *(5999|6000)[0-9]' "$scratch/figures"
  local code=$?
  cat "$scratch/figures" 2>/dev/null
  rm -rf "$scratch"
  return "$code"
}

# Any BLAS and LAPACK will do, whatever this machine has chosen. A board gets no HDF5.
check_needed() {
  local needed recommended
  recommended=$(dpkg-deb --field "$1" Recommends)
  printf 'recommended: %s\n' "$recommended"
  [[ $recommended == *libexpat1*libmatio*libzip* ]] || return
  needed=$(dpkg-deb --field "$1" Depends)
  printf '%s\n' "$needed"
  [[ $needed != *atlas* && $needed != *openblas* && $needed != *matio* && $needed != *libzip* &&
    $needed == *'liblapack3 | liblapack.so.3'* ]]
}

# check_package ARCHITECTURE
check_package() {
  local triplet runner package folder=$root/build/packages/root-$1
  IFS='|' read -r _ _ triplet runner < <(package_target "$1")
  package=$(package_file "$1")
  lintian --tag-display-limit 0 --allow-root --fail-on error,warning "$package" || return
  check_needed "$package" || return
  scratch_install "$package" "$folder" || return
  [[ -n $triplet ]] || check_programs "$folder" || return
  if [[ -n $runner ]]; then
    check_running "$folder" "$runner" -L "$root/build/sysroot/$triplet" || return
  else
    check_running "$folder" env || return
  fi
  scratch_remove "$folder"
}

# check_library ARCHITECTURE: libsmaservo-dev. Of this machine's architecture a program is built against it, where it
# was unpacked.
check_library() {
  local triplet package folder=$root/build/packages/library-$1 file
  IFS='|' read -r _ _ triplet _ < <(package_target "$1")
  package=$(package_file "$1" libsmaservo-dev)
  lintian --tag-display-limit 0 --allow-root --fail-on error,warning "$package" || return
  [[ $(dpkg-deb --field "$package" Section) == libdevel &&
    $(dpkg-deb --field "$package" Depends) == libeigen3-dev*libfmt-dev*libtomlplusplus-dev*liblzma-dev* ]] || {
    dpkg-deb --info "$package"
    return 1
  }
  rm -rf "$folder"
  dpkg-deb --extract "$package" "$folder" || return
  local libraries=$folder/usr/lib/${triplet:-$(dpkg-architecture --query DEB_HOST_MULTIARCH)}
  for file in "$libraries"/{libsmaservo.a,cmake/smaservo/smaservo-config.cmake,pkgconfig/smaservo.pc} \
    "$folder"/usr/include/smaservo/{model/units,observer/estimate,firmware/device/device,hal/board}.hpp; do
    [[ -s $file ]] || {
      printf '%s is not in %s\n' "$file" "$package"
      return 1
    }
  done
  [[ -z $(find "$folder/usr" -mindepth 1 -maxdepth 1 ! -name lib ! -name include ! -name share) ]] || return
  [[ -n $triplet ]] || "$root/tests/library/library_test.py" cmake "$folder/usr" "$root" g++
}

# check_python ARCHITECTURE: python3-smaservo, as it was unpacked.
check_python() {
  local package folder=$root/build/packages/python-$1
  package=$(package_file "$1" python3-smaservo)
  lintian --tag-display-limit 0 --allow-root --fail-on error,warning "$package" || return
  [[ $(dpkg-deb --field "$package" Depends) == *libc6*'python3 (>= 3.'*python3-numpy* ]] || {
    dpkg-deb --info "$package"
    return 1
  }
  rm -rf "$folder"
  dpkg-deb --extract "$package" "$folder" || return
  (cd "$root" && PYTHONPATH=$folder/usr/lib/python3/dist-packages PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 -c '
import smaservo, sys
assert smaservo.__file__.startswith(sys.argv[1]), smaservo.__file__
recording = smaservo.read("host-sim/traces/150MPa.csv")
estimate = smaservo.replay("host-sim/traces/units/a.toml", recording)
assert abs(estimate.strain[-1] - recording.strain_ref[-1]) < 1e-3' "$folder")
}

# test_package [ARCHITECTURE...]: makes the packages, looks at them, installs and runs what is in them.
test_package() {
  local architecture
  # shellcheck disable=SC2046 # several architectures
  (($#)) || set -- $(package_targets | cut -d'|' -f1)
  run_package "$@" || return
  build release host-sim || return
  for architecture in "$@"; do
    say "checking the package for $architecture"
    step "package-check-$architecture" check_package "$architecture" || return
    step "library-check-$architecture" check_library "$architecture" || return
    [[ $architecture != $(dpkg --print-architecture) ]] ||
      step "python-check-$architecture" check_python "$architecture" || return
  done
}
