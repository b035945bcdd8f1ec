#!/usr/bin/env bash
# small_build_test.sh SOURCE HALFLIGHT: the program without renderer and OpenEXR, as its CMake options leave them out. It
# bakes HALFLIGHT's bytes, and says of what it lacks that it is not there.
set -euo pipefail
source="$1" halflight="$2"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake -S "$source" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE="-O2" \
  -DHALFLIGHT_GPU=OFF -DHALFLIGHT_OPENEXR=OFF -DHALFLIGHT_TESTS=OFF --log-level=WARNING >/dev/null
cmake --build "$work/build" --target halflight -- --quiet
program="$work/build/apps/halflight/halflight"
! ldd "$program" | grep -i -e openexr -e vulkan || { echo "it is linked with what it does without" >&2; exit 1; }

cd "$work"
cp "$source/assets/tests/closed_room.glb" scene.glb
options="--quality preview --quiet"
"$program" bake scene.glb -o small.glb $options
"$halflight" bake scene.glb -o whole.glb $options
cmp small.glb whole.glb
says() { # SENTENCE COMMAND…: fails with a sentence, and leaves no file
  local code=0
  "${@:2}" >said 2>&1 || code=$?
  [ $code -ne 0 ] && grep -q "$1" said || { echo "${*:2} says with exit code $code:" >&2; cat said >&2; exit 1; }
  [ ! -e x.glb ] && [ ! -e x.png ] || { echo "${*:2} left a file" >&2; exit 1; }
}
cp "$source/assets/conformance/avenue_main_shadowmask.exr" sky.exr
printf '[sky]\nimage = "sky.exr"\n' >sky.toml
says "OpenEXR" "$program" bake scene.glb -o x.glb --settings sky.toml $options
says "render" "$program" render whole.glb -o x.png
"$program" --version | grep -q "no renderer"
echo "without renderer and OpenEXR: the bytes of the whole program, and sentences"
