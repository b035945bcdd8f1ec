#!/usr/bin/env bash
# Fuzzes the readers with libFuzzer, AddressSanitizer and UndefinedBehaviorSanitizer (preset "fuzz", needs clang and its
# runtime: scripts/install-packages.sh --node). Inputs that reach new code are kept in build/fuzz/corpus, so a later
# run goes on from there; an input that fails is left in build/fuzz/failures and the exit status is 1.
#
#   scripts/fuzz.sh [SECONDS [READER…]]     SECONDS for each reader, 60 when not given; READER: gltf baked settings decoders
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

seconds=${1:-60}
if ! [[ "$seconds" =~ ^[1-9][0-9]*$ ]]; then
  echo "usage: scripts/fuzz.sh [SECONDS [gltf|baked|settings|decoders…]]" >&2
  exit 2
fi
shift || true
readers=("$@")
if [ "${#readers[@]}" -eq 0 ]; then readers=(gltf baked settings decoders); fi

# A program of one line shows whether the compiler has libFuzzer's runtime.
if ! command -v clang++ >/dev/null ||
  ! echo 'extern "C" int LLVMFuzzerTestOneInput(const char*, unsigned long) { return 0; }' |
    clang++ -x c++ -fsanitize=fuzzer,address,undefined -o /dev/null - 2>/dev/null; then
  echo "fuzz.sh: clang++ with libFuzzer not found (scripts/install-packages.sh --node): readers not fuzzed" >&2
  exit 0
fi

# The preset compiles eight sources as one, in half the time: names in anonymous namespaces of one module differ.
cmake --preset fuzz --log-level=WARNING
cmake --build --preset fuzz
status=0
mkdir -p build/fuzz/failures
for reader in "${readers[@]}"; do
  case "$reader" in
    gltf | baked | settings | decoders) ;;
    *) echo "fuzz.sh: no reader '$reader' (gltf, baked, settings, decoders)" >&2; exit 2 ;;
  esac
done

fuzz() { # READER
  local corpus="build/fuzz/corpus/$1" seeds=("assets/tests/fuzz/$1") options=() log="build/fuzz/$1.log"
  mkdir -p "$corpus"
  if [ "$1" = gltf ]; then seeds+=(assets/tests/compressed); fi
  case "$1" in gltf | baked) options+=(-dict=tests/fuzz/gltf.dict) ;; esac
  # The readers allow 4 GiB of what a small file asks for; a fuzzer's files are at most 64 KiB.
  if "build/fuzz/tests/fuzz/fuzz_$1" -max_total_time="$seconds" -max_len=65536 -timeout=20 -rss_limit_mb=3072 \
    -artifact_prefix="build/fuzz/failures/$1-" "${options[@]}" "$corpus" "${seeds[@]}" >"$log" 2>&1; then
    echo "fuzz $1: $(grep -E '^Done ' "$log")"
  else
    tail -n 40 "$log" >&2
    echo "fuzz.sh: $1 failed; the input is in build/fuzz/failures" >&2
    return 1
  fi
}

# Two readers at a time, each with a core of its own.
for ((i = 0; i < ${#readers[@]}; i += 2)); do
  running=()
  for reader in "${readers[@]:i:2}"; do
    fuzz "$reader" &
    running+=($!)
  done
  for process in "${running[@]}"; do wait "$process" || status=1; done
done
exit "$status"
