// How many runs a disturbed experiment has: with killed workers and a crashing server, and under Slurm.
export const RUNS = 15000;
