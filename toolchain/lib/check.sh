# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# Formatting, static analysis and house rules. Sourced by toolchain/dev.

# Files of ours, tracked or new, that match the patterns; 0-terminated.
our_files() {
  (cd "$root" && git ls-files -z --cached --others --exclude-standard -- "$@" |
    while IFS= read -r -d '' file; do
      [[ ! -f $file ]] || printf '%s\0' "$file"
    done)
}

run_format() {
  run_setup
  our_files '*.cpp' '*.hpp' | (cd "$root" && xargs -0 -r clang-format-19 -i)
}

check_format() {
  our_files '*.cpp' '*.hpp' | (cd "$root" && xargs -0 -r clang-format-19 --dry-run -Werror)
}

check_shell() {
  {
    our_files '*.sh'
    our_files toolchain .ci | (cd "$root" && xargs -0 -r grep -lZE '^#!.*\b(ba)?sh$')
  } | sort -zu | (cd "$root" && xargs -0 -r shellcheck -x)
}

# Prints what breaks a rule, with file and line.
check_rules() {
  local broken=0
  rule() {
    local pattern=$1 reason=$2
    shift 2
    if our_files "$@" | (cd "$root" && xargs -0 -r grep -nHIE -- "$pattern"); then
      say "^ $reason"
      broken=1
    fi
  }
  rule '[[:blank:]]+$' 'blanks at the end of a line' '*.cpp' '*.hpp' '*.cmake' '*CMakeLists.txt' \
    '*.toml' '*.md' '*.sh' toolchain
  rule $'\t' 'a tab' '*.cpp' '*.hpp' '*.cmake' '*CMakeLists.txt' '*.toml' '*.md'
  rule '(^|[^[:alnum:]_./:])/(home|root|work|Users|mnt)/[[:alnum:]]' 'a path of one machine' \
    '*.cpp' '*.hpp' '*.cmake' '*CMakeLists.txt' '*.toml' '*.md' '*.sh' '*.json' '*.in' toolchain .ci
  rule '\b(TODO|FIXME|XXX)\b' 'an open end' '*.cpp' '*.hpp'
  # What comes from outside may command a terminal; model/files/message.hpp escapes it.
  rule '(fmt::print|std::(fputs|puts|printf|fprintf|fwrite|perror|cerr|cout|clog))\b' \
    'printed past model/files/message.hpp' 'model/*.cpp' 'model/*.hpp' 'observer/*.hpp' \
    'hal/linux/*.?pp' 'hal/replay/*.?pp' 'hal/sim/*.?pp' 'firmware/*.?pp' 'host-sim/*.?pp' \
    ':!firmware/mcu' ':!host-sim/examples' ':!model/files/message.cpp' ':!model/files/output_file.cpp'
  rule '^ *# *define +[[:alnum:]_]+ +\(?[-+]?[0-9]' 'a number as a macro' '*.cpp' '*.hpp'
  rule '\btypedef\b' 'a typedef; using says the same' '*.cpp' '*.hpp'
  return "$broken"
}

# Sources of the compile database that are ours, or those that were asked for; 0-terminated.
sources_to_tidy() {
  local database=$root/build/sanitize/compile_commands.json file together
  if (($#)); then
    (cd "$here" && realpath -- "$@") | while IFS= read -r file; do
      # What it is compiled together with, if it is.
      together=$(grep -rlF "\"$file\"" --include='unity_*.cxx' "$root/build/sanitize" | head -n 1)
      printf '%s\0' "${together:-$file}"
    done
    return
  fi
  # Folders that are compiled as one; then what is compiled by itself. Those that no target compiles
  # have no flags. What two targets compile is looked at once.
  local -a units
  mapfile -t units < <(sed -nE 's/^ *"file": "(.*\/Unity\/.*)",?$/\1/p' "$database")
  awk '/^#include "/ && !seen[$2]++ && FILENAME != last { last = FILENAME; printf "%s%c", last, 0 }' \
    "${units[@]}"
  our_files '*.cpp' | while IFS= read -r -d '' file; do
    if grep -qF "\"file\": \"$root/$file\"" "$database" &&
      ! grep -qxF "#include \"$root/$file\"" "${units[@]}"; then
      printf '%s\0' "$root/$file"
    fi
  done
}

# Checks that a source goes without, beside those of the .clang-tidy above it.
tidy_except() {
  case $1 in
    */tests/*/Unity/*) sed -nE 's/^ *- (-.*)$/\1/p' "$root/tests/.clang-tidy" | tr '\n' ',' ;;
  esac
  [[ $1 != */Unity/* ]] || printf -- '-bugprone-suspicious-include'
}

# What clang-tidy's answer for a source depends on, as one number: its command, its text and that
# of our headers in it, the configuration, the tool.
tidy_key() {
  local file=$1 database=$2 command rule
  local -a parts
  command=$(grep -F -B 1 "\"file\": \"$file\"" "$database" |
    sed -nE '/"command": /{ s/^ *"command": "(.*)",$/\1/; s/\\(.)/\1/g; s/ -o [^ ]+ -c / -MM /p }')
  # A rule of a Makefile: "object: source header header".
  rule=$(eval "$command") || return
  eval "parts=(${rule#*:})"
  {
    printf '%s\n' "$command"
    clang-tidy-22 --version
    cat "$root/.clang-tidy" "$root/tests/.clang-tidy" "${parts[@]}"
  } | sha256sum
}

# Looks at one source, unless it was clean before and nothing has changed.
tidy_one() {
  local file=$1 build=$root/build/sanitize key
  local stamp=$root/build/tidy/${file//\//-}
  key=$(tidy_key "$file" "$build/compile_commands.json" 2>/dev/null) || key=''
  if [[ -n $key && -f $stamp && $(<"$stamp") == "$key" ]]; then
    return
  fi
  clang-tidy-22 -p "$build" --quiet --checks="$(tidy_except "$file")" "$file" 2>&1 || return
  [[ -z $key ]] || printf '%s\n' "$key" >"$stamp"
}

check_tidy() {
  configure sanitize || return
  local log=$logs/tidy.log
  mkdir -p "$root/build/tidy"
  export -f tidy_one tidy_key tidy_except
  # shellcheck disable=SC2016 # expanded by the inner shell
  if ! sources_to_tidy "$@" |
    xargs -0 -r -n 1 -P "$(nproc)" bash -c 'tidy_one "$1"' - >"$log"; then
    grep -E '(warning|error): ' "$log" | sort -u | sed "s|^$root/||" >&2
    say "clang-tidy's whole log is in $log"
    return 1
  fi
}

# The linker sees each class of each source of both programs: one name, one definition.
check_odr() { build odr; }

# Sources beside what has changed since the last commit, or in it where nothing has; 0-terminated.
sources_beside_changes() {
  (
    cd "$root" || return
    local changed folder
    changed=$(git diff --name-only HEAD && git ls-files --others --exclude-standard)
    [[ -n $changed ]] || changed=$(git diff --name-only HEAD~1)
    grep -E '[.][ch]pp$' <<<"$changed" | sed -E 's|/[^/]*$||; s|^tests/||' | sort -u |
      while IFS= read -r folder; do
        find "$root/$folder" "$root/tests/$folder" -maxdepth 1 -name '*.cpp' -print0 2>/dev/null
      done
  )
}

# The command of a source, without what it would write.
syntax_command() {
  grep -F -B 1 "\"file\": \"$1\"" "$root/build/sanitize/compile_commands.json" | sed -nE '/"command": /{
    s/^ *"command": "(.*)",$/\1/; s/\\(.)/\1/g; s/ccache //; s/ -o [^ ]+ -c / -fsyntax-only /p }'
}

# What only clang++ sees, as names that hide others, in the rooms that have changed.
check_syntax() {
  local -a sources
  configure sanitize || return
  mapfile -d '' sources < <(sources_beside_changes)
  ((${#sources[@]})) || return 0
  say 'checking with clang++ what has changed'
  sources_to_tidy "${sources[@]}" | sort -zu | while IFS= read -r -d '' source; do
    syntax_command "$source" | tr '\n' '\0'
  done | xargs -0 -r -n 1 -P "$(nproc)" bash -c
}

# Seconds, all of it; prints which have failed.
check_texts() {
  local check
  for check in format shell rules rooms; do
    "check_$check" >&2 || printf ' %s' "$check"
  done
}

# check_ended FAILED
check_ended() {
  [[ -n $1 ]] || return 0
  say "check failed:$1"
  return 1
}

check_quickly() {
  say 'checking formatting, scripts, house rules'
  check_ended "$(check_texts)"
}

run_check() {
  run_setup
  mkdir -p "$logs"
  local failed
  say 'checking formatting, scripts, house rules'
  failed=$(took texts check_texts)
  say 'checking with clang-tidy'
  took clang-tidy check_tidy "$@" || failed+=' clang-tidy'
  (($#)) || check_odr || failed+=' one-definition'
  check_ended "$failed"
}
