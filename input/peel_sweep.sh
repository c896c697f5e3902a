#!/bin/bash
# A sweep of the peel test as a SLURM job array that survives its time limit:
#   sbatch input/peel_sweep.sh
# Each task peels one strength. bezel stops itself before the limit with a checkpoint and exit code 4;
# the task then queues itself again and goes on from there. Exit code 2 (no solution) ends a task.
#SBATCH --job-name=peel
#SBATCH --array=0-3
#SBATCH --ntasks=1
#SBATCH --time=00:30:00
#SBATCH --requeue
strengths=(0.05 0.1 0.15 0.2)
tmax=${strengths[${SLURM_ARRAY_TASK_ID:-0}]}
limit=${PEEL_SECONDS:-1500}        # five minutes less than --time
bezel=${BEZEL:-build/release/bezel}
out=${PEEL_OUT:-peel_sweep}/tmax_$tmax
checkpoint=$out/peel_test.restart.h5

options=(--quiet -o "$out" --set "tmax=$tmax" --time-limit "$limit")
if [ -f "$checkpoint" ]; then options+=(--restart "$checkpoint"); fi
"$bezel" "${options[@]}" input/peel_test.inp
code=$?
if [ $code -eq 4 ] && [ -n "$SLURM_JOB_ID" ]; then
  scontrol requeue "${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}"
  exit 0
fi
exit $code
