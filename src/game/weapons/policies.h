/* Rows of the tables of hitscan policies and projectile families: one file each. */
#pragma once

#include "game/core/compensate.h"

extern const ll_rifle_policy ll_rifle_none;
extern const ll_rifle_policy ll_rifle_rewind;
extern const ll_rifle_policy ll_rifle_trust;

extern const ll_shell_family ll_shell_none;
extern const ll_shell_family ll_shell_fast_forward;
extern const ll_shell_family ll_shell_rewind;
extern const ll_shell_family ll_shell_partial;
extern const ll_shell_family ll_shell_trust;
