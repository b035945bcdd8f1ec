#!/usr/bin/env bash
# How a bake scales: seconds by stage and number of threads, one process of one thread against many (halflight farm), and
# what every worker repeats. Builds nothing; needs bash and awk.
#
#   scripts/measure_scaling.sh HALFLIGHT SCENE [OPTIONS OF bake]...
#
#   scripts/measure_scaling.sh build/dev/apps/halflight/halflight sponza.glb --quality preview --lightmap-size 2048
#
# THREADS="1 2 4 8 16" chooses the columns, WORKERS=16 the processes of the farm (default: the largest number of threads),
# TMPDIR where plans go. Prints Markdown.
set -euo pipefail
[ $# -ge 2 ] || { sed -n '2,12s/^# \{0,1\}//p' "$0" >&2; exit 2; }
halflight=$(realpath "$1") scene=$(realpath "$2")
shift 2
cores=$(nproc)
counts=()
for n in ${THREADS:-1 2 4 8 16}; do [ "$n" -gt "$cores" ] || counts+=("$n"); done
workers=${WORKERS:-${counts[-1]}}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
now() { date +%s.%N; }
since() { awk -v a="$1" -v b="$(now)" 'BEGIN { printf "%.2f", b - a }'; }
# CPU seconds of all processes that have ended so far.
cpu() { awk -v hertz="$(getconf CLK_TCK)" '{ print ($16 + $17) / hertz }' "/proc/$$/stat"; }
cpu_since() { awk -v a="$1" -v b="$(cpu)" 'BEGIN { printf "%.2f", b - a }'; }

echo "$(basename "$scene") $*, $cores cores, $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)"
for n in "${counts[@]}"; do
  start=$(now) spent=$(cpu)
  "$halflight" bake "$scene" -o "$work/bake.glb" --threads "$n" "$@" > "$work/$n.txt" 2> /dev/null
  echo "whole $(since "$start") $(cpu_since "$spent")" >> "$work/$n.txt"
  [ "$n" = "${counts[0]}" ] && cp "$work/bake.glb" "$work/first.glb"
  cmp -s "$work/bake.glb" "$work/first.glb" || echo "OTHER BYTES with $n threads" >&2
done

# Rows: the stages of the summary's last table; "read, write" is what is in none of them.
echo
awk -v counts="${counts[*]}" -v folder="$work" 'BEGIN {
  columns = split(counts, count, " ")
  for (c = 1; c <= columns; ++c) {
    file = folder "/" count[c] ".txt"; inside = 0; sum = 0
    while ((getline line < file) > 0) {
      split(line, word, " ")
      if (word[1] == "stage") { inside = 1; continue }
      if (word[1] == "whole") { whole[c] = word[2]; cpu[c] = word[3]; continue }
      if (!inside || line == "") continue
      name = line; sub(/  .*/, "", name)
      rest = substr(line, length(name) + 1); split(rest, number, " ")
      if (!(name in seen)) { seen[name] = 1; order[++rows] = name }
      seconds[name, c] += number[1]; sum += number[1]
    }
    other[c] = whole[c] - sum
  }
  head = "| threads |"; rule = "|---|"
  for (c = 1; c <= columns; ++c) { head = head " " count[c] " |"; rule = rule "---|" }
  print head; print rule
  for (r = 1; r <= rows; ++r) {
    row = "| " order[r] " |"
    for (c = 1; c <= columns; ++c) row = row sprintf(" %.2f |", seconds[order[r], c])
    print row
  }
  row = "| read, write |"; for (c = 1; c <= columns; ++c) row = row sprintf(" %.2f |", other[c]); print row
  row = "| **whole** |"; for (c = 1; c <= columns; ++c) row = row sprintf(" %.2f |", whole[c]); print row
  row = "| CPU seconds |"; for (c = 1; c <= columns; ++c) row = row sprintf(" %.1f |", cpu[c]); print row
  row = "| efficiency |"; for (c = 1; c <= columns; ++c) row = row sprintf(" %.2f |", whole[1] * count[1] / count[c] / whole[c]); print row
}'

read -r one one_cpu < <(sed -n 's/^whole //p' "$work/${counts[0]}.txt")
# Seconds of the stages that workers share.
shared=$(awk '$1 == "stage" { inside = 1 }
  inside && match($0, /^(validity|lightmap|main light|shadowmask|probes)  +/) { split(substr($0, RLENGTH), n, " "); sum += n[1] }
  END { print sum }' "$work/${counts[0]}.txt")
plan=$work/plan
start=$(now)
"$halflight" farm plan "$scene" -o "$plan" --threads "$workers" -q "$@"
planned=$(since "$start")
all() {
  local i pids=()
  for ((i = 0; i < workers; ++i)); do
    "$halflight" farm work "$plan" --index "$i" --of "$workers" --threads 1 -q & pids+=($!)
  done
  for i in "${pids[@]}"; do wait "$i"; done
}
spent=$(cpu)
start=$(now); all; worked=$(since "$start")
work_cpu=$(cpu_since "$spent")
# Everything is there: what a worker still does, all others do too.
spent=$(cpu); "$halflight" farm work "$plan" --index 0 --of "$workers" --threads 1 -q; repeated=$(cpu_since "$spent")
start=$(now); "$halflight" farm join "$plan" -o "$work/joined.glb" --threads "$workers" -q; joined=$(since "$start")
cmp "$work/joined.glb" "$work/first.glb" && same="the same bytes" || same="OTHER BYTES"
echo
awk -v one="$one" -v n="$workers" -v plan="$planned" -v work="$worked" -v repeated="$repeated" \
  -v shared="$shared" -v one_cpu="$one_cpu" -v work_cpu="$work_cpu" -v join="$joined" -v same="$same" 'BEGIN {
  all = plan + work + join
  printf "Farm of %d processes of one thread: plan %.2f s, work %.2f s, join %.2f s (plan and join with %d threads): %.2f s, %s.\n", n, plan, work, join, n, all, same
  printf "One process of one thread: %.2f s. Efficiency %.2f; of the work alone %.2f.\n", one, one / n / all, shared / n / work
  printf "CPU seconds: %.1f of the bake, %.1f of all workers together.\n", one_cpu, work_cpu
  s = repeated / one_cpu
  printf "Every worker repeats %.2f CPU seconds (tiles it has done are read again), %.2f %% of the bake", repeated, 100 * s
  for (k = 8; k <= 128; k *= 2) printf "%s efficiency %.2f with %d workers", k == 8 ? ":" : ",", 1 / (1 + s * (k - 1)), k
  print "."
}'
