#!/usr/bin/env bash
# Builds everything with warnings as errors and runs the tests of a commit: those that are labelled fast and device
# (tests/nightly.cmake). From anywhere, as root or with sudo available; no display and no GPU; safe to run again.
#
#   scripts/test.sh [--all | --since REVISION] [--asan] [--no-install]
#
# --all      also runs the nightly tests and, where clang has libFuzzer, fuzzes the readers for a minute
# --since    also runs the nightly tests of what changed since a git revision
# --asan     tests a build with AddressSanitizer and UndefinedBehaviorSanitizer
#
# The Khronos glTF validator and MikkTSpace come from npm, like the packages that the tests of web/ use. Without a network
# the tests that need them are skipped, as are those of shared scenes where there are none. The last line says how many
# were skipped, and why.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

preset=dev
install=1
all=0
since=
while [ "$#" -gt 0 ]; do
  case "$1" in
    --all) all=1 ;;
    --since) since=${2:?test.sh: --since needs a revision}; shift ;;
    --asan) preset=asan ;;
    --no-install) install=0 ;;
    *) echo "usage: scripts/test.sh [--all | --since REVISION] [--asan] [--no-install]" >&2; exit 2 ;;
  esac
  shift
done

# Nightly tests of changed paths: a regular expression of paths, and one of tests. What changes light is in all of them.
nightly_of=(
  '^(web|shaders|include/halflight/shading)/' '^web\.'
  '^(blender|src/scene|scripts/package)' '^blender\.'
  '^(farm/|src/bake/(farm|cache))' '^cli\.(Farm|FarmTrouble|Slurm|Parallel)$'
  '^(scripts|cmake|packages|python)/|^(src/[^/]+/)?CMakeLists' '^package\.'
  '^(src/view|apps)/' '^cli\.(View|ViewBake|InterruptAnywhere)$|^package\.python_module$'
  '^src/(base|scene)/' '^cli\.(FullDisk|Streams|Georeferenced|Chain|InterruptAnywhere)$|^Validator|RoundTrip|SharedScenes'
  '^src/(bake|bake_cpu|bake_gpu|gpu|transport|unwrap|render)/' '^cli\.(Truth|Boards|Pictures|Sheets|SharedSheets|Glass|TextureSets|Reach)$|^[A-Z]'
  '^(src|apps|include|shaders)/' '^cli\.(RenderReports|Choices|ChangingGroups|Emission|Variants|Identities|ReflectionProbes)$'
)
nightly_since() {
  local changed pattern=
  changed=$(git diff --name-only "$1")
  for ((i = 0; i < ${#nightly_of[@]}; i += 2)); do
    if grep -qE "${nightly_of[i]}" <<<"$changed"; then pattern+="${pattern:+|}${nightly_of[i + 1]}"; fi
  done
  echo "$pattern"
}
nightly=
if [ -n "$since" ]; then nightly=$(nightly_since "$since"); fi
if [ "$all" -eq 1 ]; then nightly=.; fi

if [ "$install" -eq 1 ]; then scripts/install-packages.sh --node; fi

# The format is checked first: it takes a second, and the rest most of an hour. Other versions of clang-format lay some
# lines out differently.
if command -v clang-format >/dev/null && clang-format --version | grep -q 'version 14\.'; then
  if git ls-files -z '*.cpp' '*.h' | xargs -0 clang-format --dry-run -Werror; then
    echo "clang-format: clean"
  else
    echo "test.sh: some files are not formatted: clang-format -i FILE" >&2
    exit 1
  fi
else
  echo "clang-format 14 not found: formatting not checked"
fi

node_packages=(gltf-validator mikktspace)
missing_packages=()
for package in "${node_packages[@]}"; do [ -d "build/node_modules/$package" ] || missing_packages+=("$package"); done
if [ "${#missing_packages[@]}" -gt 0 ] && command -v npm >/dev/null; then
  mkdir -p build
  timeout 120 npm install --prefix build --no-save --no-audit --no-fund --loglevel=error "${node_packages[@]}" ||
    echo "test.sh: npm gave no ${missing_packages[*]}; tests that need them will be skipped" >&2
fi
if [ ! web/node_modules/.package-lock.json -nt web/package-lock.json ] && command -v npm >/dev/null; then
  timeout 300 npm ci --prefix web --no-audit --no-fund --loglevel=error ||
    echo "test.sh: npm gave no packages for web/; tests that need them will be skipped" >&2
fi
if [ -d build/node_modules ]; then export HALFLIGHT_NODE_MODULES="$PWD/build/node_modules"; fi

cmake --preset "$preset" --log-level=WARNING
cmake --build --preset "$preset" --parallel "$(nproc)" # Ninja would start two more, which take the others' caches
log="build/$preset/ctest.log"
status=0
ctest --preset "$preset" -j2 2>&1 | tee "$log" || status=$?

if [ -n "$nightly" ]; then
  ctest --test-dir "build/$preset" --output-on-failure -j2 -L nightly -R "$nightly" 2>&1 | tee -a "$log" || status=$?
fi

# A minute of fuzzing, a quarter of it for each reader; scripts/fuzz.sh SECONDS runs longer.
if [ "$all" -eq 1 ] && [ "$preset" = dev ]; then scripts/fuzz.sh 15 || status=1; fi

grep -E 'tests passed|tests failed' "$log" || true
python3 scripts/skipped_tests.py "build/$preset/Testing/Temporary/LastTest.log" || true
exit "$status"
