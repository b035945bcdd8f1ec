#!/usr/bin/env bash
# Bakes the showcase and draws it in all five lighting modes: out/modes.png. Run as root or with sudo available, from
# anywhere; needs no display and no GPU; safe to run again.
#
#   scripts/demo.sh [--size WxH] [--no-install] [--program HALFLIGHT] [--scene FILE --camera NAME] [--out DIR]
#
# --program takes a program that is there instead of installing and building; --scene and --camera another scene than the showcase.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

size=960x540
install=1
halflight="" scene=assets/courtyard.glb camera=showcase out=out
while [ $# -gt 0 ]; do
  case "$1" in
    --size) size="${2:?--size needs a value such as 960x540}"; shift 2 ;;
    --no-install) install=0; shift ;;
    --program) halflight=$(realpath "$2"); shift 2 ;;
    --scene) scene=$2; shift 2 ;;
    --camera) camera=$2; shift 2 ;;
    --out) out=$2; shift 2 ;;
    *) sed -n '/^#   scripts/s/^# *//p' scripts/demo.sh >&2; exit 2 ;;
  esac
done
step() { printf '\n== %s (%d s since the start)\n' "$1" "$SECONDS"; }

if [ -z "$halflight" ]; then
  if [ "$install" -eq 1 ]; then
    step "packages"
    scripts/install-packages.sh --demo
  fi
  step "build"
  cmake --preset release --log-level=WARNING
  cmake --build --preset release --target halflight --parallel "$(nproc)" # as in test.sh
  halflight=build/release/apps/halflight/halflight
fi

mkdir -p "$out"
for mode in shadowmask subtractive; do
  step "bake for $mode"
  "$halflight" bake "$scene" -o "$out/$mode.glb" --mode "$mode" --quality preview
done

# One exposure for all pictures, chosen by the first. The shadow distance is short, so that within this small scene both
# sides of it are seen: beyond it only baked shadows are left.
shadows=(--shadow-distance 12 --shadow-fade-range 3)
exposure=auto
panels=()
render() { # name, label, options...
  local name="$1" label="$2"
  shift 2
  "$halflight" render "$@" -o "$out/$name.png" --size "$size" --camera "$camera" \
    --exposure="$exposure" --json >"$out/$name.json"
  if [ "$exposure" = auto ]; then
    exposure=$(python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["exposure"])' "$out/$name.json")
  fi
  panels+=(-label "$label" "$out/$name.png")
}
step "render"
render shadowmask "shadowmask" "$out/shadowmask.glb" --mode shadowmask "${shadows[@]}"
render distance-shadowmask "distance shadowmask" "$out/shadowmask.glb" --mode distance-shadowmask "${shadows[@]}"
render subtractive "subtractive" "$out/subtractive.glb" --mode subtractive "${shadows[@]}"
render baked-indirect "baked indirect" "$out/shadowmask.glb" --mode baked-indirect "${shadows[@]}"
render realtime "realtime" "$out/shadowmask.glb" --mode realtime "${shadows[@]}"
render reference "path traced, for comparison" "$out/shadowmask.glb" --reference 24

step "sheet"
montage -font /usr/share/fonts/truetype/dejavu/DejaVuSans.ttf -pointsize 24 -fill white -background '#202024' \
  "${panels[@]}" -tile 3x2 -geometry '+10+8' "$out/modes.png"

printf '\nDone in %d s. One exposure (EV %s) for all; pictures in %s:\n' "$SECONDS" "$exposure" "$(realpath "$out")"
printf '  %s\n' "$out"/{modes,shadowmask,distance-shadowmask,subtractive,baked-indirect,realtime,reference}.png
