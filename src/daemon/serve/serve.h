/* The verb `serve`, and `healthcheck` for containers. Both take the arguments after the verb and return the
 * exit status. */
#pragma once

int ll_serve(int argc, char **argv);

/* Exit 0 when the daemon at the URL (http://127.0.0.1:8080) is ready. */
int ll_healthcheck(int argc, char **argv);
