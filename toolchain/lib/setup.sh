# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# Installs what toolchain/packages.txt lists. Sourced by toolchain/dev.

say() { printf '%s\n' "$*" >&2; }

die() {
  say "toolchain/dev: $*"
  exit 1
}

# Prints 12 or 13: the release of Debian that this is or is derived from; else nothing.
debian_release() {
  [[ -r /etc/os-release ]] || return 0
  local id='' like='' codename='' debian=''
  id=$(. /etc/os-release && printf '%s' "${ID:-}")
  like=$(. /etc/os-release && printf '%s' "${ID_LIKE:-}")
  codename=$(. /etc/os-release && printf '%s' "${DEBIAN_CODENAME:-${VERSION_CODENAME:-}}")
  [[ " $id $like " == *' debian '* ]] || return 0
  [[ -r /etc/debian_version ]] && debian=$(</etc/debian_version)
  case $codename:$debian in
    bookworm:* | *:12 | *:12.* | *:bookworm/*) printf '12\n' ;;
    trixie:* | *:13 | *:13.* | *:trixie/*) printf '13\n' ;;
  esac
}

debian_codename() {
  case $(debian_release) in
    12) printf 'bookworm\n' ;;
    13) printf 'trixie\n' ;;
  esac
}

# listed_packages [all]: "package suite" of each package of packages.txt, up to its line "all:" or beyond it; the suite
# is empty where it does not matter.
listed_packages() {
  local release package suite
  release=$(debian_release)
  if [[ ${1:-} == all ]]; then
    sed 's/#.*//; /^all:/d' "$root/toolchain/packages.txt"
  else
    sed 's/#.*//; /^all:/,$d' "$root/toolchain/packages.txt"
  fi | while read -r package suite _; do
    [[ $release == 12 ]] || suite=''
    [[ -z $package ]] || printf '%s %s\n' "$package" "$suite"
  done
}

# The same of those that are not installed.
missing_packages() {
  local package suite
  listed_packages "$@" | while read -r package suite; do
    if ! is_installed "$package" "$suite"; then
      printf '%s %s\n' "$package" "$suite"
    fi
  done
}

# is_installed PACKAGE [SUITE]: an older version of a package from backports does not count. Another
# vendor's node brings npm along, and Debian's npm would not go with it.
is_installed() {
  local status
  if [[ $1 == npm ]] && command -v npm >/dev/null; then return; fi
  status=$(dpkg-query -W -f='${db:Status-Status} ${Version}' "$1" 2>/dev/null) || return
  [[ $status == 'installed '* && (${2:-} != *-backports || $status == *~bpo*) ]]
}

# Every configured source of packages as "URI SUITE"; apt knows them after its first update.
apt_sources() {
  # shellcheck disable=SC2016 # apt's variables
  apt-get indextargets --format '$(REPO_URI) $(RELEASE)' 'Created-By: Packages' 2>/dev/null | sed 's|/ | |' | sort -u
}

# debian_mirror CODENAME: the mirror that the system takes this release of Debian from.
debian_mirror() {
  local uri
  uri=$(apt_sources | awk -v suite="$1" '$2 == suite { print $1; exit }')
  printf '%s\n' "${uri:-http://deb.debian.org/debian}"
}

as_root() {
  if ((EUID == 0)); then
    "$@"
  else
    sudo "$@"
  fi
}

# apt-get, quiet and without questions; the end of its log on failure.
apt_get() {
  mkdir -p "$logs"
  if ! as_root env DEBIAN_FRONTEND=noninteractive apt-get -y -q -o Acquire::Retries=3 -o DPkg::Lock::Timeout=600 "$@" >"$logs/apt.log" 2>&1; then
    show_end "$logs/apt.log"
    say "apt-get $1 failed; the whole log is in $logs/apt.log"
    return 1
  fi
}

# source_line URI SUITE: as sources.list has it.
source_line() {
  local keyring=/usr/share/keyrings/debian-archive-keyring.gpg
  local options=''
  [[ -r $keyring ]] && options="[signed-by=$keyring] "
  printf 'deb %s%s %s main\n' "$options" "$1" "$2"
}

# Adds a suite to the sources unless it is there.
add_suite() {
  local suite=$1 uri
  if apt_sources | awk -v suite="$suite" '$2 == suite { found = 1 } END { exit !found }'; then
    return
  fi
  uri=$(debian_mirror bookworm)
  local list=/etc/apt/sources.list.d/smaservo.list
  say "adding $suite of $uri in $list"
  {
    printf '# Added by toolchain/dev setup of smaservo.\n'
    source_line "$uri" "$suite"
  } | as_root tee "$list" >/dev/null
  apt_get update
}

# install_packages [all]
install_packages() {
  local release missing package suite
  release=$(debian_release)
  if ! command -v dpkg-query >/dev/null; then
    die "this is not a Debian system (no dpkg); install by hand what toolchain/packages.txt lists"
  fi
  missing=$(missing_packages "$@")
  if [[ -z $missing ]]; then
    return
  fi
  if [[ -z $release ]]; then
    say "missing: $(cut -d' ' -f1 <<<"$missing" | xargs)"
    die "this is not Debian 12 or 13 or derived from them; install these, or what is closest, by hand"
  fi
  if ((EUID != 0)) && ! command -v sudo >/dev/null; then
    say "missing: $(cut -d' ' -f1 <<<"$missing" | xargs)"
    die "installing needs root, and there is no sudo; run 'toolchain/dev setup' as root once"
  fi
  local -a plain=()
  local -A from=()
  while read -r package suite; do
    if [[ -n $suite ]]; then
      from[$suite]+=" $package"
    else
      plain+=("$package")
    fi
  done <<<"$missing"
  say "installing: $(cut -d' ' -f1 <<<"$missing" | xargs)"
  apt_get update || say 'going on with the package lists that are there'
  for suite in "${!from[@]}"; do
    add_suite "$suite" || exit
  done
  if ((${#plain[@]})); then
    apt_get install --no-install-recommends "${plain[@]}" || exit
  fi
  for suite in "${!from[@]}"; do
    # shellcheck disable=SC2086 # several packages
    apt_get install --no-install-recommends -t "$suite" ${from[$suite]} || exit
  done
}

run_setup() {
  install_packages all
}
