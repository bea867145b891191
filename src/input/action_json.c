#include "input/action_json.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include <cjson/cJSON.h>

static ll_status wrong(const char *path, const char *name, const char *sentence)
{
    char field[64];
    snprintf(field, sizeof field, "%s%s%s", path, path[0] ? "." : "", name);
    return ll_field_error(LL_BAD_INPUT, field, "%s %s", field, sentence);
}

static bool whole(const cJSON *value, double low, double high)
{
    return cJSON_IsNumber(value) && value->valuedouble >= low && value->valuedouble <= high &&
           value->valuedouble == floor(value->valuedouble);
}

static bool read_axes(const cJSON *axes, ll_action *action)
{
    if (!cJSON_IsArray(axes) || cJSON_GetArraySize(axes) > 2)
        return false;
    int i = 0;
    const cJSON *axis;
    cJSON_ArrayForEach(axis, axes)
    {
        if (!cJSON_IsNumber(axis) || !(fabs(axis->valuedouble) <= 1))
            return false;
        action->axis[i++] = (float)axis->valuedouble;
    }
    return true;
}

ll_status ll_action_parse(const cJSON *json, const char *path, int *player, ll_action *action)
{
    memset(action, 0, sizeof *action);
    *player = -1;
    if (!cJSON_IsObject(json))
        return ll_field_error(LL_BAD_INPUT, path, "input: must be an object with player, axes and buttons");
    const cJSON *member;
    _Static_assert(LL_PLAYERS_MAX - 1 == 63, "as the sentence says");
    cJSON_ArrayForEach(member, json)
    {
        if (strcmp(member->string, "player") == 0) {
            if (!whole(member, 0, LL_PLAYERS_MAX - 1))
                return wrong(path, "player", "must be a whole number from 0 to 63.");
            *player = (int)member->valuedouble;
        } else if (strcmp(member->string, "axes") == 0) {
            if (!read_axes(member, action))
                return wrong(path, "axes", "must be at most two numbers from -1 to 1.");
        } else if (strcmp(member->string, "buttons") == 0) {
            if (!whole(member, 0, 4294967295.0))
                return wrong(path, "buttons",
                             "must be a whole number from 0 to 4294967295, a bit per button.");
            action->buttons = (uint32_t)member->valuedouble;
        } else {
            return wrong(path, member->string, "is not known; an input has player, axes and buttons.");
        }
    }
    return *player < 0 ? wrong(path, "player", "is missing.") : ll_ok();
}
