# Clean systems, for scripts that source this file: made by debootstrap in $HALFLIGHT_ROOTS and kept there.
roots="${HALFLIGHT_ROOTS:-/var/cache/halflight}"
mirror="${HALFLIGHT_MIRROR:-http://deb.debian.org/debian}"
ubuntu_mirror="${HALFLIGHT_UBUNTU_MIRROR:-http://archive.ubuntu.com/ubuntu}"
install="apt-get install -y -qq --no-install-recommends"
cached="${cached:-0}" # 1: never make a root

skip() { echo "skipped: $1"; exit 77; }

# Of the scripts that build for another system, [--cached] [--program] [OUT]: sets cached, packages (0: the program
# alone) and out, a whole path.
read_cross_options() {
  packages=1
  while [ $# -gt 0 ]; do
    case "$1" in
      --cached) cached=1; shift ;;
      --program) packages=0; shift ;;
      -*) echo "usage: $0 [--cached] [--program] [OUT]" >&2; exit 2 ;;
      *) break ;;
    esac
  done
  out=$(realpath -m "${1:-out/packages}")
}

need_roots() {
  [ "$(id -u)" -eq 0 ] || skip "clean roots need root's rights"
  unshare -m true 2>/dev/null || skip "this machine allows no mount namespaces"
  command -v debootstrap >/dev/null || [ -x "$roots/bookworm/bin/sh" ] || skip "debootstrap is not installed (apt-get install debootstrap)"
}

make_root() { # SUITE
  local suite="$1" from="$mirror" options=() script=()
  [ -e "$roots/$suite/.complete" ] && return
  [ "$cached" -eq 0 ] || skip "there is no root $roots/$suite; scripts/test_packages.sh without --cached makes it"
  case "$suite" in
    jammy | noble)
      from="$ubuntu_mirror" options=(--components=main,universe --keyring=/usr/share/keyrings/ubuntu-archive-keyring.gpg)
      script=(/usr/share/debootstrap/scripts/gutsy) ;; # of all newer Ubuntus; Debian 12's debootstrap knows no noble
  esac
  rm -rf "${roots:?}/$suite"
  mkdir -p "$roots/archives"
  debootstrap --variant=minbase "${options[@]}" "$suite" "$roots/$suite" "$from" "${script[@]}" >"$roots/$suite.log" 2>&1 ||
    skip "debootstrap $suite failed: $(tail -1 "$roots/$suite.log")"
  touch "$roots/$suite/.complete"
}

# Runs a command in a root. /in and /out: $work's folders. /source: this tree. Downloaded packages are kept.
inside() { # ROOT COMMAND
  mkdir -p "$1/in" "$1/out" "$1/source" "$roots/archives" "$work/in" "$work/out"
  unshare -m bash -ec '
    mount --bind "$3" "$1/in"; mount --bind "$4" "$1/out"; mount --bind "$5" "$1/source"
    mount --bind "$6" "$1/var/cache/apt/archives"
    mount -t proc proc "$1/proc"; mount --rbind /dev "$1/dev"
    exec chroot "$1" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive bash -ec "$2"
  ' inside "$1" "$2" "$work/in" "$work/out" "$PWD" "$roots/archives"
}
