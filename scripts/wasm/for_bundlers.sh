#!/usr/bin/env bash
# Changes what bundlers cannot read in Emscripten's halflight.mjs: for_bundlers.sh HALFLIGHT.MJS
#
# Vite wants a worker's options where the worker is made. Bundlers for browsers look for Node's modules, which only Node
# loads here.
set -euo pipefail
file=$1
change() { # OLD NEW, both plain text
  grep -qF -- "$1" "$file" || { echo "for_bundlers.sh: $file has no '$1': another Emscripten?" >&2; exit 1; }
  OLD=$1 NEW=$2 perl -0pi -e 's/\Q$ENV{OLD}\E/$ENV{NEW}/g' "$file"
}
change ',workerOptions)' ',{"type":"module","workerData":"em-pthread","name":"em-pthread"})'
change 'import("module")' 'import(/* @vite-ignore *//* webpackIgnore: true */"node:module")'
change "import('worker_threads')" 'import(/* @vite-ignore *//* webpackIgnore: true */"node:worker_threads")'
