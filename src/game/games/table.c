#include "game/core/game.h"

#include "game/games/games.h"

#define ROW(NAME) &ll_game_##NAME,
#define NAMED(NAME) #NAME,
#define TABLE(NAME) &ll_##NAME##_table,

const ll_game *const ll_games[] = {LL_GAMES(ROW) NULL};
const char *const ll_game_names[] = {LL_GAMES(NAMED) NULL};
const ll_param_table *const ll_game_tables[] = {LL_GAMES(TABLE) NULL};

const char *const ll_script_names[] = {"varied", "steady", "idle", "peek", "hold", "react", "turn", NULL};
