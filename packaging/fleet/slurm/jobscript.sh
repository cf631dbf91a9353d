#!/bin/sh
# properties = {properties}
# What a node runs, in the folder of the workflow. The marker tells how the job ended when Slurm has forgotten it; it is
# renamed, so that it is there whole or not at all.
marker=.snakemake/slurm/$SLURM_JOB_ID
mkdir -p .snakemake/slurm
trap 'code=$?; echo "$code" >"$marker.part" && mv "$marker.part" "$marker.code"' EXIT
{exec_job}
