#!/usr/bin/env bash
# Bakes the lights of a scene on a cluster: a job array with a part of the bake in each
# job, and a job that joins the parts when all of them are there.
#
#   docs/slurm/bake.sh SCENE OUTPUT PARTS [options of `crepuscular bake`]
#
# SCENE is a file. It, OUTPUT and the program must lie on storage that all nodes share. Parts go to
# OUTPUT.parts/. A job that is lost, for whatever reason, leaves its part out: run the same
# command again, and only the parts that are missing are baked, each from its last
# checkpoint. CREPUSCULAR names the program, SBATCH_OPTIONS what sbatch is to know of the
# cluster (partition, account, time limit).
set -euo pipefail

if [ $# -lt 3 ]; then
    sed -n '2,11s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
scene=$(realpath "$1") output=$(realpath "$2") parts=$3
shift 3
# How nodes are stored is up to the merge.
options='' form=''
while [ $# -gt 0 ]; do
    case $1 in
    --form) form="--form $2"; shift ;;
    --form=*) form=$1 ;;
    *) options+=" $(printf '%q' "$1")" ;;
    esac
    shift
done
program=$(realpath "$(command -v "${CREPUSCULAR:-crepuscular}")")
mkdir -p "$output.parts"

# The parts that are not there yet, as 1,3,4.
missing=$(for ((part = 1; part <= parts; part++)); do
    [ -e "$output.parts/$part" ] || echo "$part"
done | paste --serial --delimiters=,)

dependency=()
if [ -n "$missing" ]; then
    # --resume goes on from a checkpoint if there is one. A job that is told to end, because
    # its time is up, leaves one behind: `exec` passes the signal on to the program.
    # shellcheck disable=SC2086
    bake=$(sbatch --parsable ${SBATCH_OPTIONS:-} --array="$missing" --job-name=bake \
        --output="$output.parts/%a.log" --open-mode=append --signal=B:TERM@60 \
        --wrap="exec '$program' bake '$scene'$options \
            --part \$SLURM_ARRAY_TASK_ID/$parts --resume \
            -o '$output.parts/'\$SLURM_ARRAY_TASK_ID")
    dependency=(--dependency="afterok:$bake" --kill-on-invalid-dep=yes)
    echo "parts $missing: job $bake"
fi

# shellcheck disable=SC2086
merge=$(sbatch --parsable ${SBATCH_OPTIONS:-} "${dependency[@]}" --job-name=merge \
    --output="$output.parts/merge.log" \
    --wrap="cd '$output.parts' && exec '$program' merge $(seq --separator=' ' "$parts") $form -o '$output'")
echo "merge: job $merge"
