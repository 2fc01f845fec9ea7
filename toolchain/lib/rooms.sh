# shellcheck shell=bash disable=SC2154 # root is set by toolchain/dev
# Which room may include which. Sourced by toolchain/dev.

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
      if (here == "") printf "%s: is in no room of the picture in README.md\n", FILENAME
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

check_rooms() {
  local found
  [[ $(floors | wc -w) -ge 20 ]] || {
    say 'README.md has no picture of the rooms'
    return 1
  }
  found=$(includes_upward) || return
  [[ -z $found ]] || {
    printf '%s\n' "$found" >&2
    say '^ includes go downwards only: README.md, "The house"'
    return 1
  }
}
