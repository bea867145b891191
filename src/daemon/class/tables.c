/* The tables of what a teacher sets and what a member asks for. */
#include "daemon/class/class.h"

#include <string.h>

const char *const ll_class_phases[] = {
    [LL_CLASS_LOBBY] = "lobby",   [LL_CLASS_PREDICT] = "predict", [LL_CLASS_LOCKED] = "locked",
    [LL_CLASS_RUN] = "run",       [LL_CLASS_STOPPED] = "stopped", [LL_CLASS_EXPLAIN] = "explain",
    [LL_CLASS_CHANGE] = "change", [LL_CLASS_FREE] = "free",       NULL};
const char *const ll_class_roles[] = {
    [LL_CLASS_WATCH] = "watch", [LL_CLASS_PLAY] = "play", [LL_CLASS_COPY] = "copy", NULL};

const char *const ll_class_reaches[] = {
    [LL_CLASS_ONE] = "", [LL_CLASS_LATER] = "later", [LL_CLASS_ADDRESS] = "address", NULL};

static const char *const doors[] = {[LL_CLASS_OPEN] = "open", [LL_CLASS_CLOSED] = "closed", NULL};

static ll_status check_settings(const void *object, const char *path)
{
    const ll_class_settings *s = object;
    (void)path;
    for (const char *at = s->lesson; *at; at++) {
        if (!strchr("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-/", *at))
            return ll_field_error(LL_BAD_INPUT, "lesson",
                                  "lesson: must be an id of letters, digits, `_`, `-` and `/`; got `%.40s`.",
                                  s->lesson);
    }
    if (s->phase == LL_CLASS_PREDICT && s->choices < 1)
        return ll_field_error(LL_BAD_INPUT, "choices", "choices: must be 1 to %d in phase predict; got 0.",
                              LL_CLASS_CHOICES);
    return ll_ok();
}

static const ll_param settings_rows[] = {
    {LL_PARAM_ROW("phase", CHOICE, ll_class_settings, phase), .choices = ll_class_phases,
     .help = "Phase of the lesson."},
    {LL_PARAM_ROW("lesson", TEXT, ll_class_settings, lesson), .max = LL_CLASS_LESSON_MAX,
     .help = "Id of the lesson; empty: none."},
    {LL_PARAM_ROW("step", INT, ll_class_settings, step), .max = 999, .help = "Step of the lesson."},
    {LL_PARAM_ROW("choices", INT, ll_class_settings, choices), .max = LL_CLASS_CHOICES,
     .help = "Choices of this step's question; 0: it has none."},
    {LL_PARAM_ROW("stop_tick", INT, ll_class_settings, stop_tick), .max = 1e12, .unit = "ticks",
     .help = "Tick at which phases run and change pause the board; 0: none."},
    {LL_PARAM_ROW("frozen", BOOL, ll_class_settings, frozen), .help = "The board and all copies are paused."},
    {LL_PARAM_ROW("together", BOOL, ll_class_settings, together), .help = "Every page shows the board."},
    {LL_PARAM_ROW("door", CHOICE, ll_class_settings, door), .choices = doors,
     .help = "Closed: no new device joins; members come back."},
};

const ll_param_table ll_class_table = {.name = "class",
                                       .help = "What the teacher sets.",
                                       LL_PARAM_ROWS(settings_rows, ll_class_settings),
                                       .check = check_settings};

static const ll_param join_rows[] = {
    {LL_PARAM_ROW("role", CHOICE, ll_class_wish, role), .choices = ll_class_roles,
     .help = "watch, play (a seat) or copy."},
    {LL_PARAM_ROW("player", INT, ll_class_wish, player), .min = -1, .max = LL_PLAYERS_MAX - 1,
     .default_value = -1, .help = "Of role play: whose seat; -1: any free one."},
    {LL_PARAM_ROW("fresh", BOOL, ll_class_wish, fresh),
     .help = "Of role copy: a new copy in place of the present one."},
};

const ll_param_table ll_class_join_table = {.name = "join",
                                            .help = "A request to join a class, or to change one's role.",
                                            LL_PARAM_ROWS(join_rows, ll_class_wish)};

static const ll_param vote_rows[] = {
    {LL_PARAM_ROW("step", INT, ll_class_ballot, step), .max = 999, .required = true,
     .help = "Step of the question."},
    {LL_PARAM_ROW("choice", INT, ll_class_ballot, choice), .max = LL_CLASS_CHOICES - 1, .required = true,
     .help = "Index of the choice."},
};

const ll_param_table ll_class_vote_table = {
    .name = "vote", .help = "A vote.", LL_PARAM_ROWS(vote_rows, ll_class_ballot)};
