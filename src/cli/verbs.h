/* The verbs of the command line that are about many runs. Exit status: 0, 1 for a failure, 2 for bad usage or
 * input. */
#pragma once

int ll_verb_sweep(int argc, char **argv);
int ll_verb_worker(int argc, char **argv);
int ll_verb_submit(int argc, char **argv);
int ll_verb_store(int argc, char **argv);
int ll_verb_merge(int argc, char **argv);
int ll_verb_advise(int argc, char **argv);
int ll_verb_work_precision(int argc, char **argv);
