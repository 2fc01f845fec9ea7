# shellcheck shell=bash disable=SC2154 # root is set by toolchain/dev
# Which room may use which, and its namespace. Sourced by toolchain/dev.

# The floors of a house, the highest first: the lines between the marks in a README.
floors() { sed -n '/^<!-- rooms/,/^<!-- end of rooms/{ /^    /p }' "$root/$1"; }

# uses_upward README FOLDER SOURCES...: lines "file:line: uses what", of includes and relative imports
# that go to a room on the same floor or a higher one. Rooms are paths in FOLDER, which ends in a slash
# unless it is the top; a file's is the longest that its path begins with.
uses_upward() {
  local readme=$1 folder=$2
  local -a sources
  mapfile -d '' sources < <(our_files "${@:3}")
  (cd "$root" && awk -v readme="$readme" -v folder="$folder" '
    function room(path) {
      while (sub("/[^/]*$", "", path)) {
        if (path in floor) return path
      }
      return ""
    }
    # Where an include or a relative import goes, or "".
    function wanted(line, quoted, path) {
      if (line ~ /^#include "/) {
        split(line, quoted, "\"")
        return quoted[2] ~ "/" ? quoted[2] : ""
      }
      if (line !~ /(from|import) *[(]?\047[.]/) return ""
      split(line, quoted, "\047")
      path = file
      sub("[^/]*$", quoted[2], path)
      gsub("/[.]/", "/", path)
      while (sub("[^/]+/[.][.]/", "", path)) continue
      return path
    }
    FILENAME == "-" {
      for (i = 1; i <= NF; ++i) floor[$i] = NR
      next
    }
    FNR == 1 {
      file = substr(FILENAME, length(folder) + 1)
      here = room(file)
      folders = split(file, part, "/") - 1
      if (here == "" || folders > 1 && !(part[1] "/" part[2] in floor)) {
        printf "%s: is in no room of the picture in %s\n", FILENAME, readme
      }
    }
    here != "" && (used = wanted($0)) != "" {
      there = room(used "/")
      if (there == "") {
        printf "%s:%d: %s is in no room\n", FILENAME, FNR, used
      } else if (there != here && floor[there] <= floor[here]) {
        printf "%s:%d: uses %s, which is not below it\n", FILENAME, FNR, used
      }
    }' - "${sources[@]}") < <(floors "$readme")
}

# Lines "file: what": sources that open no namespace of their room. The core's is smaservo; the
# folders of hal share one, and so do the papers' models; all others are called like their folder.
namespaces_astray() {
  local -a sources
  mapfile -d '' sources < <(our_files '*.cpp' '*.hpp' ':!tests')
  (cd "$root" && awk '
    function wanted(path, part, n) {
      n = split(path, part, "/")
      if (path ~ "^hal/cortex-m/") return "smaservo::(cortex_m|semihosting)"
      if (path ~ "^hal/") return "smaservo::hal"
      if (path ~ "^(model|observer)/papers/") return "smaservo::papers"
      if (path ~ "^model/files/") return "smaservo::files"
      if (path ~ "^firmware/(text|bench|canopen|daemon|mcu)/") return "smaservo::" part[2]
      if (path ~ "^host-sim/papers/") return "smaservo::" part[3]
      if (path ~ "^host-sim/[^/]*/") return "smaservo::" part[2]
      return "smaservo"
    }
    function report() {
      if (opens && !right) printf "%s: namespace %s is wanted\n", file, want
    }
    FNR == 1 { report(); file = FILENAME; want = wanted(file); opens = right = 0 }
    /^namespace smaservo/ {
      opens = 1
      if ($2 ~ "^" want "(::[a-z0-9_]+)?$") right = 1
    }
    END { report() }' "${sources[@]}")
}

# Lines "folder: count": folders with more modules than a stranger takes in at one look. A header and
# its source are one module.
folders_too_full() {
  our_files '*.cpp' '*.hpp' ':!tests' | tr '\0' '\n' | sed -E 's/[.][ch]pp$//' | sort -u |
    sed 's|/[^/]*$||' | uniq -c | awk '$1 > 10 { printf "%s: %d modules\n", $2, $1 }'
}

check_rooms() {
  local found front=host-sim/page/front
  found=$(uses_upward README.md '' '*.cpp' '*.hpp' ':!tests' &&
    uses_upward "$front/README.md" "$front/src/" "$front/src/*.ts" "$front/src/*.tsx") || return
  [[ -z $found ]] || {
    printf '%s\n' "$found" >&2
    say '^ includes and imports go downwards only: CONTRIBUTING.md, "Rooms"'
    return 1
  }
  found=$(namespaces_astray) || return
  [[ -z $found ]] || {
    printf '%s\n' "$found" >&2
    say '^ each room has its namespace: CONTRIBUTING.md, "Rooms"'
    return 1
  }
  found=$(folders_too_full) || return
  [[ -z $found ]] || {
    printf '%s\n' "$found" >&2
    say '^ a folder has at most ten modules'
    return 1
  }
}
