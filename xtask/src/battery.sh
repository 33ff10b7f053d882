#!/bin/sh
# The benchmark battery for a machine with a GPU: every `murano bench` that times passes, one file of figures each.
#
#   ./battery.sh [RESULTS]    into the folder RESULTS, `results` unless said otherwise
#
# A benchmark that fails or takes longer than its limit is noted in RESULTS/log.txt, and the others go on.
set -u
here=$(cd "$(dirname "$0")" && pwd)
results=${1:-results}
mkdir -p "$results"
results=$(cd "$results" && pwd)
cd "$here"
failed=0

# measure NAME SECONDS ARGUMENTS...: what the program says goes to NAME.txt; the log gets a line with the time it took.
measure() {
    name=$1
    limit=$2
    shift 2
    start=$(date +%s)
    timeout "$limit" ./murano "$@" >"$results/$name.txt" 2>"$results/$name.err"
    status=$?
    [ $status -eq 0 ] || failed=1
    echo "$name: status $status, $(($(date +%s) - start)) s: murano $*" | tee -a "$results/log.txt"
}

{
    date -u +%Y-%m-%d
    uname -sr
    command -v nvidia-smi >/dev/null && nvidia-smi --query-gpu=name,driver_version --format=csv,noheader
} >"$results/machine.txt"

bodies="assets/sphere.glb assets/bumpy.glb $(ls models/*.glb 2>/dev/null | tr '\n' ' ')"
measure adapters 30 adapters
measure demo 60 export animations/demo.ron -o "$results/demo_####.png" --frames 0..2
# The time of every pass stands in these lines of JSON: the first frame is cold, the others are one pose each.
for model in assets/dancer.glb models/*.glb; do
    [ -f "$model" ] || continue
    measure "passes_$(basename "$model" .glb)" 60 export "$model" --glass --frames 0..8 --json -o "$results/passes_####.png"
done
measure animation 60 bench animation assets/dancer.glb assets/octopus.glb --json "$results/animation.json"
measure cache 90 bench cache assets/dancer.glb --frames 12 --json "$results/cache.json"
# shellcheck disable=SC2086 # a list of files
measure refraction 150 bench refraction $bodies --json "$results/refraction.json" \
    --methods sir:1,screen:1,isr:1,dir:2,dir:5,newton:2,newton:5,walk:5,layers:5,exact:1 --runs 9
# shellcheck disable=SC2086
measure caustics 150 bench caustics $bodies --photons 128,256,512 --map-sizes 512 --truth-photons 1000000 \
    --json "$results/caustics.json"
measure stability 90 bench stability --json "$results/stability.json"
exit $failed
