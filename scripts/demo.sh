#!/usr/bin/env bash
# Bakes the showcase and draws it in all five lighting modes: out/modes.png. Run as root or with sudo available, from
# anywhere; needs no display and no GPU; safe to run again.
#
#   scripts/demo.sh [--size WxH] [--no-install]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

size=960x540
install=1
while [ $# -gt 0 ]; do
  case "$1" in
    --size) size="${2:?--size needs a value such as 960x540}"; shift 2 ;;
    --no-install) install=0; shift ;;
    *) echo "usage: scripts/demo.sh [--size WxH] [--no-install]" >&2; exit 2 ;;
  esac
done
step() { printf '\n== %s (%d s since the start)\n' "$1" "$SECONDS"; }

if [ "$install" -eq 1 ]; then
  step "packages"
  scripts/install-packages.sh
fi

step "build"
cmake --preset release --log-level=WARNING
cmake --build --preset release --target halflight
halflight=build/release/apps/halflight/halflight

scene=assets/courtyard.glb
camera=showcase
mkdir -p out
for mode in shadowmask subtractive; do
  step "bake for $mode"
  "$halflight" bake "$scene" -o "out/courtyard-$mode.glb" --mode "$mode" --quality preview
done

# One exposure for all pictures, chosen by the first. The shadow distance is short, so that within this small scene both
# sides of it are seen: beyond it only baked shadows are left.
shadows=(--shadow-distance 12 --shadow-fade-range 3)
exposure=auto
panels=()
render() { # name, label, options...
  local name="$1" label="$2"
  shift 2
  "$halflight" render "$@" -o "out/$name.png" --size "$size" --camera "$camera" "${shadows[@]}" \
    --exposure="$exposure" --json >"out/$name.json"
  if [ "$exposure" = auto ]; then
    exposure=$(python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["exposure"])' "out/$name.json")
  fi
  panels+=(-label "$label" "out/$name.png")
}
step "render"
render shadowmask "shadowmask" out/courtyard-shadowmask.glb --mode shadowmask
render distance-shadowmask "distance shadowmask" out/courtyard-shadowmask.glb --mode distance-shadowmask
render subtractive "subtractive" out/courtyard-subtractive.glb --mode subtractive
render baked-indirect "baked indirect" out/courtyard-shadowmask.glb --mode baked-indirect
render realtime "realtime" out/courtyard-shadowmask.glb --mode realtime
render reference "path traced, for comparison" out/courtyard-shadowmask.glb --reference 32 --bounces 4

step "sheet"
montage -font /usr/share/fonts/truetype/dejavu/DejaVuSans.ttf -pointsize 24 -fill white -background '#202024' \
  "${panels[@]}" -tile 3x2 -geometry '+10+8' out/modes.png

printf '\nDone in %d s. One exposure (EV %s) for all; pictures in %s:\n' "$SECONDS" "$exposure" "$PWD/out"
printf '  %s\n' out/modes.png out/{shadowmask,distance-shadowmask,subtractive,baked-indirect,realtime,reference}.png
