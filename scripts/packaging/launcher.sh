#!/bin/sh
# Runs halflight (lib/halflight/halflight). It needs glibc @MAJOR@.@MINOR@: the system's own where its loader says that it is as new,
# else the one in lib/halflight/glibc. A system without that loader (musl), or with one that does not tell its version
# (glibc before 2.33), gets the latter. HALFLIGHT_GLIBC=system or =bundled chooses by hand.
self=$0
[ ! -L "$self" ] || self=$(readlink -f -- "$self")
case $self in
  */*) lib=${self%/*}/../lib/halflight ;;
  *) lib=../lib/halflight ;;
esac

glibc=${HALFLIGHT_GLIBC:-bundled}
if [ -z "${HALFLIGHT_GLIBC:-}" ]; then
  said=$(@LOADER@ --version 2>/dev/null)
  version=${said#*release version }
  major=${version%%.*}
  rest=${version#*.}
  minor=${rest%%[!0-9]*}
  # What is not a number is an error for test, and so not as new.
  { [ "$major" -gt @MAJOR@ ] || { [ "$major" -eq @MAJOR@ ] && [ "$minor" -ge @MINOR@ ]; }; } 2>/dev/null && glibc=system
fi

case $glibc in
  system) exec "$lib/halflight" "$@" ;;
  bundled)
    # Without the program's own search path, which begins with folders of the system. An older system's libraries and Vulkan
    # drivers load into a newer glibc and libstdc++.
    exec "$lib/glibc/@LOADER_NAME@" --argv0 "$0" --inhibit-rpath '' \
      --library-path "\$ORIGIN/glibc:\$ORIGIN:\$ORIGIN/fallback${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}" "$lib/halflight" "$@" ;;
  *)
    echo "halflight: HALFLIGHT_GLIBC must be system or bundled, not '$glibc'" >&2
    exit 2 ;;
esac
