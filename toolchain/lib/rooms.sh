# shellcheck shell=bash disable=SC2154 # root is set by toolchain/dev
# Which room may include which, and its namespace. Sourced by toolchain/dev.

# The floors of the house, the highest first: the lines between the marks in README.md.
floors() { sed -n '/^<!-- rooms/,/^<!-- end of rooms/{ /^    /p }' "$root/README.md"; }

# Lines "file:line: includes what": includes that go to a room on the same floor or a higher one. A
# room is the longest path in the picture that the file's path begins with.
includes_upward() {
  local -a sources
  mapfile -d '' sources < <(our_files '*.cpp' '*.hpp' ':!tests')
  (cd "$root" && awk '
    function room(path) {
      while (sub("/[^/]*$", "", path)) {
        if (path in floor) return path
      }
      return ""
    }
    FILENAME == "-" {
      for (i = 1; i <= NF; ++i) floor[$i] = NR
      next
    }
    FNR == 1 {
      here = room(FILENAME)
      folders = split(FILENAME, part, "/") - 1
      if (here == "" || folders > 1 && !(part[1] "/" part[2] in floor)) {
        printf "%s: is in no room of the picture in README.md\n", FILENAME
      }
    }
    /^#include "/ && here != "" {
      split($0, quoted, "\"")
      there = room(quoted[2])
      if (there == "") {
        if (quoted[2] ~ "/") printf "%s:%d: %s is in no room\n", FILENAME, FNR, quoted[2]
      } else if (there != here && floor[there] <= floor[here]) {
        printf "%s:%d: includes %s, which is not below it\n", FILENAME, FNR, quoted[2]
      }
    }' - "${sources[@]}") < <(floors)
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
  local found
  [[ $(floors | wc -w) -ge 20 ]] || {
    say 'README.md has no picture of the rooms'
    return 1
  }
  found=$(includes_upward) || return
  [[ -z $found ]] || {
    printf '%s\n' "$found" >&2
    say '^ includes go downwards only: README.md, "Folders"'
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
