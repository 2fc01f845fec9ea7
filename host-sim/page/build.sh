#!/bin/bash
# build.sh FRONT FOLDER [NPM NODE]: npm's build of FRONT, as page.html and report.js in FOLDER.
# Several may run at once: one builds, and the others find what it has built. Without the two tools,
# or where npm cannot fetch its packages, both files are missing, one line says why, and
# FOLDER/failed says that another try may succeed. "off" instead of the tools: it is not wanted.
set -euo pipefail

front=$1 folder=$2 npm=${3-} node=${4-}

mkdir -p "$folder"
exec 9>"$folder/lock"
flock 9

without() {
  rm -f "$folder/page.html" "$folder/report.js" "$folder/built"
  echo "pages of host-sim: $1: no live page, and reports are pictures"
  exit 0
}

rm -f "$folder/failed"
[[ $npm != off ]] || without "SMASERVO_PAGE is off"
[[ -x $npm && -x $node ]] || without "node or npm is missing"

# Nothing to do where the same sources were built by the same node.
wanted=$({ "$node" --version; cd "$front" &&
  find . -type f -not -path './node_modules/*' -not -path './dist/*' -print0 | sort -z |
  xargs -0 sha256sum; } | sha256sum)
if [[ -f $folder/built && $(<"$folder/built") == "$wanted" ]]; then exit 0; fi

rm -f "$folder/built"
mkdir -p "$folder/front"
# All but the packages, which are fetched anew only when their list has changed.
find "$folder/front" -mindepth 1 -maxdepth 1 -not -name node_modules -exec rm -r {} +
(cd "$front" && tar -cf - --exclude=./node_modules --exclude=./dist .) | tar -xf - -C "$folder/front"
cd "$folder/front"
log=$folder/log
export PATH="${node%/*}:$PATH"
if ! cmp -s package-lock.json node_modules/.package-lock-built.json; then
  if ! "$npm" ci --no-audit --no-fund --fetch-retries=3 --fetch-timeout=60000 >"$log" 2>&1; then
    touch "$folder/failed"
    without "npm could not fetch its packages (see $log)"
  fi
  cp package-lock.json node_modules/.package-lock-built.json
fi
# What does not compile is a mistake, not a missing tool.
if ! "$npm" run build >"$log" 2>&1; then
  cat "$log" >&2
  exit 1
fi
for file in page.html report.js; do
  if [[ -f dist/$file ]]; then cp "dist/$file" "$folder/$file"; else rm -f "$folder/$file"; fi
done
echo "$wanted" >"$folder/built"
