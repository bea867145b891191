#include "netcode/client/scope.h"

const ll_prediction_scope *const ll_scopes[] = {&ll_prediction_scope_own, &ll_prediction_scope_contacts,
                                                &ll_prediction_scope_all, NULL};

/* In the order of ll_scopes; a test compares both. */
const char *const ll_prediction_scope_names[] = {"own", "contacts", "all", NULL};
