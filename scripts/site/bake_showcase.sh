#!/usr/bin/env bash
# Bakes the showcase for the live demo: FOLDER/courtyard-baked.glb, small enough to open from the network.
#
#   scripts/site/bake_showcase.sh HALFLIGHT FOLDER [QUALITY]
#
# A page of half the width, without directions, has 2.7 MB instead of 6.8 MB. At 960 x 540 both look the same.
set -euo pipefail
halflight=$1 folder=$2 quality=${3:-medium}
assets=$(dirname "${BASH_SOURCE[0]}")/../../assets
mkdir -p "$folder"
"$halflight" bake "$assets/courtyard.glb" -o "$folder/courtyard.glb" --quality "$quality" --lightmap-size 1024 \
  --directional off --cache "$folder/cache"
"$halflight" optimize "$folder/courtyard.glb" "$folder/courtyard-baked.glb"
