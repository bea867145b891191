/* Who looks at a session, and what they have sent that its worker has not applied yet. */
#include <stdlib.h>

#include "daemon/hosting/hosted.h"

bool ll_viewers_any(ll_hosted *hosted)
{
    pthread_mutex_lock(&hosted->inbox_lock);
    bool any = hosted->viewers != NULL;
    pthread_mutex_unlock(&hosted->inbox_lock);
    return any;
}

void ll_viewers_dismiss(ll_hosted *hosted, const char *reason)
{
    pthread_mutex_lock(&hosted->inbox_lock);
    for (ll_viewer *v = hosted->viewers; v; v = v->next)
        ll_ws_close(hosted->host->ws, v->id, LL_WS_TRY_LATER, reason);
    pthread_mutex_unlock(&hosted->inbox_lock);
}

void ll_viewers_forget(ll_hosted *hosted)
{
    while (hosted->viewers) {
        ll_viewer *viewer = hosted->viewers;
        hosted->viewers = viewer->next;
        free(viewer);
    }
    while (hosted->inputs) {
        ll_stream_input *input = hosted->inputs;
        hosted->inputs = input->next;
        free(input);
    }
    hosted->inputs_end = &hosted->inputs;
}
