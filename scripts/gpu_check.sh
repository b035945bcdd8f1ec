#!/usr/bin/env bash
# Checks bakes on this machine's GPU: rays and light against the processor's, repeated bytes, rates. Needs a build of the
# tests (scripts/test.sh, or cmake --preset dev && ninja -C build/dev).
#
#   scripts/gpu_check.sh [NAME]
#
# NAME: part of the device's name; without it the best GPU. Prints device and driver first, and "all right" at the end.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

name=${1:-}
program=build/dev/apps/halflight/halflight
tests=build/dev/tests/bake_gpu/test_bake_gpu
for file in "$program" "$tests"; do
  if [ ! -x "$file" ]; then echo "gpu_check: $file is missing: run scripts/test.sh first" >&2; exit 1; fi
done
device=gpu${name:+:$name}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

"$program" --version | tail -n 2
echo "== rays and light against the processor's"
export HALFLIGHT_TEST_DEVICE=${name:-}
"$tests" --gtest_brief=1 --gtest_filter=-*WholeBakes*
echo "== whole bakes against the processor's, eight seeds on both, paired: blocks of 8 x 8 texels, masks, probes"
if [[ ! "$name" =~ (lava|llvm)pipe ]]; then # which takes minutes: two small scenes
  scenes=
  for scene in assets/*.glb assets/tests/*.glb ../shared/scenes/*.glb; do
    # No reader takes a file of version 1.
    if [ -f "$scene" ] && [[ "$scene" != *format_v1* ]]; then scenes+=${scenes:+:}$scene; fi
  done
  export HALFLIGHT_TEST_SCENES=$scenes
fi
"$tests" --gtest_brief=1 --gtest_filter=*WholeBakes*
echo "== three bakes in three processes: the same bytes"
for scene in assets/courtyard.glb assets/tests/two_rooms.glb; do
  for integrator in cache path; do
    for run in 1 2 3; do
      "$program" bake "$scene" -o "$folder/$run.glb" --quality preview --lightmap-size 512 --integrator $integrator \
        --device "$device" --quiet
    done
    cmp "$folder/1.glb" "$folder/2.glb"
    cmp "$folder/1.glb" "$folder/3.glb"
    echo "$scene, $integrator: equal"
  done
done
echo "== seconds of the lightmap, processor and GPU"
for integrator in cache path; do
  for on in cpu "$device"; do
    "$program" bake assets/courtyard.glb -o "$folder/x.glb" --quality preview --integrator $integrator --device "$on" \
      --quiet --report "$folder/report.json"
    python3 - "$folder/report.json" <<'PYTHON'
import json
import sys

report = json.load(open(sys.argv[1]))
seconds = {stage["name"]: stage["seconds"] for stage in report["stages"]}
print(f"{report['integrator']}: lightmap {seconds['lightmap']:.2f} of {report['seconds']:.2f} s")
PYTHON
  done
done
bench=build/bench/bench/bench_gpu_rays
# Millions of rays take a driver for the CPU minutes.
if [ -x "$bench" ] && [[ ! "$name" =~ (lava|llvm)pipe ]]; then "$bench" --scene assets/courtyard.glb ${name:+--device "$name"}; fi
echo "all right"
