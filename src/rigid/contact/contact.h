/* Contacts of bodies, the joints that hang on them, and who sleeps with whom. */
#pragma once

#include "rigid/body/world_state.h"

/* ---- contact.c ---- */

void ll_find_pairs(ll_rigid *w, ll_team *team, bool *overflowed);
void ll_remove_contact(ll_rigid *w, int32_t contact);
void ll_awake_contact(ll_rigid *w, int32_t contact);
void ll_sleep_contact(ll_rigid *w, int32_t contact);
bool ll_pair_exists(const ll_rigid *w, int32_t a, int32_t b);
/* A contact that begins to touch has a colour, until it ends. */
void ll_take_colour(ll_rigid *w, ll_contact *c);
void ll_give_colour(ll_rigid *w, ll_contact *c);

/* ---- update.c ---- */

void ll_update_contacts(ll_rigid *w, ll_team *team);
/* For these poses of the bodies; in a's frame. */
ll_manifold ll_manifold_of(const ll_rigid *w, const ll_contact *c, ll_pose a, ll_pose b, double margin);

/* ---- island.c ---- */

void ll_wake(ll_rigid *w, int32_t body); /* wakes its whole island */
void ll_put_to_sleep(ll_rigid *w);       /* islands that have rested for LL_SLEEP_TIME */

bool ll_joint_awake(const ll_rigid *w, int32_t joint); /* at least one of its bodies is awake */

/* Edges with at least one awake body; returns their count. */
int32_t ll_touching_edges(const ll_rigid *w, ll_team *team, ll_island_edge *out);
int32_t ll_joint_edges(const ll_rigid *w, ll_island_edge *out);

/* Union-find: the parent of a root is minus the size of its island; LL_ALONE bodies join nothing. */
#define LL_ALONE (-1)
#define LL_APART INT32_MIN
void ll_join(int32_t *parent, const ll_island_edge *links, int32_t count);
int32_t ll_root_of(int32_t *parent, int32_t body);

/* Whether a joint forbids two bodies to collide. */
bool ll_joint_blocks_collision(const ll_rigid *w, int32_t a, int32_t b);
