#include "game/core/game.h"

#include "game/games/games.h"

const ll_game *const ll_games[] = {&ll_game_race,    &ll_game_cannon, &ll_game_gambetta,
                                   &ll_game_shooter, &ll_game_crates, &ll_game_sea,
                                   &ll_game_dam,     &ll_game_stack,  NULL};

/* In the order of ll_games; a test compares the three arrays. */
const char *const ll_game_names[] = {"race", "cannon", "gambetta", "shooter", "crates",
                                     "sea",  "dam",    "stack",    NULL};
const ll_param_table *const ll_game_tables[] = {&ll_race_table,    &ll_cannon_table, &ll_gambetta_table,
                                                &ll_shooter_table, &ll_crates_table, &ll_sea_table,
                                                &ll_dam_table,     &ll_stack_table,  NULL};

const char *const ll_script_names[] = {"varied", "steady", "idle", "peek", "hold", NULL};
