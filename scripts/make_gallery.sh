#!/usr/bin/env bash
# Draws the README's gallery: docs/images/gallery/NAME.webp. Needs ImageMagick.
#
#   scripts/make_gallery.sh HALFLIGHT [NAME…]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
halflight=${1:?usage: scripts/make_gallery.sh HALFLIGHT [NAME…]}
shift
work=out/gallery pictures=docs/images/gallery
mkdir -p "$work" "$pictures"

draw() { # name, file, camera, bake options...
  local name=$1 file=$2 camera=$3
  shift 3
  "$halflight" bake "assets/$file" -o "$work/$name.glb" --cache "$work/$name.cache" "$@"
  "$halflight" render "$work/$name.glb" -o "$work/$name.png" --camera "$camera" --size 640x360
  convert "$work/$name.png" -quality 85 "$pictures/$name.webp"
}
names=("$@")
if [ "$#" -eq 0 ]; then names=(courtyard area_lights four_lights probe_hall avenue tiles); fi
for name in "${names[@]}"; do
  case "$name" in
    courtyard) draw "$name" courtyard.glb room ;;
    avenue) draw "$name" tests/avenue.glb high --quality high ;;
    tiles) draw "$name" quality/tiles.glb main --quality high ;;
    *) draw "$name" "tests/$name.glb" main --quality high ;;
  esac
done
