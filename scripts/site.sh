#!/usr/bin/env bash
# Makes out/site, a static folder: the documents, the API reference, the viewer with the showcase, the conformance pack
# (docs/site.md). Run from anywhere; safe to run again.
#
#   scripts/site.sh [--program HALFLIGHT] [--baked FILE.glb] [--quality QUALITY] [--browser] [--out DIR]
#
# --program takes a program that is there instead of building one
# --baked   takes a baked showcase that is there instead of baking one
# --quality of that bake (medium)
# --browser opens pages in headless Chromium, fails if a request leaves, and writes pictures into out/site_pictures
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

halflight="" baked="" quality=medium browser=0 out=out/site
while [ $# -gt 0 ]; do
  case "$1" in
    --program) halflight=$(realpath "$2"); shift 2 ;;
    --baked) baked=$(realpath "$2"); shift 2 ;;
    --quality) quality=$2; shift 2 ;;
    --browser) browser=1; shift ;;
    --out) out=$2; shift 2 ;;
    *) sed -n '/^#   scripts/s/^# *//p' scripts/site.sh >&2; exit 2 ;;
  esac
done
step() { printf '\n== %s (%d s since the start)\n' "$1" "$SECONDS"; }

missing=()
command -v mkdocs >/dev/null || missing+=(mkdocs)
[ -d /usr/share/mkdocs/themes/material ] || python3 -c 'import material' 2>/dev/null || missing+=(mkdocs-material)
command -v doxygen >/dev/null || missing+=(doxygen)
command -v npm >/dev/null || missing+=(nodejs npm)
if [ "${#missing[@]}" -gt 0 ]; then
  echo "site.sh: not found: apt-get install --no-install-recommends ${missing[*]}" >&2
  exit 1
fi

work=out/site_work
mkdir -p "$work"
if [ -z "$baked" ]; then
  if [ -z "$halflight" ]; then
    step "build"
    scripts/install-packages.sh --build
    cmake --preset release --log-level=WARNING
    cmake --build --preset release --target halflight
    halflight=build/release/apps/halflight/halflight
  fi
  step "bake the showcase"
  baked=$work/courtyard-baked.glb
  scripts/site/bake_showcase.sh "$halflight" "$work" "$quality"
fi

step "pages"
rm -rf "$work/pages" "$out"
python3 scripts/site/stage_pages.py . "$work/pages"
cp scripts/site/mkdocs.yml "$work/mkdocs.yml"
PYTHONPATH=scripts/site mkdocs --quiet build --config-file "$work/mkdocs.yml" --site-dir "$(realpath -m "$out")"
rm -f "$out"/{404.html,sitemap.xml,sitemap.xml.gz} # they need to know the site's address

step "API reference"
(cat scripts/site/Doxyfile && echo "OUTPUT_DIRECTORY = $out") | doxygen -
# Where all nested classes are private, Doxygen 1.9.4 links to a section that it leaves out.
grep -l '#nested-classes' "$out"/api/*.html | xargs grep -L 'name="nested-classes"' |
  xargs -r sed -i '/<a href="#nested-classes">/d'

step "live demo"
if [ ! -e web/node_modules/esbuild ]; then npm ci --prefix web --no-audit --no-fund --loglevel=error; fi
node web/scripts/build_viewer.mjs "$out/viewer" "$baked"

step "conformance pack"
python3 -c 'import shutil, sys; shutil.make_archive(sys.argv[1], "zip", "assets", "conformance")' "$out/conformance"

step "links"
python3 scripts/site/check_site.py "$out"
if [ "$browser" -eq 1 ]; then
  step "pictures"
  node scripts/site/open_pages.mjs "$out" out/site_pictures
fi
printf '\nDone in %d s. The site: %s\n' "$SECONDS" "$(realpath "$out")"
