#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# One of Sinew's long jobs on a cluster with Slurm: sbatch --ntasks=1000 docs/slurm.sh dataset SCENARIO --runs 1000000 --out /scratch/set
#
# What is after the script's name is the command of `sinew`, without --threads. The folder of --out lies where every node can write. The job
# goes on by itself after a rank was killed, and is queued again where its time is up.
#SBATCH --job-name=sinew
#SBATCH --ntasks=8
#SBATCH --cpus-per-task=1
#SBATCH --time=08:00:00
#SBATCH --signal=INT@300
#SBATCH --requeue
#SBATCH --open-mode=append
set -u

if [ "${1:-}" = evaluate ]; then
  echo "evaluate keeps nothing of a job that is stopped; run it under mpirun" >&2
  exit 2
fi

# Slurm interrupts five to six minutes before the end. Where it does not say when that is, time is not up.
time_is_up() {
  local end
  end=$(squeue --noheader --job "$SLURM_JOB_ID" --format %e) && [ -n "$end" ] && end=$(date -d "$end" +%s 2> /dev/null) || return 1
  [ $((end - $(date +%s))) -lt 400 ]
}

for attempt in 1 2 3; do
  srun --mpi=pmix --kill-on-bad-exit=1 "${SINEW:-sinew}" "$@" --threads "${SLURM_CPUS_PER_TASK:-1}"
  code=$?
  [ "$code" -lt 128 ] && exit "$code" # done, or refused: said above
  if time_is_up && [ "${SLURM_RESTART_COUNT:-0}" -lt 100 ]; then exec scontrol requeue "$SLURM_JOB_ID"; fi
  [ "$code" -eq 130 ] && exit "$code" # interrupted by a person
  echo "attempt $attempt: a rank was killed" >&2
done
exit "$code"
