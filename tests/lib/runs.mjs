// How many runs a disturbed experiment has: by workers that are killed beside a server that crashes, and under Slurm.
export const RUNS = 15000;
