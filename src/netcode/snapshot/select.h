/* What the codecs have in common that send only some of the entities.
 *
 * A snapshot has the receiver's own entity, bitwise; the grid, where there is no baseline; the game's tail,
 * if it is not the baseline's; then entities, in any order, each after a 1, and a 0 at the end. An entity is
 * its index; whether it is gone; whether it is sent bitwise; whether as differences from an earlier state,
 * and whether from that of the same tick as the one before it, or the age of that state in ticks; its
 * members. */
#pragma once

#include "netcode/snapshot/replica.h"
#include "netcode/snapshot/snapshot.h"

typedef struct ll_selection_rule {
    bool deltas;   /* differences from the newest state that the client has acknowledged of the entity */
    bool interest; /* only entities in the receiver's area of interest */
} ll_selection_rule;

void ll_select_encode(ll_bit_writer *w, const ll_outgoing *out, ll_selection_rule rule,
                      ll_snapshot_cost *cost);
ll_status ll_select_decode(ll_bit_reader *r, const ll_incoming *in);

/* Priority of an entity at this distance: 1 up to a quarter of the radius, then falling as 1 / distance. */
double ll_select_priority(const ll_selection *selection, double distance_m);
