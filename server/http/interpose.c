/* SPDX-License-Identifier: MIT */
#include "interpose.h"
#include <dlfcn.h>
#include <microhttpd.h>

typedef enum MHD_Result queue_function(struct MHD_Connection *connection, unsigned status,
                                       struct MHD_Response *response);

static queue_function *queue_response; /* the library's */
static interpose_page *own_page;

bool interpose_init(interpose_page *page) {
    own_page = page;
    *(void **)&queue_response = dlsym(RTLD_NEXT, "MHD_queue_response");
    return queue_response != NULL;
}

bool interpose_queue(struct MHD_Connection *connection, unsigned status,
                     struct MHD_Response *response) {
    return queue_response(connection, status, response) == MHD_YES;
}

enum MHD_Result MHD_queue_response(struct MHD_Connection *connection, unsigned status,
                                   struct MHD_Response *response) {
    own_page(connection, status);
    return queue_response(connection, status, response);
}
