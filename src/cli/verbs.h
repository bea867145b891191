/* The verbs of the command line. Each gets the arguments after its name. Exit status: 0, 1 for a failure, 2
 * for invalid usage or input. */
#pragma once

int ll_verb_serve(int argc, char **argv);
int ll_verb_run(int argc, char **argv);
int ll_verb_link_trace(int argc, char **argv);
int ll_verb_replay(int argc, char **argv);
int ll_verb_sweep(int argc, char **argv);
int ll_verb_merge(int argc, char **argv);
int ll_verb_reproduce(int argc, char **argv);
int ll_verb_advise(int argc, char **argv);
int ll_verb_work_precision(int argc, char **argv);
int ll_verb_tradeoff(int argc, char **argv);
int ll_verb_scenarios(int argc, char **argv);
int ll_verb_schema(int argc, char **argv);
int ll_verb_methods(int argc, char **argv);
int ll_verb_problems(int argc, char **argv);
int ll_verb_healthcheck(int argc, char **argv);
