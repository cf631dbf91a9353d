#!/bin/sh
# properties = {properties}
# What a node runs, in the folder of the workflow. The marker holds the exit code when Slurm has forgotten it; it is
# renamed, so that a reader finds all of it or none.
marker=.snakemake/slurm/$SLURM_JOB_ID
mkdir -p .snakemake/slurm
trap 'code=$?; echo "$code" >"$marker.part" && mv "$marker.part" "$marker.code"' EXIT
{exec_job}
