#!/usr/bin/env bash
# Checks bakes on this machine's GPU: rays and light against the processor's, repeated bytes, memory, seconds. Needs a
# build of the tests (scripts/test.sh, or cmake --preset dev && ninja -C build/dev).
#
#   scripts/gpu_check.sh [NAME [PART…]]
#
# NAME: part of the device's name; without it, or where it is empty, the best GPU. PART: tests, scenes, bytes, memory,
# seconds; all of them without it. HALFLIGHT_TEST_SCENES names the files of "scenes", between colons. Prints device and
# driver first, and "all right" at the end.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

name=${1:-}
parts=("${@:2}")
if [ "${#parts[@]}" -eq 0 ]; then parts=(tests scenes bytes memory seconds); fi
device=gpu${name:+:$name}
program=build/dev/apps/halflight/halflight
tests=build/dev/tests/bake_gpu/test_bake_gpu
bench=build/bench/bench/bench_gpu_rays
for file in "$program" "$tests"; do
  if [ ! -x "$file" ]; then echo "gpu_check: $file is missing: run scripts/test.sh first" >&2; exit 1; fi
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# A driver for the CPU takes minutes for what a GPU does in seconds.
is_slow() { [[ "$name" =~ (lava|llvm)pipe ]]; }

# Tests of a filter, a process for each four cores: their bakes are too small for all cores.
run_tests() {
  local count=$((($(nproc) + 3) / 4)) failed=0 i
  local shards=()
  for ((i = 0; i < count; ++i)); do
    GTEST_TOTAL_SHARDS=$count GTEST_SHARD_INDEX=$i HALFLIGHT_TEST_DEVICE=$name \
      "$tests" --gtest_brief=1 --gtest_filter="$1" >"$folder/shard$i" 2>&1 &
    shards+=($!)
  done
  for ((i = 0; i < count; ++i)); do
    wait "${shards[i]}" || failed=1
    cat "$folder/shard$i"
  done
  return "$failed"
}

check_tests() {
  echo "== rays and light against the processor's"
  run_tests '-*WholeBakes*'
}

check_scenes() {
  echo "== whole bakes against the processor's, eight seeds on both, paired: blocks of 8 x 8 texels, masks, probes"
  if [ -z "${HALFLIGHT_TEST_SCENES:-}" ] && ! is_slow; then
    local scene scenes=
    for scene in assets/*.glb assets/tests/*.glb ../shared/scenes/*.glb; do
      # No reader takes a file of version 1.
      if [ -f "$scene" ] && [[ "$scene" != *format_v1* ]]; then scenes+=${scenes:+:}$scene; fi
    done
    export HALFLIGHT_TEST_SCENES=$scenes
  fi
  run_tests '*WholeBakes*'
}

check_bytes() {
  echo "== three bakes in three processes: the same bytes"
  local scene integrator run
  for scene in assets/courtyard.glb assets/tests/two_rooms.glb; do
    for integrator in cache path; do
      for run in 1 2 3; do
        "$program" bake "$scene" -o "$folder/$run.glb" --quality preview --lightmap-size 512 \
          --integrator "$integrator" --device "$device" --quiet
      done
      cmp "$folder/1.glb" "$folder/2.glb"
      cmp "$folder/1.glb" "$folder/3.glb"
      echo "$scene, $integrator: equal"
    done
  done
}

# bake_in MEBIBYTES OPTION…: bakes within so much of the device's memory; fails if a part of it went to the processor.
bake_in() {
  "$program" bake "${@:2}" -o "$folder/x.glb" --device "$device" --device-memory "$1" --quiet \
    --report "$folder/report.json"
  python3 - "$folder/report.json" "$1" <<'PYTHON'
import json
import sys

report = json.load(open(sys.argv[1]))
stages = ", ".join(f"{s['name']} {s['seconds']:.1f}" for s in report["stages"] if s["seconds"] >= 0.5)
print(f"{report['triangles']} triangles, {report['lightmap']['pages']} pages of {report['lightmap']['size']}: "
      f"{report['peakDeviceBytes'] / 1e6:.0f} MB of the device's memory, {report['seconds']:.1f} s ({stages})")
if not report["integrator"].startswith("gpu"):
    sys.exit(f"gpu_check: {sys.argv[2]} MiB were too few: {report['integrator']}, {report['warnings']}")
if any("processor" in warning for warning in report["warnings"]):
    sys.exit(f"gpu_check: {report['warnings']}")
PYTHON
}

check_memory() {
  local sponza=../shared/scenes/sponza_crytek.glb side=1600 size=4096 samples=32
  if is_slow; then side=100 size=128 samples=4; fi
  echo "== a height field of $((2 * side * side)) triangles, with 8192 MiB"
  python3 scripts/height_field.py "$folder/field.glb" "$side"
  bake_in 8192 "$folder/field.glb" --quality ultra --samples "$samples" --lightmap-size "$size"
  if [ ! -f "$sponza" ] || is_slow; then return; fi
  echo "== Sponza with 1024 MiB"
  bake_in 1024 "$sponza" --quality preview --lightmap-size 2048
}

check_seconds() {
  echo "== seconds of the lightmap, processor and GPU"
  local integrator on
  for integrator in cache path; do
    for on in cpu "$device"; do
      "$program" bake assets/courtyard.glb -o "$folder/x.glb" --quality preview --integrator "$integrator" \
        --device "$on" --quiet --report "$folder/report.json"
      python3 - "$folder/report.json" <<'PYTHON'
import json
import sys

report = json.load(open(sys.argv[1]))
seconds = {stage["name"]: stage["seconds"] for stage in report["stages"]}
print(f"{report['integrator']}: lightmap {seconds['lightmap']:.2f} of {report['seconds']:.2f} s")
PYTHON
    done
  done
  if [ -x "$bench" ] && ! is_slow; then "$bench" --scene assets/courtyard.glb ${name:+--device "$name"}; fi
}

"$program" --version | tail -n 2
for part in "${parts[@]}"; do
  case "$part" in
    tests | scenes | bytes | memory | seconds) "check_$part" ;;
    *) echo "gpu_check: there is no part $part: tests, scenes, bytes, memory, seconds" >&2; exit 2 ;;
  esac
done
echo "all right"
