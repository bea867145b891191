/* What the handlers of experiments share. */
#pragma once

#include "daemon/api/api.h"
#include "experiment/store/result_store.h"

/* The experiment of the path's first parameter. False: not found, and answered. `experiment` may be NULL. */
bool ll_api_experiment(ll_api *api, const ll_http_request *request, ll_http_response *response,
                       ll_experiment_record *record, ll_experiment **experiment);

/* Whether a run is small enough to be made for a request. */
ll_status ll_api_run_size(const ll_api *api, const ll_experiment *experiment, int64_t run);
