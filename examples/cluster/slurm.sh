#!/bin/bash
# One job of a plan for each task of a Slurm array. From the folder that holds the plan:
#
#   gable plan tiles/ -f buildings.gpkg --jobs 500 -o plan
#   sbatch --array="$(gable merge --plan plan --missing)%100" slurm.sh plan
#   gable merge --plan plan -o city.city.jsonl
#
# The middle line again does what is missing, after a limit of time or a node that failed: a task that was killed goes on
# where it was, and one that is done does nothing.
#SBATCH --job-name=gable
#SBATCH --cpus-per-task=4
#SBATCH --mem=4G
#SBATCH --time=02:00:00
#SBATCH --requeue
#SBATCH --output=gable-%A_%a.log
set -euo pipefail

plan=${1:?the folder of the plan}
exec gable reconstruct --plan "$plan" --job "${SLURM_ARRAY_TASK_ID:?not a task of an array}" \
    --jobs "${SLURM_CPUS_PER_TASK:-1}"
