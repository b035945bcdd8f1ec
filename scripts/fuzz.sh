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

cmake --preset fuzz --log-level=WARNING
cmake --build --preset fuzz
status=0
mkdir -p build/fuzz/failures
for reader in "${readers[@]}"; do
  corpus="build/fuzz/corpus/$reader"
  mkdir -p "$corpus"
  seeds=("assets/tests/fuzz/$reader")
  options=()
  case "$reader" in
    gltf) seeds+=(assets/tests/compressed); options+=(-dict=tests/fuzz/gltf.dict) ;;
    baked) options+=(-dict=tests/fuzz/gltf.dict) ;;
    settings | decoders) ;;
    *) echo "fuzz.sh: no reader '$reader' (gltf, baked, settings, decoders)" >&2; exit 2 ;;
  esac
  log="build/fuzz/$reader.log"
  # The readers allow 4 GiB of what a small file asks for; a fuzzer's files are at most 64 KiB.
  if "build/fuzz/tests/fuzz/fuzz_$reader" -max_total_time="$seconds" -max_len=65536 -timeout=20 -rss_limit_mb=3072 \
    -artifact_prefix="build/fuzz/failures/$reader-" "${options[@]}" "$corpus" "${seeds[@]}" >"$log" 2>&1; then
    echo "fuzz $reader: $(grep -E '^Done ' "$log")"
  else
    status=1
    tail -n 40 "$log" >&2
    echo "fuzz.sh: $reader failed; the input is in build/fuzz/failures" >&2
  fi
done
exit "$status"
