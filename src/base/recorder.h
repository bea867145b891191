/* Who listens to what a simulation does as it goes. */
#pragma once

/* `record` is called in the order of virtual time, with rows of the type that the kind of simulation has for
 * them. A NULL recorder writes nothing: batch runs do not pay for events. */
typedef struct ll_recorder {
    void (*record)(void *context, const void *row);
    void *context;
    void (*packet)(void *context, const void *row); /* rows of packets, of a kind that has them; NULL: none */
} ll_recorder;
