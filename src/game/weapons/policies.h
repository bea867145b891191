/* Rows of the tables of hitscan policies and projectile families: one file each. */
#pragma once

#include "game/core/compensate.h"

extern const ll_hitscan_policy ll_hitscan_none;
extern const ll_hitscan_policy ll_hitscan_rewind;
extern const ll_hitscan_policy ll_hitscan_client_authoritative;
extern const ll_hitscan_policy ll_hitscan_hybrid;
extern const ll_hitscan_policy ll_hitscan_victim_veto;

extern const ll_projectile_family ll_projectile_none;
extern const ll_projectile_family ll_projectile_fast_forward;
extern const ll_projectile_family ll_projectile_rewind;
extern const ll_projectile_family ll_projectile_partial;
extern const ll_projectile_family ll_projectile_client_authoritative;
