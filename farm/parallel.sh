#!/usr/bin/env bash
# Bakes a plan of `halflight farm plan` with GNU parallel: on this host, or on several by ssh.
#
#   farm/parallel.sh PLAN OUT WORKERS [OPTIONS OF parallel]...
#
#   farm/parallel.sh plan baked.glb 16                                   one worker a core of this host
#   farm/parallel.sh /farm/plan baked.glb 64 --sshloginfile hosts.txt    hosts that see /farm, HALFLIGHT and each other's clock
#
# HALFLIGHT names the program (default: halflight), THREADS the threads of a worker (default: 1). Workers that fail run
# again, up to three times in all. A second run does only what is missing.
set -euo pipefail
[ $# -ge 3 ] || { sed -n '2,11s/^# \{0,1\}//p' "$0" >&2; exit 2; }
plan=$(realpath "$1") out=$2 workers=$3
shift 3
halflight=${HALFLIGHT:-halflight}
threads=${THREADS:-1}

for stage in cache tiles; do
  # A worker that fails for good fails the stage; the cache stage needs one that succeeds, `join` finds missing tiles.
  seq 0 $((workers - 1)) |
    parallel --will-cite --retries 3 --joblog "$plan/joblog.$stage" "$@" \
      "$halflight" farm work "$plan" --index {} --of "$workers" --stage "$stage" --threads "$threads" --quiet ||
    echo "parallel.sh: workers of the stage $stage failed: see $plan/joblog.$stage" >&2
done
exec "$halflight" farm join "$plan" -o "$out" --of "$workers" --quiet
