#!/usr/bin/env bash
# npm.sh LOCKED FOLDER COMMAND...: runs a command with the npm packages that LOCKED/package-lock.json
# lists, installed into FOLDER where they are not there yet. 77: node or npm is missing.
set -euo pipefail

locked=$1
folder=$2
shift 2

if ! command -v node >/dev/null || ! command -v npm >/dev/null; then
  echo 'node or npm is missing'
  exit 77
fi
mkdir -p "$folder"
(
  # Tests that begin at the same time share the folder.
  flock 9
  if ! cmp -s "$locked/package-lock.json" "$folder/installed"; then
    cp "$locked/package.json" "$locked/package-lock.json" "$folder/"
    (cd "$folder" && npm ci --no-audit --no-fund --ignore-scripts)
    cp "$locked/package-lock.json" "$folder/installed"
  fi
) 9>"$folder/lock"
NODE_PATH=$folder/node_modules exec "$@"
