#!/bin/bash
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --time=04:00:00
#SBATCH --requeue
# Run one deck of a list in each job of an array, with the serial program. Jobs continue from their
# checkpoints if they are put into the queue again.
# usage: sbatch --array=1-N many_decks.sh deck_1.inp ... deck_N.inp
set -u
task=${SLURM_ARRAY_TASK_ID:-1}
deck=${!task}
bezel=${BEZEL:-build/release/bezel}
stem=$(basename "$deck")
stem=${stem%.*}                       # without its ending, whatever it is
out=${OUT:-out}/$stem
checkpoint=$out/$stem.restart.h5

options=(-o "$out" --name "$stem" --time-limit "${LIMIT:-13800}")
[ ! -e "$checkpoint" ] || options+=(--restart "$checkpoint")
"$bezel" "${options[@]}" "$deck"
code=$?
if [ $code = 4 ] && [ -n "${SLURM_ARRAY_JOB_ID:-}" ]; then
  scontrol requeue "${SLURM_ARRAY_JOB_ID}_$task"
fi
exit $code
