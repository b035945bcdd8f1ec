#!/usr/bin/env bash
# scripts/demo.sh with a small scene: demo_test.sh SOURCE HALFLIGHT. Every picture is there, and the sheet of all.
set -euo pipefail
source=$1 program=$2
command -v montage >/dev/null || { echo "skipped: ImageMagick's montage is missing: apt-get install imagemagick"; exit 77; }
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
"$source/scripts/demo.sh" --program "$program" --scene assets/tests/sphere_on_floor.glb --camera main --size 96x54 --out "$out/demo"
for name in shadowmask distance-shadowmask subtractive baked-indirect realtime reference; do
  [ "$(identify -format '%wx%h' "$out/demo/$name.png")" = 96x54 ] || { echo "$name.png is not 96x54"; exit 1; }
done
[ "$(identify -format '%w' "$out/demo/modes.png")" -gt 288 ] || { echo "modes.png does not hold three pictures side by side"; exit 1; }
