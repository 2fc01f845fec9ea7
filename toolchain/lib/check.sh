# shellcheck shell=bash disable=SC2154 # root, here and logs are set by toolchain/dev
# Formatting, static analysis and house rules. Sourced by toolchain/dev.

# Files of ours, tracked or new, that match the patterns; 0-terminated.
our_files() {
  (cd "$root" && git ls-files -z --cached --others --exclude-standard -- "$@" |
    while IFS= read -r -d '' file; do
      [[ ! -f $file ]] || printf '%s\0' "$file"
    done)
}

# biome ARGUMENTS...: over all TypeScript and JavaScript of ours; it comes with what the page is built with.
biome() {
  local front=host-sim/page/front page=$root/build/page
  cmp -s "$root/$front/package-lock.json" "$page/front/node_modules/.package-lock-built.json" ||
    page_is_built "$page" || {
    say "Biome is missing, for TypeScript and JavaScript: npm has to fetch the packages of $front"
    return 1
  }
  our_files '*.js' '*.ts' '*.tsx' | sed -z 's|^|../../../|' |
    (cd "$root/$front" && xargs -0 -r "$page/front/node_modules/.bin/biome" "$@")
}

run_format() {
  run_setup
  our_files '*.cpp' '*.hpp' | (cd "$root" && xargs -0 -r clang-format-19 -i)
  biome format --write
}

check_format() {
  our_files '*.cpp' '*.hpp' | (cd "$root" && xargs -0 -r clang-format-19 --dry-run -Werror)
}

check_scripts() { biome ci --colors=off --error-on-warnings; }

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
  # Lines of a notebook are texts of JSON, and its pictures lines of base64, which may have any word between slashes.
  rule '[[:blank:]](\\n)?",?$' 'blanks at the end of a line' '*.ipynb'
  rule "[[:blank:](\"'=](/(home|root|work|Users|mnt|tmp)/|~/)[[:alnum:]]" 'a path of one machine' '*.ipynb'
  rule '\b(TODO|FIXME|XXX)\b' 'an open end' '*.cpp' '*.hpp'
  # What comes from outside may command a terminal; model/files/message.hpp escapes it.
  rule '(fmt::print|std::(fputs|puts|printf|fprintf|fwrite|perror|cerr|cout|clog))\b' \
    'printed past model/files/message.hpp' 'model/*.cpp' 'model/*.hpp' 'observer/*.hpp' \
    'hal/linux/*.?pp' 'hal/replay/*.?pp' 'hal/sim/*.?pp' 'firmware/*.?pp' 'host-sim/*.?pp' \
    ':!firmware/mcu' ':!host-sim/examples' ':!model/files/message.cpp' ':!model/files/output_file.cpp'
  rule '^ *# *define +[[:alnum:]_]+ +\(?[-+]?[0-9]' 'a number as a macro' '*.cpp' '*.hpp'
  rule '\btypedef\b' 'a typedef; using says the same' '*.cpp' '*.hpp'
  if ! our_files '*.md' '*.ipynb' | xargs -0 -r "$root/toolchain/lib/links.py"; then
    say '^ a link that leads nowhere: no such file of the project, or no such heading in it'
    broken=1
  fi
  return "$broken"
}

# Seconds, all of it; says which have failed.
check_all_texts() {
  local check failed=''
  for check in format scripts shell rules rooms figures; do
    "check_$check" >&2 || failed+=" $check"
  done
  [[ -z $failed ]] || {
    say "check failed:$failed"
    return 1
  }
}

# check [FILE.cpp ...]
run_check() {
  local failed=''
  run_setup
  say 'checking formatting, scripts, house rules'
  check_all_texts || failed=1
  say 'checking with clang-tidy'
  here=$here step tidy "$root/toolchain/lib/tidy.py" "$@" || failed=1
  (($#)) || build odr || failed=1
  [[ -z $failed ]]
}
