#!/usr/bin/env bash
# Installs everything Halflight needs on Debian 12 or newer, or Ubuntu 24.04 or newer. Run as root or with sudo
# available; safe to run again (it asks the package manager only when something is missing).
#
#   scripts/install-packages.sh          build, test and render
#   scripts/install-packages.sh --demo   what scripts/demo.sh needs: a build without a window, a renderer, a sheet of pictures
#   scripts/install-packages.sh --build  what a build with a window, and packages of it, need
#   scripts/install-packages.sh --node   also what only tests use: Node.js and npm (Khronos glTF validator), Chromium and
#                                        Blender (Debian), mypy and notebook tools (Debian), clang with libFuzzer
#                                        (scripts/fuzz.sh); tests are skipped where they cannot be had
set -euo pipefail

sudo=""
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "install-packages.sh: run as root, or install sudo" >&2; exit 1; }
  sudo="sudo"
fi
export DEBIAN_FRONTEND=noninteractive
apt_get() { $sudo env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 "$@"; }
installed() { [[ "$(dpkg-query -W -f='${Status}' "$1" 2>/dev/null)" == *"ok installed"* ]]; }

build_packages=(
  build-essential cmake ninja-build pkg-config ccache python3 dpkg-dev fakeroot file
  libembree-dev libtbb-dev libglm-dev libopenexr-dev libstb-dev libzstd-dev libeigen3-dev
  libcli11-dev libspdlog-dev libfmt-dev nlohmann-json3-dev libtomlplusplus-dev libpng-dev zlib1g-dev libxxhash-dev
  libdraco-dev libmeshoptimizer-dev libwebp-dev
  libvulkan-dev glslang-tools spirv-tools
)
demo_packages=("${build_packages[@]}" libvulkan1 mesa-vulkan-drivers imagemagick fonts-dejavu-core)
packages=(
  "${demo_packages[@]}"
  git ca-certificates vulkan-validationlayers
  libgtest-dev libgmock-dev libbenchmark-dev clang-format
  patchelf
  parallel slurm-wlm munge # farm/: launchers and their tests
)
# The window and its tests; the program is built without one where they cannot be had.
window_packages=(libsdl2-dev libimgui-dev xvfb xdotool)
if [ "${1:-}" = "--demo" ]; then packages=("${demo_packages[@]}") window_packages=(); fi
if [ "${1:-}" = "--build" ]; then packages=("${build_packages[@]}") window_packages=(libsdl2-dev libimgui-dev); fi
if [ "${1:-}" = "--node" ] && ! command -v npm >/dev/null; then packages+=(nodejs npm); fi
# Ubuntu's chromium is a snap, which containers cannot run; there the tests of web/ are skipped unless a browser is there.
if [ "${1:-}" = "--node" ] && [ "$(. /etc/os-release && echo "${ID:-}")" = "debian" ]; then packages+=(chromium blender python3-numpy xauth mypy python3-nbclient python3-ipykernel python3-tqdm); fi

missing=()
for package in "${packages[@]}"; do installed "$package" || missing+=("$package"); done
if [ "${#missing[@]}" -gt 0 ]; then
  apt_get update -qq || echo "install-packages.sh: 'apt-get update' reported errors; going on with the lists at hand" >&2
  apt_get install -y -qq --no-install-recommends "${missing[@]}"
fi

# Debian 12 ships Mesa 22.3, whose CPU Vulkan driver is too old (descriptor indexing); its own backports suite, on the
# mirror this machine already uses, has 25. Other systems keep what they have: Ubuntu 24.04's is new enough.
# Output of apt-cache goes to variables first: a reader that stops early would break its pipe, which pipefail reports.
mesa_major() { dpkg-query -W -f='${Version}' mesa-vulkan-drivers 2>/dev/null | sed 's/^[0-9]*://; s/\..*//'; }
system=$(. /etc/os-release && echo "${ID:-} ${VERSION_ID:-}")
if [ "${1:-}" != "--build" ] && [ "$system" = "debian 12" ] && [ "$(mesa_major)" -lt 25 ]; then
  suite=bookworm-backports
  policy=$(apt-cache policy)
  if ! grep -q "$suite" <<<"$policy"; then
    mirrors=$(sed -n 's#.* \(https\?://[^ ]*\) bookworm/main .*#\1#p' <<<"$policy")
    mirror=${mirrors%%$'\n'*}
    keyring=/usr/share/keyrings/debian-archive-keyring.gpg
    echo "deb [signed-by=$keyring] ${mirror:-http://deb.debian.org/debian} $suite main" |
      $sudo tee "/etc/apt/sources.list.d/halflight-backports.list" >/dev/null
    apt_get update -qq || true
  fi
  apt_get install -y -qq --no-install-recommends -t "$suite" mesa-vulkan-drivers
fi

missing=()
for package in "${window_packages[@]}"; do installed "$package" || missing+=("$package"); done
if [ "${#missing[@]}" -gt 0 ]; then
  # With Mesa from backports, SDL's headers need those of the same suite.
  versions=$(dpkg-query -W -f='${Version} ' libgbm1 libdrm2 2>/dev/null || true)
  if [[ "$versions" == *"~bpo12"* ]]; then
    apt_get install -y -qq --no-install-recommends -t bookworm-backports libgbm-dev libdrm-dev || true
  fi
  apt_get install -y -qq --no-install-recommends "${missing[@]}" ||
    echo "install-packages.sh: no SDL2 or Dear ImGui: halflight view is not built" >&2
fi

# libFuzzer belongs to clang's runtime, whose package is named after clang's version.
if [ "${1:-}" = "--node" ]; then
  installed clang || apt_get install -y -qq --no-install-recommends clang || true
  clang_major=$(clang --version 2>/dev/null | sed -n 's/.*version \([0-9]*\)\..*/\1/p')
  if [ -n "$clang_major" ] && ! installed "libclang-rt-$clang_major-dev"; then
    apt_get install -y -qq --no-install-recommends "libclang-rt-$clang_major-dev" ||
      echo "install-packages.sh: no libFuzzer for clang $clang_major: readers will not be fuzzed" >&2
  fi
fi
