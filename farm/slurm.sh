#!/usr/bin/env bash
# Bakes a plan of `halflight farm plan` with Slurm: an array of workers for the cache stage, one for the tiles, and a job
# that joins them.
#
#   farm/slurm.sh PLAN OUT WORKERS [OPTIONS OF sbatch]...
#
#   farm/slurm.sh /farm/plan /farm/baked.glb 64 --cpus-per-task=4 --mem=8G --partition=night
#
# All nodes see PLAN, OUT and the program. HALFLIGHT names the program (default: halflight). The last line printed is the
# number of the joining job; `sbatch` options such as --wait hold for that one too. A worker that fails is queued again,
# up to three times. A second run submits only workers whose tiles are missing. Logs are in PLAN/logs.
set -euo pipefail
[ $# -ge 3 ] || { sed -n '2,12s/^# \{0,1\}//p' "$0" >&2; exit 2; }
plan=$(realpath "$1") out=$(realpath -m "$2") workers=$3
shift 3
halflight=$(command -v "${HALFLIGHT:-halflight}")
mkdir -p "$plan/logs"

# Indices of an array lie below MaxArraySize (1001 unless the site says otherwise): more workers take several arrays.
most=$(scontrol show config | sed -n 's/^MaxArraySize *= *//p')

# "0-2,7" to one number a line, and back.
numbers() { tr ',' '\n' | while IFS=- read -r a b; do [ -z "$a" ] || seq "$a" "${b:-$a}"; done; }
ranges() {
  awk 'NR > 1 && $1 == last + 1 { last = $1; next }
       NR > 1 { printf "%s%s,", first, (last > first ? "-" last : "") }
       { first = last = $1 }
       END { if (NR) printf "%s%s", first, (last > first ? "-" last : "") }'
}

# submit STAGE LIST DEPENDENCY: submits arrays of workers and sets `jobs` to ":ID:ID…".
submit() {
  local stage=$1 list=$2 dependency=$3 block array
  shift 3
  jobs=""
  for ((block = 0; block < workers; block += most)); do
    array=$(numbers <<<"$list" | awk -v a="$block" -v n="$most" '$1 >= a && $1 < a + n { print $1 - a }' | ranges)
    [ -n "$array" ] || continue
    jobs+=":$(sbatch --parsable --job-name="halflight-$stage" --requeue --open-mode=append --array="$array" \
      --output="$plan/logs/$stage-%A-%a.log" ${dependency:+--dependency=afterany$dependency} "${options[@]}" <<SCRIPT
#!/bin/bash
"$halflight" farm work "$plan" --index \$(($block + SLURM_ARRAY_TASK_ID)) --of $workers --stage $stage \
  --threads \${SLURM_CPUS_PER_TASK:-1} --quiet && exit 0
code=\$?
[ "\${SLURM_RESTART_COUNT:-0}" -ge 3 ] || scontrol requeue "\$SLURM_JOB_ID"
exit \$code
SCRIPT
    )"
  done
}

options=()
last=()
for option in "$@"; do
  if [ "$option" = "--wait" ]; then last+=("$option"); else options+=("$option"); fi
done

missing=$("$halflight" farm status "$plan" --of "$workers" --missing)
jobs=""
if "$halflight" farm status "$plan" --json | grep -q '"cacheComplete": false'; then
  submit cache "0-$((workers - 1))" ""
fi
[ -z "$missing" ] || submit tiles "$missing" "$jobs"
# `afterany`: `join` itself says what is missing.
sbatch --parsable --job-name=halflight-join --output="$plan/logs/join-%j.log" ${jobs:+--dependency=afterany$jobs} \
  "${options[@]}" "${last[@]}" <<SCRIPT
#!/bin/bash
exec "$halflight" farm join "$plan" -o "$out" --of $workers --threads \${SLURM_CPUS_PER_TASK:-1} --quiet
SCRIPT
