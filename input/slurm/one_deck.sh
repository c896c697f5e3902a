#!/bin/bash
#SBATCH --ntasks=4
#SBATCH --cpus-per-task=1
#SBATCH --time=04:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
# Run one deck on several ranks. A run that does not end in time stops with a checkpoint, and the job
# goes into the queue again and continues.
# usage: sbatch one_deck.sh deck.inp [further options of bezel, except -o, --name and --restart]
set -u
deck=$1
shift
bezel=${BEZEL:-build/mpi/bezel}
out=${OUT:-out}
limit=${LIMIT:-13800}                # seconds: ten minutes less than --time
ranks=${SLURM_NTASKS:-2}
stem=$(basename "$deck")
stem=${stem%.*}                      # without its ending, whatever it is
checkpoint=$out/$stem.restart.h5

options=(-o "$out" --name "$stem" --time-limit "$limit" "$@")
[ ! -e "$checkpoint" ] || options+=(--restart "$checkpoint")
${LAUNCH:-mpirun} -n "$ranks" "$bezel" "${options[@]}" "$deck"
code=$?
if [ $code = 4 ] && [ -n "${SLURM_JOB_ID:-}" ]; then
  scontrol requeue "$SLURM_JOB_ID"
fi
exit $code
